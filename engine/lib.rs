//! Bicycle identification: a ride goes in, a [`report::Report`] comes out.
//!
//! The folders follow the data flow: [`ride`] → [`observer`] → [`least_squares`] → [`swarm`] →
//! [`output_error`] → [`diagnosis`] → [`report`]. [`bicycle`] holds the physical parameters and
//! [`simulate`](mod@simulate) the exact solution of the vertical model, paper eq. (1), that all of them share.
//!
//! Everything is SI unless a name says otherwise. No HTTP, SQL or async code lives here.
//!
//! Who uses it as a library needs [`Ride::from_arrays`] or [`read`], [`Bike`], [`Settings`], [`identify`] with its [`Report`], and
//! [`simulate()`]; `engine/examples/` shows each. The stages [`observe()`], [`conclude`], [`diagnose`] and [`assemble`] are what
//! `identify` runs in a row.

#![warn(missing_docs)]

pub mod bicycle;
pub mod diagnosis;
pub mod document;
mod error;
mod latent_road;
pub mod least_squares;
mod mistakes;
mod numerics;
pub mod observer;
pub mod output_error;
mod pipeline;
pub mod plant;
mod progress;
pub mod replay;
pub mod report;
pub mod ride;
mod roll;
mod settings;
pub mod simulate;
#[cfg(test)]
#[path = "../tests/skips.rs"]
mod skips;
pub mod swarm;
pub mod uncertainty;

pub use bicycle::Bike;
pub use diagnosis::impose::{Imposed, ride as simulate};
pub use document::{seen, unseen};
pub use error::{Divergence, EngineError, ImposedProblem, RideProblem, SettingProblem};
pub use pipeline::{
    Ridden, assemble, conclude, diagnose, identify, observe, read, result_of, study,
};
pub use progress::{Progress, Silent};
pub use report::Report;
pub use report::diagnosis::Diagnosis;
pub use report::stages::{Conclusion, Observed};
pub use ride::Ride;
pub use settings::{Objective, Settings};
