//! Stages that work on each other's results, and the whole way from a ride to its report.
#![allow(clippy::unwrap_used)]

mod decimated;
mod diagnosis;
mod impose;
mod inside;
mod interpolation;
mod least_squares;
mod limits;
mod mass;
mod mistaken_mass;
mod output_error;
mod plant;
#[path = "../../tests/skips.rs"]
mod skips;
mod swarm;
