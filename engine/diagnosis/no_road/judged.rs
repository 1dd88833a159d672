//! What a verdict rests on.

use super::evidence::Evidence;
use super::fit::Fit;
use super::late::Late;
use super::record::Record;
use super::search::Found;
use crate::judge::table::Judgement;
use veloid_core::bicycle::{Bike, PerAxle};
use veloid_model::fit::Term;
use veloid_model::law::Scale;
use veloid_report::diagnosis::Verdict;

/// Everything that a verdict rests on.
pub struct Judged<'a> {
    pub bike: &'a Bike,
    pub record: &'a Record,
    pub scales: &'a PerAxle<Scale>,
    pub candidates: &'a [Term],
    pub found: &'a Found,
    pub evidence: &'a Evidence,
    pub judgement: &'a Judgement,
    pub late: Option<Late>,
    pub verdict: Verdict,
    /// The model that the verdict speaks of.
    pub best: &'a Fit,
    /// Sets of terms that explain the ride as well as the best one.
    pub tied: Vec<Vec<Term>>,
}
