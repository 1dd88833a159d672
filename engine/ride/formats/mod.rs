//! What files look like: CSV and its dialects, workbooks, FIT, MAT, arrays, compressed or not; each becomes a table.

pub mod arrays;
mod cells;
mod columns;
pub mod comments;
pub mod csv;
mod damage;
pub mod dialect;
pub mod fit;
pub mod format;
mod grouped;
mod head;
pub mod header;
mod labels;
mod layout;
mod level4;
mod level5;
pub mod loggers;
#[cfg(feature = "spreadsheets")]
pub mod markup;
pub mod mat;
mod matrix;
mod meant;
pub mod moment;
mod number;
pub mod pace;
mod rows;
pub mod source;
pub mod spreadsheet;
pub mod times;
pub mod track;
mod usual_time;
#[cfg(feature = "spreadsheets")]
pub mod workbook;
#[cfg(feature = "spreadsheets")]
pub mod xlsx;
pub mod zstd;
