//! Why nothing came of reading a ride, in a form that a child process can pass on.

use serde::{Deserialize, Serialize};
use veloid_engine::ride::ReadError;

use super::budget::OverBudget;

#[derive(Debug, thiserror::Error, Serialize, Deserialize)]
pub enum Unread {
    #[error(transparent)]
    Ride(#[from] Unreadable),
    #[error(transparent)]
    Budget(#[from] OverBudget),
    #[error("file of a ride: {0}")]
    File(String),
    #[error("stored report: {0}")]
    Report(String),
    #[error("{0}")]
    Incomparable(String),
}

/// A [`ReadError`] as it can be passed on.
#[derive(Debug, thiserror::Error, Serialize, Deserialize)]
#[error("{message}")]
pub struct Unreadable {
    message: String,
    pub kind: String,
    pub file: String,
    pub line: Option<usize>,
    /// Number and header text.
    pub column: Option<(usize, String)>,
}

impl From<ReadError> for Unreadable {
    fn from(error: ReadError) -> Self {
        let column = error.column();
        Self {
            message: error.to_string(),
            kind: error.kind().to_owned(),
            file: error.file().to_owned(),
            line: error.line(),
            column: column.map(|(number, header)| (number, header.to_owned())),
        }
    }
}
