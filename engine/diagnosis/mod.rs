//! When simulation and recording differ: detect, locate, name, model, show.
//!
//! The folders lead one way down, each using only those before it: `law`, `effects`, `dataset`, `fit`, `residual`, `search`,
//! `verdict`, `explain`. `run` goes through them all.

mod dataset;
pub mod effects;
mod explain;
mod fit;
pub mod impose;
mod law;
mod residual;
mod run;
mod search;
#[cfg(test)]
mod tests;
mod verdict;

pub use run::diagnose;
