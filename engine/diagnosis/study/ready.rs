//! What a study begins with.

use veloid_core::bicycle::PerAxle;
use veloid_methods::output_error::Split;
use veloid_model::dataset::Dataset;
use veloid_model::fit::Model;
use veloid_report::Parameters;
use veloid_report::diagnosis::Diagnosis;

/// A ride that takes part.
pub struct Ready {
    pub name: String,
    /// What is searched, its plain model, and which part is fitted.
    pub dataset: Dataset,
    pub plain: Model,
    pub split: Split,
    pub warnings: Vec<String>,
    /// By how much k (N/m) and B (N s/m) move when what interpolation takes off the road is put back.
    pub interpolation: PerAxle<Parameters>,
    /// What it says alone.
    pub alone: Diagnosis,
}
