//! Mixed-effects regression: what a value depends on, with a level of its own for each bicycle (a random intercept), each ride's
//! known error, and what rides differ by beyond both. Variances by restricted maximum likelihood (Patterson and
//! Thompson 1971, doi:10.1093/biomet/58.3.545), coefficients by generalised least squares at them.

mod confounding;
mod departures;
mod fit;
mod gain;
mod reml;

pub use confounding::{Confounding, Refusal};
pub use departures::{Departure, with_departures};
pub use fit::{Coefficient, Fit, Prediction};

use nalgebra::{DMatrix, DVector};

/// What is regressed: one row per ride.
pub struct Data {
    /// The bicycle of each ride, counted from 0 without gaps.
    pub bikes: Vec<usize>,
    pub values: DVector<f64>,
    /// Standard error of each value.
    pub errors: DVector<f64>,
    /// When each was ridden (days).
    pub dates: Vec<f64>,
    /// One column per fact.
    pub facts: DMatrix<f64>,
}

impl Data {
    pub fn rides(&self) -> usize {
        self.values.len()
    }

    pub fn bicycles(&self) -> usize {
        self.bikes.iter().max().map_or(0, |last| last + 1)
    }
}

#[cfg(test)]
mod seasons;
#[cfg(test)]
mod tests;
