use std::net::SocketAddr;
use std::path::{Path, PathBuf};

use uuid::Uuid;
use veloid_engine::ride::ReadError;
use veloid_engine::{EngineError, Incomparable, ModelError};

use super::client::ClientError;
use crate::built::NotBuilt;
use crate::erasure::EraseError;
use crate::export::NoModel;
use crate::installation::InstallationError;
use crate::jobs::{ChildError, Fault};
use crate::options::OptionsError;
use crate::store::MigrateError;
use crate::store::snapshot::SnapshotError;

/// Why a command ended badly.
#[derive(Debug, thiserror::Error)]
pub enum CliError {
    /// A file that the user named cannot be read or written.
    #[error("{}: {source}", .path.display())]
    File {
        path: PathBuf,
        source: std::io::Error,
    },
    /// A disk that the process keeps things on has no room.
    #[error(
        "{}: the disk is full, {bytes} bytes are free: make room and start again ({source})", .path.display()
    )]
    Full {
        path: PathBuf,
        bytes: u64,
        source: Box<CliError>,
    },
    /// The description of a logger.
    #[error("{}: {cause}", .path.display())]
    Logger { path: PathBuf, cause: String },
    /// The bike file; the message holds line and column.
    #[error("{}: {source}", .path.display())]
    Bike { path: PathBuf, source: EngineError },
    #[error(
        "{bikes} bike files for {rides} rides: give one for all, or one for each, in the same order"
    )]
    Bikes { bikes: usize, rides: usize },
    #[error(transparent)]
    Ride(#[from] ReadError),
    /// The same, with options that name columns of the file.
    #[error("{source}; try {options}")]
    Unread { source: ReadError, options: String },
    #[error(transparent)]
    Options(#[from] OptionsError),
    #[error(transparent)]
    Engine(#[from] EngineError),
    #[error("{}: another veloid uses this data; several can only share PostgreSQL", .0.display())]
    Locked(PathBuf),
    #[error(
        "{0} can be reached from other machines and there is no valid key: create one with `veloid key create`, \
         or use `--open` to serve everyone"
    )]
    NoKeys(SocketAddr),
    #[error(
        "`--keys` requires a key from everyone and there is no valid one: create one with `veloid key create`, \
         or omit `--keys` to serve this machine alone without keys"
    )]
    NoKeysAskedFor,
    #[error("there is no valid key {0}")]
    NoSuchKey(Uuid),
    #[error("there is no session {0}")]
    NoSuchSession(Uuid),
    #[error(
        "the database is PostgreSQL: copy it with pg_dump and pg_restore, and the raw files with the tools of their store, \
         such as bucket versions"
    )]
    OnPostgres,
    #[error("{}: there is no such database", .0.display())]
    NoDatabase(PathBuf),
    #[error(
        "the PostgreSQL database contains no installation of veloid: is DATABASE_URL right? `veloid serve`, `worker`, `migrate` \
         and `key create` create one"
    )]
    NoSchema,
    #[error("{}: not empty, expected a new or an empty folder", .0.display())]
    NotEmpty(PathBuf),
    #[error(
        "{lost} of {of} raw files are missing or damaged (listed above); everything else was copied"
    )]
    FilesLost { lost: usize, of: usize },
    #[error("{}: the disk is full; the copy takes {bytes} bytes, and none of it was left there", .folder.display())]
    NoRoom { folder: PathBuf, bytes: u64 },
    #[error("{}: line {line} is not a SHA-256, two blanks and a path", .path.display())]
    Manifest { path: PathBuf, line: usize },
    #[error(
        "{}: {count} differences from its SHA256SUMS (listed above), nothing was restored; to restore the backup as it is, \
         remove that file", .folder.display()
    )]
    NotAsWritten { folder: PathBuf, count: usize },
    #[error("{0} problems found (listed above)")]
    Found(u64),
    #[error(transparent)]
    Snapshot(#[from] SnapshotError),
    #[error("database: {0}")]
    Database(#[from] sqlx::Error),
    #[error(transparent)]
    Erase(#[from] EraseError),
    #[error(transparent)]
    Installation(#[from] InstallationError),
    #[error(transparent)]
    Migrate(#[from] MigrateError),
    #[error(transparent)]
    Work(#[from] Fault),
    #[error(transparent)]
    Child(#[from] ChildError),
    #[error(transparent)]
    NoModel(#[from] NoModel),
    /// A file that is to be a model.
    #[error("{}: {source}", .path.display())]
    Model { path: PathBuf, source: ModelError },
    #[error(transparent)]
    Incomparable(#[from] Incomparable),
    #[error("{count} of {of} rides could not be compared (listed above)")]
    NotCompared { count: usize, of: usize },
    #[error("compute threads: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
    #[error(transparent)]
    NotBuilt(#[from] NotBuilt),
    #[error("queue: {0}")]
    Queue(#[from] riverqueue::Error),
    #[error("request: {0}")]
    Request(#[from] ClientError),
    #[error("not ready: {0}")]
    NotReady(String),
    #[error("report: {0}")]
    Json(#[from] serde_json::Error),
    #[error("{0}")]
    Io(#[from] std::io::Error),
}

impl CliError {
    /// 2 where the input is at fault, 1 for anything else.
    pub fn exit_status(&self) -> u8 {
        match self {
            CliError::Bike { .. }
            | CliError::Bikes { .. }
            | CliError::Ride(_)
            | CliError::Unread { .. }
            | CliError::Model { .. }
            | CliError::Incomparable(_)
            | CliError::NotCompared { .. }
            | CliError::Options(_) => 2,
            CliError::File { source, .. } => match source.kind() {
                std::io::ErrorKind::NotFound
                | std::io::ErrorKind::InvalidData
                | std::io::ErrorKind::IsADirectory => 2,
                _ => 1,
            },
            CliError::Engine(error) if error.is_input() => 2,
            CliError::Found(count) => u8::try_from(*count).unwrap_or(100).min(100),
            _ => 1,
        }
    }
}

impl CliError {
    /// A failure to read or write this file.
    pub fn of_file(path: &Path) -> impl FnOnce(std::io::Error) -> CliError {
        let path = path.to_owned();
        move |source| CliError::File { path, source }
    }
}
