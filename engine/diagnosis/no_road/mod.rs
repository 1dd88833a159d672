//! Missing physics without a sensor for the road.
//!
//! The mass times the acceleration of an axle is the force of its tyre, so that the axle's law, solved for the rate of the deflection,
//! gives the road: u' = z' + d'. A wheelbase later that road drives the other axle. What it leaves of that axle's acceleration
//! belongs to sensors, to the road that the wheels do not share, or to physics that one of the laws leaves out. Nothing is assumed of
//! the road. docs/latent-road.md says what no such ride can show.
//!
//! `record` → `model` → `law`, `motion` → `predict` → `nuisance` → `fit` → `spectral` → `settle` → `search` → `evidence` → `judged` → `report` (`shown`, `turned`) →
//! `verdict`.

mod evidence;
mod fit;
mod gates;
mod judged;
mod late;
mod law;
mod lines;
mod model;
mod motion;
mod nuisance;
mod predict;
mod record;
mod report;
mod roles;
mod search;
mod settle;
mod shown;
mod spectral;
#[cfg(test)]
mod tests;
mod turned;
mod verdict;

pub use verdict::diagnose;
