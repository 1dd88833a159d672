//! Models that were never fitted, and a search from them.

pub use veloid_model::example::*;

use veloid_core::Silent;
use veloid_model::dataset::{Budget, Dataset};

use crate::search::Search;

/// A search from the plain model on, with nothing to search.
pub fn search(dataset: &Dataset) -> Search<'_> {
    let budget = Budget::new(1e3, dataset.samples);
    Search {
        fitter: fitter(dataset),
        plain: model(dataset, &[]),
        held: train_end(dataset.samples)..dataset.samples,
        candidates: Vec::new(),
        alpha: 0.05,
        seed: 1,
        until: budget.first,
        budget,
        progress: &Silent,
    }
}
