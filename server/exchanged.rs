//! Why nothing may be written: database or store of raw files are not those that this process began with, or are damaged
//! (docs/decisions/installation.md).

use std::io;

#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Exchanged {
    /// The database's file is missing or another one.
    #[error("{0}")]
    File(String),
    /// The same of SQLite's write-ahead log.
    #[error("{0}")]
    Log(String),
    /// The database does not have the id of the installation.
    #[error("{0}")]
    Database(String),
    /// The store of raw files does not have it.
    #[error("{0}")]
    Store(String),
    #[error("{0}")]
    Damaged(String),
}

impl Exchanged {
    /// The part for every client; the rest is for operators.
    pub fn what(&self) -> &'static str {
        match self {
            Exchanged::File(_) | Exchanged::Log(_) | Exchanged::Database(_) => {
                "the database was exchanged"
            }
            Exchanged::Store(_) => "the store of raw files was exchanged",
            Exchanged::Damaged(_) => "the database is damaged",
        }
    }

    /// The cause of an error, where it is one of these.
    pub fn behind(error: &io::Error) -> Option<&Self> {
        error.get_ref()?.downcast_ref()
    }
}

impl From<Exchanged> for io::Error {
    fn from(exchanged: Exchanged) -> Self {
        io::Error::other(exchanged)
    }
}

impl From<Exchanged> for sqlx::Error {
    fn from(exchanged: Exchanged) -> Self {
        sqlx::Error::Io(exchanged.into())
    }
}
