//! When simulation and recording differ: detect, locate, name, model, show.
//!
//! The folders lead one way down: each uses only those above it in this list, `run` uses them all.

mod law;

pub mod effects;

mod dataset;

mod fit;

mod residual;

mod search;

mod verdict;

mod explain;

pub mod impose;
mod run;
#[cfg(test)]
mod tests;

pub use run::diagnose;
