//! What can go wrong in a stage, and what it means.

use std::io;
use std::time::Duration;

use veloid_engine::EngineError;
use veloid_engine::ride::ReadError;

use crate::store;
use crate::store::job::Failure;

/// Why a stage did not end well.
#[derive(Debug, thiserror::Error)]
pub enum Fault {
    #[error(transparent)]
    Engine(EngineError),
    #[error(transparent)]
    Read(#[from] ReadError),
    #[error("the stage took longer than {} s", .0.as_secs())]
    Deadline(Duration),
    #[error("the computation broke down: {0}")]
    Panic(String),
    /// Asked to stop: the job was cancelled, or this process shuts down.
    #[error("stopped")]
    Stopped,
    /// Another job has to go first.
    #[error("another job goes first")]
    GivesWay,
    #[error("the queue's row has no client")]
    NoClient,
    #[error("file store: {0}")]
    Files(#[from] io::Error),
    #[error("database: {0}")]
    Database(#[from] sqlx::Error),
    #[error("queue: {0}")]
    Queue(#[from] riverqueue::Error),
    #[error("task: {0}")]
    Task(#[from] tokio::task::JoinError),
}

impl Fault {
    /// The reason for the user where another attempt could only end the same way.
    pub(super) fn lasting(&self) -> Option<Failure> {
        let kind = match self {
            Fault::Engine(error) if error.is_input() => "input",
            Fault::Engine(_) => "engine",
            Fault::Read(_) => "input",
            Fault::Deadline(_) => "deadline",
            Fault::Panic(_) => "crash",
            _ => return None,
        };
        Some(Failure::new(kind, self.to_string()))
    }

    pub(super) fn is_outage(&self) -> bool {
        match self {
            Fault::Database(error) | Fault::Queue(riverqueue::Error::Database(error)) => {
                store::is_outage(error)
            }
            _ => false,
        }
    }
}
