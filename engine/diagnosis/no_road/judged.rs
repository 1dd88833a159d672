//! What a verdict rests on.

use super::evidence::Evidence;
use super::fit::Fit;
use super::late::Late;
use super::model::Model;
use super::nuisance::Course;
use super::record::Record;
use super::search::Found;
use super::turned::Turned;
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
    /// The ride from its other end, where something was detected.
    pub turned: Option<&'a Turned>,
}

/// Models of one direction.
#[derive(Clone, Copy)]
pub struct View<'a> {
    pub record: &'a Record,
    pub scales: &'a PerAxle<Scale>,
    pub courses: &'a [Course],
    pub plain: &'a Model,
    pub best: &'a Model,
}

impl Judged<'_> {
    /// Each direction in which the ride was fitted.
    pub fn views(&self) -> impl Iterator<Item = View<'_>> {
        let there = View {
            record: self.record,
            scales: self.scales,
            courses: &self.found.courses,
            plain: &self.found.plain.model,
            best: &self.best.model,
        };
        let back = self.turned.map(|turned| View {
            record: &turned.record,
            courses: &turned.courses,
            plain: &turned.plain.model,
            best: &turned.best.model,
            ..there
        });
        std::iter::once(there).chain(back)
    }
}
