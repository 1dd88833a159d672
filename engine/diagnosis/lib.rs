//! When simulation and recording differ: detect, locate, name, model, show.
//!
//! The folders lead one way down, each using only those before it: `policy` (every threshold that decides), `law`, `effects`, `dataset`, `fit`, `residual`, `search`,
//! `verdict`, `explain`, and last `study`, which asks the same of several rides. `run` goes through them all: `prepare`, `decide`, `show`.

mod assemble;
mod axle;
mod beside;
mod decide;
#[cfg(test)]
mod example;
mod explain;
pub mod impose;
pub mod judge;
pub mod no_road;
pub mod policy;
pub mod prepare;
mod residual;
mod run;
pub mod search;
pub mod study;
mod table;
pub mod tried;
pub mod validation;
mod verdict;

pub use run::{diagnose, scores};
pub use table::as_diagnosed;
pub use veloid_model::{effects, law};
