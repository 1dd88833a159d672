//! What became of a parameter, as a reader is shown it.

use statrs::distribution::{ContinuousCDF, StudentsT};

use crate::Rides;
use crate::follow::{Followed, follow};
use crate::least_squares::Fit;
use crate::robust::believed;

/// A number with its standard error and half the width of its 95 % interval, by Student's t.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimate {
    pub value: f64,
    pub std_error: f64,
    pub margin: f64,
}

/// A sudden change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// The first ride that shows it.
    pub ride: usize,
    pub size: Estimate,
}

/// A drift.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drift {
    /// The last ride before it.
    pub from: usize,
    /// Its last ride; none where it goes on.
    pub to: Option<usize>,
    pub per_day: Estimate,
}

/// What became of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Development {
    /// Oldest first.
    pub steps: Vec<Step>,
    /// Oldest first.
    pub drifts: Vec<Drift>,
    /// The level on the last ride, at the mean of every fact.
    pub now: Estimate,
    /// Standard deviation between rides beyond their own errors and these changes.
    pub between_rides: f64,
    /// The ride from which on nothing has changed, but for a drift that goes on.
    pub since: usize,
    /// The ride after which each change was reported first.
    pub reported: Vec<usize>,
}

impl Development {
    /// None where rides are as few as what is known of them, or all alike.
    pub fn of(data: Rides) -> Option<Self> {
        let Followed {
            structure,
            reported,
        } = follow(data);
        let facts = data.telling(data.rides.len());
        let columns = structure.columns(data.rides, &facts);
        let freedom = data.rides.len().checked_sub(columns.ncols())?;
        let student = StudentsT::new(0.0, 1.0, freedom as f64).ok()?;
        let values = believed(data.rides, &columns);
        let (between_rides, fit) = Fit::most_likely(data.rides, &values, &columns)?;
        let wide = student.inverse_cdf(0.975);
        let estimate = |value: f64, variance: f64| Estimate {
            value,
            std_error: variance.sqrt(),
            margin: wide * variance.sqrt(),
        };
        let coefficient = |i: usize| estimate(fit.coefficients[i], fit.covariance[(i, i)]);
        let first = 1 + facts.len();
        let steps = structure.steps().zip(first..);
        let steps: Vec<Step> = steps
            .map(|(ride, i)| Step {
                ride,
                size: coefficient(i),
            })
            .collect();
        let drifts = structure.drifts().into_iter().zip(first + steps.len()..);
        let before = |ride: usize| ride.saturating_sub(1);
        let drifts = drifts.map(|(span, i)| Drift {
            from: before(span.from),
            to: span.to.map(before),
            per_day: coefficient(i),
        });
        let mut today = columns.row(columns.nrows() - 1).transpose();
        for i in 1..first {
            today[i] = columns.column(i).mean();
        }
        let variance = (&fit.covariance * &today).dot(&today);
        Some(Self {
            now: estimate(fit.coefficients.dot(&today), variance),
            drifts: drifts.collect(),
            steps,
            between_rides,
            since: structure.0.last().map_or(0, |change| change.ride),
            reported,
        })
    }
}
