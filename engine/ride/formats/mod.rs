//! What files look like: CSV and its dialects, workbooks, FIT, MAT, arrays, compressed or not; each becomes a table.

pub mod arrays;
mod cells;
pub mod comments;
pub mod csv;
pub mod dialect;
pub mod fit;
pub mod format;
pub mod header;
mod level5;
#[cfg(feature = "spreadsheets")]
pub mod markup;
pub mod mat;
pub mod moment;
pub mod source;
pub mod spreadsheet;
pub mod track;
#[cfg(feature = "spreadsheets")]
pub mod workbook;
#[cfg(feature = "spreadsheets")]
pub mod xlsx;
pub mod zstd;
