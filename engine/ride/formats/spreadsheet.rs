//! What an Excel workbook (.xlsx) is known by, whether or not this build reads one.

use memchr::memmem;

/// What a workbook is called.
pub const FORMAT: &str = "xlsx";

/// Whether it may be one by its first bytes, which are those of any zip archive.
pub fn is_zip(bytes: &[u8]) -> bool {
    bytes.starts_with(b"PK\x03\x04")
}

pub fn is_xlsx(bytes: &[u8]) -> bool {
    is_zip(bytes) && memmem::find(bytes, b"xl/workbook.xml").is_some()
}
