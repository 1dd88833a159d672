//! When simulation and recording differ: detect, locate, name, model, show.
//!
//! The folders lead one way down, each using only those before it: `policy` (every threshold that decides), `law`, `effects`, `dataset`, `fit`, `residual`, `search`,
//! `verdict`, `explain`, and last `study`, which asks the same of several rides. `run` goes through them all: `prepare`, `decide`, `show`.

mod assemble;
mod axle;
mod dataset;
mod decide;
pub mod effects;
#[cfg(test)]
mod example;
mod explain;
mod fit;
pub(crate) mod impose;
pub(crate) mod law;
mod policy;
pub(crate) mod prepare;
mod residual;
mod run;
mod search;
pub(crate) mod study;
mod table;
#[cfg(test)]
mod tests;
mod verdict;

pub(crate) use run::diagnose;
pub use table::as_diagnosed;
