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
mod checked;
#[allow(missing_docs)]
pub mod diagnosis;
mod error;
mod finite;
#[cfg(test)]
mod hostile;
mod identify;
pub mod json;
mod laser_error;
mod latent_road;
#[allow(missing_docs)]
pub mod least_squares;
mod mass_error;
mod mistakes;
#[allow(missing_docs)]
pub mod number;
mod numerics;
mod observe;
#[allow(missing_docs)]
pub mod observer;
#[allow(missing_docs)]
pub mod output_error;
mod progress;
#[allow(missing_docs)]
pub mod report;
pub mod ride;
mod road_doubt;
mod road_noise;
mod sensor_noise;
mod settings;
pub mod simulate;
#[cfg(test)]
#[path = "../tests/skips.rs"]
mod skips;
mod study;
#[allow(missing_docs)]
pub mod swarm;
mod synchronise;
mod unseen;

pub use bicycle::Bike;
pub use diagnosis::impose::{Imposed, ride as simulate};
pub use error::EngineError;
pub use identify::{assemble, conclude, diagnose, identify, observe};
pub use progress::{Progress, Silent};
pub use report::Report;
pub use report::diagnosis::Diagnosis;
pub use report::stages::{Conclusion, Observed};
pub use ride::Ride;
pub use settings::{Objective, Settings};
pub use study::{Ridden, study};
pub use synchronise::read;
pub use unseen::is_unseen;
