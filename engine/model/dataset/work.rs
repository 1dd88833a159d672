//! What a diagnosis costs, counted: the same on every machine.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Steps of the integrator so far, each for eight parameter sets on one axle; copies of it count together.
#[derive(Clone, Debug, Default)]
pub struct Work(Arc<AtomicU64>);

impl Work {
    pub fn add(&self, steps: u64) {
        self.0.fetch_add(steps, Ordering::Relaxed);
    }

    /// The same in every run where it is asked while nothing else computes.
    pub fn done(&self) -> u64 {
        self.0.load(Ordering::Relaxed)
    }
}

/// Samples (of one axle) that a short record's budget is made for at least: what a search costs at all does not shrink with it.
const LEAST: usize = 4000;
/// Part that the search by likelihood may spend; the second look at what it cannot explain has the rest.
const FIRST: f64 = 0.6;

/// The work that a diagnosis may take.
#[derive(Clone, Copy, Debug)]
pub struct Budget {
    /// All of it.
    pub steps: u64,
    /// Of these the search by likelihood.
    pub first: u64,
}

impl Budget {
    /// `per_sample` steps for each of so many samples, of all axles together.
    pub fn new(per_sample: f64, samples: usize) -> Self {
        let steps = per_sample * samples.max(LEAST) as f64;
        Self {
            steps: steps as u64,
            first: (FIRST * steps) as u64,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn copies_of_a_count_count_together() {
        let work = Work::default();
        let copy = work.clone();
        work.add(3);
        copy.add(4);
        assert_eq!((work.done(), copy.done()), (7, 7));
    }

    #[test]
    fn a_short_record_has_the_budget_of_a_longer_one() {
        let long = Budget::new(2.0, 5 * LEAST);
        assert_eq!(long.steps, 2 * 5 * LEAST as u64);
        assert_eq!(long.first, (FIRST * long.steps as f64) as u64);
        assert_eq!(Budget::new(2.0, 7).steps, 2 * LEAST as u64);
    }
}
