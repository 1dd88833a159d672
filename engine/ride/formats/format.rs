//! Which format a file has: a table from any of them, or from arrays.

use crate::channels::table::Table;
use crate::error::{Problem, ReadError};
use crate::file::{Content, RideFile};
use crate::formats::{arrays, csv, fit, mat};
use crate::options::ReadOptions;

pub fn table(file: &RideFile<'_>, options: &ReadOptions) -> Result<Table, ReadError> {
    match file.content {
        Content::Bytes(bytes) => of_bytes(bytes, options),
        Content::Arrays(given) => arrays::read(&given, options),
    }
}

pub fn of_bytes(bytes: &[u8], options: &ReadOptions) -> Result<Table, ReadError> {
    if bytes.is_empty() {
        return Err(Problem::EmptyFile.into());
    }
    if mat::is_mat(bytes) {
        mat::read(bytes, options)
    } else if fit::is_fit(bytes) {
        fit::read(bytes, options)
    } else {
        csv::read(bytes, options)
    }
}
