//! Which format a file has: a table from any of them.

use super::error::{Problem, ReadError};
use super::options::ReadOptions;
use super::table::Table;
use super::{csv, fit, mat};

pub(super) fn table(bytes: &[u8], options: &ReadOptions) -> Result<Table, ReadError> {
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
