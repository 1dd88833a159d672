//! What a study begins with.

use crate::bicycle::PerAxle;
use crate::diagnosis::dataset::Dataset;
use crate::diagnosis::fit::Model;
use crate::output_error::Split;
use crate::report::Parameters;
use crate::report::diagnosis::Diagnosis;

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
