//! What parent and child tell each other.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::jobs::hub::Heard;
use crate::jobs::task::{Outcome, Subject, Task};

/// Parent to child.
#[derive(Serialize, Deserialize)]
pub struct Order {
    /// Left out where the child's last task was of the same job.
    pub subject: Option<Arc<Subject>>,
    pub task: Task,
}

/// Child to parent: any number of times how far it is, then how the task ended.
#[derive(Serialize, Deserialize)]
pub enum Word {
    Meanwhile(Vec<Heard>),
    Done(Outcome),
    /// An error of the engine.
    Refused {
        is_input: bool,
        message: String,
    },
    Panicked(String),
}
