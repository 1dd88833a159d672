//! The same ride from its other end: the rear wheel gives the road, and the front one rides over it.

use super::fit::{Fit, Frame};
use super::model::Model;
use super::nuisance::Course;
use super::record::Record;
use super::settle::settled;
use veloid_core::bicycle::{Axle, PerAxle};
use veloid_model::law::Scale;
use veloid_ride::Ride;

/// Iterations of fits that begin where the other direction has ended.
const ITERATIONS: usize = 6;
const EXACT: f64 = 0.1;

/// What the rear wheel's road makes of models.
pub struct Turned {
    pub record: Record,
    pub courses: Vec<Course>,
    pub plain: Fit,
    pub best: Fit,
}

impl Turned {
    pub fn new(
        ride: &Ride,
        wheelbase_m: f64,
        scales: &PerAxle<Scale>,
        [plain, best]: [&Model; 2],
        [late, gain]: [f64; 2],
    ) -> Option<Self> {
        let record = Record::new(ride, wheelbase_m, Axle::Rear).ok()?;
        let (best, courses) = settled(&record, scales, best, [-late, 1.0 / gain])?;
        let frame = Frame::around(&record, scales, &courses, &best.model)?;
        let plain = frame.fit(plain, ITERATIONS, EXACT)?;
        let best = frame.fit(&best.model, ITERATIONS, EXACT)?;
        Some(Self {
            record,
            courses,
            plain,
            best,
        })
    }

    /// What the best model gains over the plain one, of twice the log likelihood, with what its numbers cost.
    pub fn gained(&self) -> f64 {
        let numbers = (self.best.model.slots().len() - self.plain.model.slots().len()) as f64;
        self.plain.cost - self.best.cost - 0.5 * numbers * (self.record.values() as f64).ln()
    }
}
