//! Least squares on the observer's states, paper eqs. (19) to (23), and an instrumental-variable
//! estimate beside it.
//!
//! z'' = (k/m) (u - z) + (B/m) (u' - z') [+ F/m] [+ rest point], with a nominal a0 = 0 in eqs. (13),
//! (19). Where the mass is unknown an applied force makes 1/m a third unknown; on rides with a force
//! and on free decays a constant stands for the unknown rest point.

mod estimates;
mod instrumental;
mod regression;

use nalgebra::{Matrix2, Matrix3, SVector};

use crate::simulate::linear::Input;
pub use estimates::estimates;
pub use instrumental::instrumental;
use regression::{Regression, Row, regress};

/// One axle of a ride as the regressions need it; all vectors equally long.
#[derive(Clone, Debug)]
pub struct Record<'a> {
    /// Sample interval (s).
    pub step_s: f64,
    /// Road and force with their splines.
    pub input: Input,
    /// Measured z (m).
    pub displacement: &'a [f64],
    /// Which samples to use.
    pub valid: &'a [bool],
    /// Mass (kg), where known.
    pub mass: Option<f64>,
    /// Whether a constant force is unknown.
    pub rest_point: bool,
}

/// The model's deflection and what else moves it.
#[derive(Clone, Debug)]
pub struct Deflection<'a> {
    /// u - z (m).
    pub value: Vec<f64>,
    /// u' - z' (m/s).
    pub rate: Vec<f64>,
    /// F (N).
    pub force: Option<&'a [f64]>,
}

/// k/m (1/s^2), B/m (1/s) and 1/m (1/kg).
pub type Theta = [f64; 3];

/// A regression's result on one axle.
#[derive(Clone, Debug)]
pub struct Found {
    /// The estimate at the end of the record.
    pub theta: Theta,
    /// Of theta; zero where 1/m is known.
    pub covariance: Matrix3<f64>,
    /// Inverse variance of the errors ((m/s^2)^-2): the axle's weight in a joint estimate.
    pub weight: f64,
    /// The estimate along the record; the last point is at its end.
    pub path: Vec<Point>,
}

/// The estimate from the samples up to one.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// Index of the last sample that counts in it (from 0).
    pub sample: usize,
    /// The estimate there.
    pub theta: Theta,
    /// What the samples say about k/m and B/m, the other unknowns eliminated.
    pub information: Matrix2<f64>,
}

/// Errors of the regressions are correlated over the observer's and the model's memory (s).
const MEMORY_S: f64 = 0.3;
/// Samples around one that is not valid at which the observer is not to be trusted.
const UNSETTLED: usize = 5;

/// Paper eq. (21), and (23) along the way, on the observer's `deflection` and `acceleration` from
/// sample `first`, where it has converged. Nothing where the ride does not determine the unknowns.
pub fn least_squares(
    record: &Record,
    deflection: &Deflection,
    acceleration: &[f64],
    first: usize,
) -> Option<Found> {
    let usable = usable(record.valid, first, UNSETTLED, UNSETTLED);
    solve(record, deflection, deflection, acceleration, &usable)
}

/// The samples from `first` that are valid, like all others within `before` and `after` of them.
pub fn usable(valid: &[bool], first: usize, before: usize, after: usize) -> Vec<bool> {
    let mut usable: Vec<bool> = (0..valid.len()).map(|i| i >= first).collect();
    keep_away(valid.iter().zip(&mut usable), after);
    keep_away(valid.iter().zip(&mut usable).rev(), before);
    usable
}

/// Takes those out that come within `distance` after one that is not valid.
fn keep_away<'a>(samples: impl Iterator<Item = (&'a bool, &'a mut bool)>, distance: usize) {
    let mut left = 0_usize;
    for (valid, usable) in samples {
        left = if *valid {
            left.saturating_sub(1)
        } else {
            distance.saturating_add(1)
        };
        *usable &= left == 0;
    }
}

/// Regresses the acceleration `target` on `seen` by means of `instruments`. Unknowns: k/m and B/m; of
/// three the last is the rest point; of four it follows 1/m.
fn solve(
    record: &Record,
    seen: &Deflection,
    instruments: &Deflection,
    target: &[f64],
    usable: &[bool],
) -> Option<Found> {
    match (record.mass, record.rest_point) {
        (Some(_), false) => found::<2>(record, seen, instruments, target, usable),
        (Some(_), true) => found::<3>(record, seen, instruments, target, usable),
        (None, _) => found::<4>(record, seen, instruments, target, usable),
    }
}

fn found<const P: usize>(
    record: &Record,
    seen: &Deflection,
    instruments: &Deflection,
    target: &[f64],
    usable: &[bool],
) -> Option<Found> {
    let lags = (MEMORY_S / record.step_s).round() as usize;
    let known = record.mass.map_or(0.0, f64::recip);
    let r: Regression<P> = regress(usable.len(), lags, |i| {
        usable[i].then(|| {
            let force = seen.force.map_or(0.0, |f| f[i]);
            let unknowns = |d: &Deflection| {
                let (value, rate) = (d.value[i], d.rate[i]);
                let all = if P == 4 {
                    [value, rate, force, 1.0]
                } else {
                    [value, rate, 1.0, 0.0]
                };
                std::array::from_fn(|p| all[p])
            };
            Row {
                regressor: unknowns(seen),
                instrument: unknowns(instruments),
                target: target[i] - known * force,
            }
        })
    })?;
    let all = |x: &SVector<f64, P>| [x[0], x[1], record.mass.map_or_else(|| x[2], f64::recip)];
    let unknowns = if record.mass.is_none() { 3 } else { 2 };
    let path = r.path.iter().filter_map(|(sample, sums)| {
        Some(Point {
            sample: *sample,
            theta: all(&sums.solve()?),
            information: sums.on_first_two()?,
        })
    });
    Some(Found {
        theta: all(&r.theta),
        covariance: Matrix3::from_fn(|i, j| {
            if i.max(j) < unknowns {
                r.covariance[(i, j)]
            } else {
                0.0
            }
        }),
        weight: 1.0 / r.variance.max(f64::MIN_POSITIVE),
        path: path.collect(),
    })
}
