//! What can go wrong in a stage, and what it means.

use std::io;
use std::time::Duration;

use veloid_engine::EngineError;

use super::budget::{Budget, OverBudget};
use super::isolate::Ended;
use super::unread::{Unread, Unreadable};
use crate::exchanged::Exchanged;
use crate::files::FileError;
use crate::store;
use crate::store::job::Failure;
use crate::store::result::DocumentError;

/// Why a stage did not end well.
#[derive(Debug, thiserror::Error)]
pub enum Fault {
    #[error(transparent)]
    Engine(EngineError),
    /// The same, as a child process shows it.
    #[error("{message}")]
    Refused { is_input: bool, message: String },
    #[error(transparent)]
    Read(#[from] Unreadable),
    #[error(transparent)]
    Budget(#[from] OverBudget),
    #[error("reading the ride needs more memory than the {:.1} GB allowed", .0.0 as f64 / 1e9)]
    TooLargeToRead(Budget),
    #[error("the group has {0} requests that wait for a file to be read, its limit")]
    Crowded(usize),
    #[error("the stage took longer than {} s", .0.as_secs())]
    Deadline(Duration),
    #[error("the computation failed: {0}")]
    Panic(String),
    /// The child process that computed it ended by itself.
    #[error("{0}")]
    Died(String),
    /// The same, when it was refused more memory.
    #[error("{0}")]
    OutOfMemory(String),
    /// It was ended from outside, by the system for want of memory perhaps: whose fault that was shows when
    /// the job has this process to itself.
    #[error("{0}")]
    Killed(String),
    /// It was asked to end, as all processes of a service are.
    #[error("the computing process was asked to end")]
    Interrupted,
    #[error("the child process answered a different request")]
    Mismatch,
    #[error("child process: {0}")]
    Child(io::Error),
    /// Asked to stop: the job was cancelled, or this process shuts down.
    #[error("stopped")]
    Stopped,
    /// Another job has to go first.
    #[error("another job has priority")]
    GivesWay,
    #[error("the queue's row has no client")]
    NoClient,
    #[error(transparent)]
    File(#[from] FileError),
    /// What an earlier stage stored.
    #[error(transparent)]
    Document(DocumentError),
    /// A report that a child process was given to draw.
    #[error("the stored report is malformed: {0}")]
    Report(String),
    /// A model and a ride that have nothing in common.
    #[error("{0}")]
    Incomparable(String),
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
            Fault::Refused { is_input: true, .. } => "input",
            Fault::Engine(_) | Fault::Refused { .. } => "engine",
            Fault::Read(_) => "input",
            Fault::File(FileError::Missing(_) | FileError::Altered { .. }) => "file",
            Fault::Budget(_) | Fault::TooLargeToRead(_) => "memory",
            Fault::Deadline(_) => "deadline",
            Fault::Panic(_) | Fault::Died(_) | Fault::OutOfMemory(_) => "crash",
            Fault::Document(_) => "internal",
            _ => return None,
        };
        Some(Failure::new(kind, self.to_string()))
    }

    /// What it means where nothing else was computed.
    pub(super) fn when_alone(self) -> Self {
        match self {
            Fault::Killed(why) => Fault::Died(format!("{why}, twice, the second time alone")),
            fault => fault,
        }
    }

    pub(super) fn is_outage(&self) -> bool {
        match self {
            Fault::Database(error) | Fault::Queue(riverqueue::Error::Database(error)) => {
                store::is_outage(error)
            }
            Fault::File(FileError::Store(error)) => Exchanged::behind(error).is_some(),
            _ => false,
        }
    }

    /// What makes the database suspect.
    pub(super) fn damage(&self) -> Option<&sqlx::Error> {
        match self {
            Fault::Database(error) | Fault::Queue(riverqueue::Error::Database(error)) => {
                store::is_damage(error).then_some(error)
            }
            _ => None,
        }
    }
}

impl From<Ended> for Fault {
    fn from(ended: Ended) -> Self {
        match ended {
            Ended::Refused { is_input, message } => Fault::Refused { is_input, message },
            Ended::Panicked(text) => Fault::Panic(text),
            Ended::Died(why) => Fault::Died(why),
            Ended::OutOfMemory(why) => Fault::OutOfMemory(why),
            Ended::Killed(why) => Fault::Killed(why),
            Ended::Asked => Fault::Interrupted,
            Ended::Pipe(error) => Fault::Child(error),
        }
    }
}

impl From<DocumentError> for Fault {
    fn from(error: DocumentError) -> Self {
        match error {
            DocumentError::Database(error) => Fault::Database(error),
            error => Fault::Document(error),
        }
    }
}

impl From<Unread> for Fault {
    fn from(unread: Unread) -> Self {
        match unread {
            Unread::Ride(error) => Fault::Read(error),
            Unread::Budget(error) => Fault::Budget(error),
            Unread::Report(error) => Fault::Report(error),
            Unread::Incomparable(why) => Fault::Incomparable(why),
            unread => Fault::Child(io::Error::other(unread)),
        }
    }
}
