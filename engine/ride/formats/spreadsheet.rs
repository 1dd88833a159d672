//! What an Excel workbook (.xlsx) is known by, whether or not this build reads one.

use memchr::memmem;

/// What a workbook is called.
pub const FORMAT: &str = "xlsx";

pub fn is_xlsx(bytes: &[u8]) -> bool {
    bytes.starts_with(b"PK\x03\x04") && memmem::find(bytes, b"xl/workbook.xml").is_some()
}
