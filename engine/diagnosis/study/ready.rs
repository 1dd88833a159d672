//! What a study begins with.

use veloid_core::bicycle::PerAxle;
use veloid_methods::output_error::Split;
use veloid_model::dataset::Dataset;
use veloid_model::fit::Model;
use veloid_report::diagnosis::Diagnosis;
use veloid_report::{Estimate, Parameters};

/// A ride that takes part.
pub struct Ready {
    pub name: String,
    /// What is searched, its plain model, and which part is fitted.
    pub dataset: Dataset,
    pub plain: Model,
    pub split: Split,
    pub warnings: Vec<String>,
    /// Output error's estimates, whose errors hold whatever the noise is, which whitened ones do not where a lightly damped axle rings.
    pub output_error: PerAxle<Estimate>,
    /// By how much k (N/m) and B (N s/m) move when what interpolation takes off the road is put back.
    pub interpolation: PerAxle<Parameters>,
    /// By how much the mass's deviation moves them, alike on all rides.
    pub mass: PerAxle<Parameters>,
    /// By how much errors of the ride's own laser move them.
    pub laser: PerAxle<Parameters>,
    /// By how much noise in the ride's road channel moves those of a plain axle.
    pub road_noise: PerAxle<Parameters>,
    /// What it says alone.
    pub alone: Diagnosis,
}
