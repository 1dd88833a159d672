//! How strongly rides speak for one change more than is known: the likelihood of what may have changed, averaged over its size and over the
//! scatter between rides, relative to the largest likelihood without it (universal inference: Wasserman, Ramdas & Balakrishnan 2020,
//! doi:10.1073/pnas.1922664117), summed over the rides with which it may have begun (e-detectors: Shin, Ramdas & Rinaldo 2024,
//! doi:10.51387/23-NEJSDS51). Levels and facts have flat priors in both, so that the ratio is one of differences between rides. However
//! often one looks, the sum exceeds a threshold more rarely than with its inverse, times the rides.

use nalgebra::DVector;

use crate::least_squares::{Fit, scatters, usual_error};
use crate::robust::{believed, farthest};
use crate::structure::{Change, Kind, Structure, begins};
use crate::{Ride, Rides};

/// Usual size of a step, in standard deviations of a ride, and of a drift in four weeks.
const SIZE: f64 = 3.0;
const DAYS: f64 = 28.0;
/// Rides back to which a change is looked for, and from which on it is less to be expected since it would have been found: weighed by the
/// inverse of its age.
const WINDOW: usize = 100;
const RECENT: f64 = 8.0;
/// Rides up to which the one that is farthest off has to be dispensable: their scatter is known too badly to doubt it.
const FEW: usize = 12;

/// Evidence for another change, as a natural logarithm, and what it speaks for most.
#[derive(Clone, Copy, Debug)]
pub struct Evidence {
    pub log: f64,
    pub best: Change,
}

/// None where the rides are too few.
pub fn of_another(data: Rides, structure: &Structure, threshold: f64) -> Option<Evidence> {
    let columns = structure.columns(data.rides, data.facts);
    let values = believed(data.rides, &columns);
    let found = of_values(data, &values, structure)?;
    if found.log < threshold || data.rides.len() > FEW {
        return Some(found);
    }
    let odd = farthest(data.rides, &columns);
    let but = |values: &[f64]| -> Vec<f64> {
        let rest = values.iter().take(data.rides.len()).enumerate();
        rest.filter(|(i, _)| *i != odd).map(|(_, x)| *x).collect()
    };
    let mut rest = data.rides.to_vec();
    rest.remove(odd);
    let facts: Vec<Vec<f64>> = data.facts.iter().map(|fact| but(fact)).collect();
    let moved = structure.0.iter().map(|change| Change {
        ride: change.ride - usize::from(change.ride > odd),
        ..*change
    });
    let rest = Rides {
        rides: &rest,
        facts: &facts,
    };
    let without = of_values(rest, &but(&values), &Structure(moved.collect()))?;
    Some(Evidence {
        log: found.log.min(without.log),
        ..found
    })
}

fn of_values(data: Rides, values: &[f64], structure: &Structure) -> Option<Evidence> {
    let Rides { rides, facts } = data;
    let columns = structure.columns(rides, facts);
    if rides.len() < columns.ncols() + 2 {
        return None;
    }
    let mut largest = f64::NEG_INFINITY;
    let mut terms: Vec<f64> = Vec::new();
    let mut best: Option<(f64, Change)> = None;
    let mut tried = 0;
    for between in scatters(rides) {
        let Some(fit) = Fit::of(rides, values, &columns, between) else {
            continue;
        };
        tried += 1;
        largest = largest.max(fit.likelihood);
        for (change, gain) in additions(rides, structure, &fit, between) {
            let age = (rides.len() - change.ride) as f64;
            let log = fit.likelihood + gain + (RECENT / age).min(1.0).ln();
            terms.push(log);
            if best.is_none_or(|(most, _)| log > most) {
                best = Some((log, change));
            }
        }
    }
    let (most, best) = best?;
    let sum: f64 = terms.iter().map(|term| (term - most).exp()).sum();
    Some(Evidence {
        log: most + sum.ln() - f64::from(tried).ln() - largest,
        best,
    })
}

/// Every change that may come beside those that are known, with what it gains in log likelihood, averaged over its size.
pub fn additions(
    rides: &[Ride],
    structure: &Structure,
    fit: &Fit,
    between: f64,
) -> Vec<(Change, f64)> {
    let step = (SIZE * between.hypot(usual_error(rides))).powi(2);
    let slope = step / (DAYS * DAYS);
    let last = structure.drifts().last().copied();
    let drifts = last.filter(|drift| drift.to.is_none());
    let over = last.and_then(|drift| drift.to).unwrap_or(0);
    let kinds = if drifts.is_some() { 3.0_f64 } else { 2.0 }.ln();
    let today = rides.last().map_or(0.0, |ride| ride.day);
    let mut sums = Sums::new(fit.turned.nrows());
    let mut found = Vec::new();
    for ride in (1..rides.len()).rev().take(WINDOW) {
        sums.add(fit, ride, rides[ride].day - today);
        if structure.0.iter().any(|change| change.ride == ride) {
            continue;
        }
        let mut add = |kind, gain: f64| found.push((Change { ride, kind }, gain - kinds));
        let jump = sums.jump();
        let (ramp, product) = sums.ramp(begins(rides, ride) - today);
        add(Kind::Step, jump.gain(step));
        match drifts {
            None if ride > over => add(Kind::Begin, ramp.gain(slope)),
            Some(drift) if ride > drift.from => {
                add(Kind::End, ramp.gain(slope));
                add(Kind::Reset, jump.gain_with(&ramp, product, [step, slope]));
            }
            _ => {}
        }
    }
    found
}

/// Weighted sums over the rides from one on: of 1, time, its square, what is left and the turned columns.
struct Sums {
    one: f64,
    day: f64,
    day_day: f64,
    left: f64,
    day_left: f64,
    turned: DVector<f64>,
    day_turned: DVector<f64>,
}

impl Sums {
    fn new(columns: usize) -> Self {
        Self {
            one: 0.0,
            day: 0.0,
            day_day: 0.0,
            left: 0.0,
            day_left: 0.0,
            turned: DVector::zeros(columns),
            day_turned: DVector::zeros(columns),
        }
    }

    fn add(&mut self, fit: &Fit, ride: usize, day: f64) {
        let (weight, left) = (fit.weights[ride], fit.left[ride]);
        self.one += weight;
        self.day += weight * day;
        self.day_day += weight * day * day;
        self.left += weight * left;
        self.day_left += weight * day * left;
        self.turned.axpy(weight, &fit.turned.column(ride), 1.0);
        self.day_turned
            .axpy(weight * day, &fit.turned.column(ride), 1.0);
    }

    /// A column that is 1 on these rides.
    fn jump(&self) -> Column {
        Column::new(self.one, self.left, self.turned.clone())
    }

    /// A column that grows by 1 a day from a day on, and its product with the jump.
    fn ramp(&self, from: f64) -> (Column, f64) {
        let square = self.day_day - 2.0 * from * self.day + from * from * self.one;
        let across = &self.day_turned - &self.turned * from;
        let ramp = Column::new(square, self.day_left - from * self.left, across);
        (ramp, self.day - from * self.one)
    }
}

/// A column beside a fit.
struct Column {
    /// Weighted square of the part that the fit's columns do not explain.
    own: f64,
    /// Weighted product with what is left.
    left: f64,
    across: DVector<f64>,
}

impl Column {
    fn new(square: f64, left: f64, across: DVector<f64>) -> Self {
        let own = square - across.norm_squared();
        // Less is rounding.
        let own = if own > 1e-9 * square { own } else { 0.0 };
        Self { own, left, across }
    }

    /// Log likelihood ratio, averaged over a size of this variance.
    fn gain(&self, variance: f64) -> f64 {
        let seen = 1.0 + variance * self.own;
        0.5 * (variance * self.left * self.left / seen - seen.ln())
    }

    /// The same of two columns.
    fn gain_with(&self, other: &Self, product: f64, [own, others]: [f64; 2]) -> f64 {
        let (a, b) = (own.recip() + self.own, others.recip() + other.own);
        let c = product - self.across.dot(&other.across);
        let determinant = a * b - c * c;
        let square = b * self.left * self.left - 2.0 * c * self.left * other.left
            + a * other.left * other.left;
        0.5 * (square / determinant - (determinant * own * others).ln())
    }
}
