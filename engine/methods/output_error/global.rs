//! Starts that know nothing: for each k/m and B/m of a grid everything else in the plain model is linear and solved at once
//! (variable projection: Golub & Pereyra 1973, doi:10.1137/0710036).

use nalgebra::{SMatrix, SVector};
use rayon::prelude::*;

use crate::simulate::linear::{Input, simulate};
use crate::simulate::sensitivity::PARAMETERS;
use veloid_core::plant::Coefficients;
use veloid_ride::AxleRecord;

/// Samples that are looked at: enough to show basins apart.
const LOOKED: usize = 20_000;
/// Frequencies of the grid, evenly in the logarithm, and peaks of the spectrum beside them.
const FREQUENCIES: usize = 24;
const PEAKS: usize = 4;
/// Damping ratios that are tried at each.
const DAMPINGS: [f64; 5] = [0.002, 0.02, 0.1, 0.5, 2.0];
/// Starts that are given back.
const BEST: usize = 4;

/// The best of the grid, least squares first.
pub(super) fn starts(asked: &Query, train: usize) -> Vec<Coefficients> {
    let record = Record::new(asked, train.min(LOOKED));
    let turns = frequencies(record.measured, asked.input.step).map(|hz| std::f64::consts::TAU * hz);
    let grid: Vec<(f64, f64)> = match asked.free[0] {
        true => turns
            .flat_map(|omega| DAMPINGS.map(|ratio| (omega * omega, 2.0 * ratio * omega)))
            .collect(),
        false => turns.map(|omega| (0.0, omega)).collect(),
    };
    let solved = |(kappa, beta): &(f64, f64)| record.solved(*kappa, *beta);
    let mut found: Vec<(f64, Coefficients)> = grid.par_iter().filter_map(solved).collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found.into_iter().take(BEST).map(|(_, p)| p).collect()
}

/// A fit that looks for its starts.
pub(super) struct Query<'a> {
    pub input: &'a Input,
    pub record: &'a AxleRecord,
    pub mass: Option<f64>,
    /// Which of [`Coefficients`]'s parameters are unknown.
    pub free: [bool; PARAMETERS],
}

/// From a quarter of a swing in the record to a swing in four samples, and where the record swings most.
fn frequencies(measured: &[f64], step: f64) -> impl Iterator<Item = f64> {
    let slow = 0.25 / (measured.len() as f64 * step);
    let ratio = (0.25 / step / slow).powf(1.0 / (FREQUENCIES - 1) as f64);
    let even = (0..FREQUENCIES).map(move |i| slow * ratio.powi(i as i32));
    even.chain(peaks(measured, step))
}

/// The frequencies (Hz) of the highest peaks of a record's spectrum.
fn peaks(measured: &[f64], step: f64) -> Vec<f64> {
    let length = 2 * measured.len();
    let fourier = veloid_fourier::forward(length);
    let (mut padded, mut out) = (fourier.make_input_vec(), fourier.make_output_vec());
    let mean = measured.iter().sum::<f64>() / measured.len().max(1) as f64;
    padded
        .iter_mut()
        .zip(measured)
        .for_each(|(p, z)| *p = z - mean);
    if fourier.process(&mut padded, &mut out).is_err() {
        return Vec::new();
    }
    let power: Vec<f64> = out.iter().map(|o| o.norm_sqr()).collect();
    let is_peak = |i: &usize| power[*i] >= power[i - 1] && power[*i] > power[i + 1];
    let mut peaks: Vec<usize> = (1..power.len().saturating_sub(1)).filter(is_peak).collect();
    peaks.sort_by(|a, b| power[*b].total_cmp(&power[*a]));
    let hz = |i: &usize| *i as f64 / (length as f64 * step);
    peaks.iter().take(PEAKS).map(hz).collect()
}

/// Unknowns in which the model is linear: 1/m, the constant, z(0), z'(0).
const LINEAR: usize = 4;

/// A record as the grid looks at it.
struct Record<'a> {
    measured: &'a [f64],
    valid: &'a [bool],
    /// What is known to drive the axle, and what drives it by an unknown 1/m.
    known: Input,
    pushed: Option<Input>,
    still: Input,
    per_mass: Option<f64>,
    free: [bool; LINEAR],
    first: f64,
}

impl<'a> Record<'a> {
    fn new(asked: &Query<'a>, samples: usize) -> Self {
        let whole = asked.input.first(samples);
        let rest = vec![0.0; samples];
        let still = Input::new(&rest, None, whole.step);
        let unweighed = asked.mass.is_none();
        let pushed = Input {
            force: whole.force.clone(),
            ..still.clone()
        };
        Self {
            measured: &asked.record.output()[..samples],
            valid: &asked.record.valid[..samples],
            known: Input {
                force: whole.force.clone().filter(|_| !unweighed),
                ..whole
            },
            pushed: unweighed.then_some(pushed),
            still,
            per_mass: asked.mass.map(|m| 1.0 / m),
            free: std::array::from_fn(|q| asked.free[2 + q]),
            first: asked.record.output()[0],
        }
    }

    /// Least squares of everything else at one k/m and B/m: what is left, and the model.
    fn solved(&self, kappa: f64, beta: f64) -> Option<(f64, Coefficients)> {
        let moved = |input: &Input, per_mass, constant, initial| {
            simulate(input, kappa, beta, per_mass, constant, initial).0
        };
        let start = if self.free[2] { 0.0 } else { self.first };
        let forced = moved(&self.known, self.per_mass.unwrap_or(0.0), 0.0, [start, 0.0]);
        let answers: [Option<Vec<f64>>; LINEAR] = [
            self.pushed
                .as_ref()
                .map(|input| moved(input, 1.0, 0.0, [0.0; 2])),
            self.free[1].then(|| moved(&self.still, 0.0, 1.0, [0.0; 2])),
            self.free[2].then(|| moved(&self.still, 0.0, 0.0, [1.0, 0.0])),
            self.free[3].then(|| moved(&self.still, 0.0, 0.0, [0.0, 1.0])),
        ];
        let (mut matrix, mut target) = (
            SMatrix::<f64, LINEAR, LINEAR>::zeros(),
            SVector::<f64, LINEAR>::zeros(),
        );
        let mut squares = 0.0;
        for i in (0..self.measured.len()).filter(|i| self.valid[*i]) {
            let left = self.measured[i] - forced[i];
            let row =
                SVector::<f64, LINEAR>::from_fn(|q, _| answers[q].as_ref().map_or(0.0, |a| a[i]));
            squares += left * left;
            target += row * left;
            matrix += row * row.transpose();
        }
        let size = SVector::<f64, LINEAR>::from_fn(|q, _| match matrix[(q, q)] > 0.0 {
            true => matrix[(q, q)].sqrt().recip(),
            false => 1.0,
        });
        let mut scaled =
            SMatrix::<f64, LINEAR, LINEAR>::from_fn(|p, q| matrix[(p, q)] * size[p] * size[q]);
        (0..LINEAR)
            .filter(|q| answers[*q].is_none())
            .for_each(|q| scaled[(q, q)] = 1.0);
        let found = scaled
            .cholesky()?
            .solve(&target.component_mul(&size))
            .component_mul(&size);
        let left = squares - found.dot(&target);
        let per_mass = self.per_mass.unwrap_or(found[0]);
        let plain = Coefficients {
            kappa,
            beta,
            per_mass,
            constant: found[1],
            height: start + found[2],
            velocity: found[3],
        };
        let finite = found.iter().all(|x| x.is_finite()) && left.is_finite();
        (finite && per_mass > 0.0).then_some((left, plain))
    }
}
