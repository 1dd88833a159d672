//! Bicycle identification: a ride goes in, a [`report::Report`] comes out.
//!
//! The folders follow the data flow: [`ride`] → [`observer`] → [`least_squares`] → [`swarm`] →
//! [`output_error`] → [`diagnosis`] → [`report`]. [`bicycle`] holds the physical parameters and
//! [`simulate`](mod@simulate) the exact solution of the vertical model, paper eq. (1), that all of them share.
//!
//! Everything is SI unless a name says otherwise. No HTTP, SQL or async code lives here.
//!
//! Users of the library need [`from_arrays`] or [`read`], [`Bike`], [`Settings`], [`identify`] with its [`Report`], and
//! [`simulate()`]; `engine/examples/` shows each. The stages [`observe()`], [`conclude`], [`diagnose`] and [`assemble`] are what
//! `identify` runs in a row.

#![warn(missing_docs)]

mod pipeline;
pub mod replay;
#[cfg(test)]
#[path = "../tests/skips.rs"]
mod skips;

pub use pipeline::{
    ModelError, Ridden, assemble, compare, conclude, diagnose, from_arrays, identify, observe,
    read, read_model, result_of, scores, study, validate,
};
pub use veloid_core::document::{seen, unseen};
pub use veloid_core::{
    Bike, Divergence, EngineError, ImposedProblem, Objective, Progress, RideProblem,
    SettingProblem, Settings, Silent,
};
pub use veloid_core::{bicycle, document, plant};
pub use veloid_diagnosis as diagnosis;
pub use veloid_diagnosis::impose::{Imposed, ride as simulate, sensed};
pub use veloid_diagnosis::validation::{Incomparable, Start, predict};
pub use veloid_methods::{least_squares, observer, output_error, simulate, swarm, uncertainty};
pub use veloid_report as report;
pub use veloid_report::Report;
pub use veloid_report::diagnosis::Diagnosis;
pub use veloid_report::stages::{Conclusion, Observed};
pub use veloid_ride as ride;
pub use veloid_ride::Ride;
