//! What a child sends its parent, which sends it orders.

use serde::{Deserialize, Serialize};

use crate::jobs::hub::Heard;
use crate::jobs::task::Outcome;

/// Child to parent: any number of times how far it is, then how the order ended.
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
