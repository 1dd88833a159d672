//! One axle's record and its models, as they are compared.

use std::ops::Range;

use veloid_core::plant::Coefficients;
use veloid_methods::output_error::AxleFit;
use veloid_methods::simulate::linear::Input;

/// One axle's record.
pub struct Record<'a> {
    /// What models predict: the displacement (m), or the force (N) that answers where the motion is prescribed.
    pub measured: &'a [f64],
    /// Samples to trust.
    pub valid: &'a [bool],
    /// What drives the axle.
    pub input: &'a Input,
    /// Whether a road moves.
    pub has_road: bool,
    /// Samples that models were fitted to.
    pub train: Range<usize>,
}

/// Both models of it.
pub struct Models<'a> {
    /// The plain one.
    pub plain: &'a AxleFit,
    /// The one with effects, where any acts on the axle.
    pub extended: Option<Extended>,
}

/// A model with effects and its motion along the record.
pub struct Extended {
    /// Its spring, damper and mass.
    pub base: Coefficients,
    /// Measured minus simulated, zero where not valid.
    pub residual: Vec<f64>,
    /// Deflection (m) and its rate (m/s).
    pub deflection: Vec<f64>,
    /// Rate of the deflection (m/s).
    pub rate: Vec<f64>,
    /// Acceleration of the mass (m/s^2).
    pub acceleration: Vec<f64>,
}

impl Record<'_> {
    /// Applied force (N), where there is one that changes.
    pub fn force(&self) -> Option<&[f64]> {
        let force = self.input.force.as_ref().map(|(f, _)| f.as_slice())?;
        force.iter().any(|f| *f != force[0]).then_some(force)
    }

    /// Sample interval (s).
    pub fn step(&self) -> f64 {
        self.input.step
    }
}

/// To seven digits: half of the seventh is below 1e-6 of the number, and what is drawn needs no more.
pub fn short(x: f64) -> f64 {
    format!("{x:.6e}").parse().unwrap_or(x)
}

/// All of them.
pub fn shortened(values: impl IntoIterator<Item = f64>) -> Vec<f64> {
    values.into_iter().map(short).collect()
}
