//! One evidence and one table for all: every set of effects that a generator proposes is scored on held-out windows, and the table reads
//! the verdict from these scores. It stands beside `decide` until it is better on every suite (docs/decisions/judge.md).

mod gather;
pub mod numbers;
mod proposals;
pub mod scores;
pub mod table;
mod weights;

pub use gather::{Evidence, evidence};
pub use proposals::parameters;
