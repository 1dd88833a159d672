//! What may differ between the wheels beside physics: gain, contact patch, and a delay that wanders. They are found along with
//! every model and projected out of what it leaves.

use std::sync::Arc;

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use veloid_core::numerics::lanes::Lanes;
use veloid_fourier::{Complex, forward, inverse};

use super::record::{Record, Segment, spectrum};

/// Standard deviation of the ratio of the sensors' gains.
const GAIN: f64 = 0.1;
/// Standard deviations of what the patches' difference makes with the square of the road's frequency, (l_r^2 - l_f^2)/24, in units of
/// 1e-4 m^2, and with its fourth power, in units of 1e-8 m^4: wheels see a road's mean over their patches, sin(pi n l)/(pi n l).
const PATCH: f64 = 3.0;
const PATCH_UNIT: f64 = 1e-4;
/// The same of half the square of the tracks' distance (1e-4 m^2), which makes (2 pi n)^2 ln(2 pi n) at n cycles/m: the part of an isotropic
/// road that wheels share is x K1(x) = 1 + x^2/2 ln(x/2) + ... with x = 2 pi n times the distance, and the square alone is the patches'.
const TRACKS: f64 = 3.0;
/// What wheels see differently: by the square and the fourth power of the frequency, and by the tracks.
const SEEN: usize = 3;
/// Columns before those of the knots: the gain, and what is seen.
const FIXED: usize = 1 + SEEN;
/// Standard deviations of the delay: common to all knots (s), beside the time since the other wheel (the speed's error), and of each
/// knot (s).
const COMMON_S: f64 = 0.01;
const OF_LAG: f64 = 0.03;
const EACH_S: f64 = 2e-3;
/// Seconds between knots.
const KNOT_S: f64 = 1.0;
/// Part of the logger's rate up to which derivatives are taken.
const UP_TO: f64 = 0.48;

/// Where the other axle is on the leading one's road along a segment.
#[derive(Clone)]
pub struct Course {
    pub gain: f64,
    /// What the wheels see differently, in units.
    pub seen: [f64; SEEN],
    /// Delay (s) at each knot.
    pub knots: Vec<f64>,
    /// Steps of the fine clock at which the leading axle stood there, and the ratio of the speeds.
    at: Vec<f64>,
    ratio: Vec<f64>,
    /// Spectra of what such units do.
    bent: [Vec<Complex<f64>>; SEEN],
}

impl Course {
    pub fn new(segment: &Segment, lines: usize) -> Self {
        let mut course = Self {
            gain: 1.0,
            seen: [0.0; SEEN],
            knots: vec![0.0; knots(segment)],
            at: Vec::new(),
            ratio: Vec::new(),
            bent: std::array::from_fn(|_| vec![Complex::default(); lines]),
        };
        course.settle(segment);
        course
    }

    /// With a delay (s) and a gain all along.
    pub fn started(segment: &Segment, lines: usize, late: f64, gain: f64) -> Self {
        let mut course = Self::new(segment, lines);
        course.gain = gain;
        course.knots.fill(late);
        course.settle(segment);
        course
    }

    /// A rate times the ratio of the speeds at which it will be met, as an acceleration needs it once more.
    pub fn with_ratio(&self, under: Vec<Lanes>) -> Vec<Lanes> {
        under
            .into_iter()
            .zip(&self.ratio)
            .map(|(x, r)| x * *r)
            .collect()
    }

    /// Time (s) since the other wheel at each knot.
    pub fn lags(&self, segment: &Segment) -> Vec<f64> {
        lags(segment, self.knots.len())
    }

    /// Follows its knots.
    fn settle(&mut self, segment: &Segment) {
        let last = segment.steps() - 1;
        let stood = |i: usize| {
            let t = segment.time(i);
            let back = ((t - self.late(t)) / segment.step).clamp(0.0, last as f64);
            between(&segment.stood, back) / segment.step
        };
        self.at = (0..segment.steps()).map(stood).collect();
        let ratio = |(i, at): (usize, &f64)| {
            segment.speed[i] / between(&segment.speed, at.clamp(0.0, last as f64))
        };
        self.ratio = self.at.iter().enumerate().map(ratio).collect();
    }

    /// Delay (s) at a time (s).
    fn late(&self, t: f64) -> f64 {
        between(&self.knots, (t / KNOT_S).min((self.knots.len() - 1) as f64))
    }

    /// The road's rate (m/s) under the other wheel, by cubics through that under the leading one.
    pub fn under(&self, road: &[Lanes]) -> Vec<Lanes> {
        let of = |(at, ratio): (&f64, &f64)| {
            let j = at.floor();
            if j < 1.0 || j + 3.0 > road.len() as f64 {
                return Lanes::ZERO;
            }
            let (q, j) = (at - j, j as usize);
            let weights = [
                -q * (q - 1.0) * (q - 2.0) / 6.0,
                (q + 1.0) * (q - 1.0) * (q - 2.0) / 2.0,
                -(q + 1.0) * q * (q - 2.0) / 2.0,
                (q + 1.0) * q * (q - 1.0) / 6.0,
            ];
            let mut sum = Lanes::ZERO;
            for (k, weight) in weights.iter().enumerate() {
                sum += road[j + k - 1] * *weight;
            }
            sum * *ratio
        };
        self.at.iter().zip(&self.ratio).map(of).collect()
    }

    /// What is left beside a prediction.
    pub fn residual(
        &self,
        measured: &[Complex<f64>],
        predicted: &[Complex<f64>],
    ) -> Vec<Complex<f64>> {
        let bent = |k: usize| -> Complex<f64> {
            let terms = self.bent.iter().zip(self.seen);
            terms.map(|(spectrum, by)| spectrum[k] * by).sum()
        };
        (measured.iter().zip(predicted).enumerate())
            .map(|(k, (m, p))| m - (p + bent(k)) * self.gain)
            .collect()
    }
}

fn knots(segment: &Segment) -> usize {
    (segment.duration() / KNOT_S).ceil() as usize + 1
}

fn between(values: &[f64], place: f64) -> f64 {
    let j = (place as usize).min(values.len().saturating_sub(2));
    let next = values[(j + 1).min(values.len() - 1)];
    values[j] + (place - j as f64) * (next - values[j])
}

/// The directions in which a segment's nuisances move its prediction, under some noise.
#[derive(Clone)]
pub struct Nuisance {
    columns: Arc<Columns>,
    whitened: DMatrix<f64>,
    information: Cholesky<f64, Dyn>,
    prior: DMatrix<f64>,
    /// How far the course lies from what is expected, in the prior's units.
    off: DVector<f64>,
}

/// Spectra of what the gain, what is seen and each knot do.
pub type Columns = Vec<Vec<Complex<f64>>>;
/// Gain, what is seen, and knots.
pub type Corrections = DVector<f64>;

/// What gain, patch and delay do to a prediction `a` of the other axle's acceleration along a segment.
pub fn columns(record: &Record, segment: &Segment, a: &[f64]) -> Columns {
    let steps = segment.steps();
    let plan = forward(steps);
    let back = inverse(steps);
    let mut all = plan.make_output_vec();
    let mut values = a.to_vec();
    if plan.process(&mut values, &mut all).is_err() {
        return Vec::new();
    }
    let duration = segment.duration();
    let top = (UP_TO * record.rate_hz * duration) as usize;
    let part = |f: &dyn Fn(f64) -> Complex<f64>| -> Vec<f64> {
        let mut of = back.make_input_vec();
        for (k, x) in all.iter().enumerate().take(top.min(all.len() - 1)).skip(1) {
            of[k] = x * f(std::f64::consts::TAU * k as f64 / duration) / steps as f64;
        }
        let mut out = back.make_output_vec();
        match back.process(&mut of, &mut out) {
            Ok(()) => out,
            Err(_) => vec![0.0; steps],
        }
    };
    let slow = part(&|_| Complex::new(1.0, 0.0));
    let rate = part(&|w| Complex::new(0.0, w));
    let bend = part(&|w| Complex::new(-w * w, 0.0));
    let fourth = part(&|w| Complex::new(w.powi(4), 0.0));
    let by_logarithm = part(&|w| Complex::new(w * w * w.ln(), 0.0));
    let windowed = |f: &dyn Fn(usize) -> f64| {
        let values = (0..steps).map(|i| segment.window[i] * f(i)).collect();
        spectrum(&*record.fourier, values, &record.lines, segment.over)
    };
    let mut columns = vec![
        windowed(&|i| slow[i]),
        windowed(&|i| PATCH_UNIT * bend[i] / segment.speed[i].powi(2)),
        windowed(&|i| PATCH_UNIT.powi(2) * fourth[i] / segment.speed[i].powi(4)),
        windowed(&|i| {
            let v = segment.speed[i];
            PATCH_UNIT * (by_logarithm[i] + bend[i] * v.ln()) / v.powi(2)
        }),
    ];
    for knot in 0..knots(segment) {
        let hat = |i: usize| (1.0 - (segment.time(i) / KNOT_S - knot as f64).abs()).max(0.0);
        columns.push(windowed(&|i| match hat(i) {
            0.0 => 0.0,
            hat => -rate[i] * hat,
        }));
    }
    columns
}

impl Nuisance {
    pub fn new(
        columns: Arc<Columns>,
        segment: &Segment,
        course: &Course,
        noise: &[f64],
    ) -> Option<Self> {
        let scaled = |(c, column): (usize, &Vec<Complex<f64>>)| {
            whitened(column, noise) * if c == 0 { 1.0 } else { course.gain }
        };
        let columns_of: Vec<DVector<f64>> = columns.iter().enumerate().map(scaled).collect();
        let whitened = DMatrix::from_columns(&columns_of);
        let prior = prior(segment, course.knots.len())?;
        let mut state = vec![course.gain - 1.0];
        state.extend(course.seen);
        state.extend(&course.knots);
        let off = &prior * DVector::from_vec(state);
        let information = whitened.tr_mul(&whitened) + prior.tr_mul(&prior);
        Some(Self {
            columns,
            information: information.cholesky()?,
            whitened,
            prior,
            off,
        })
    }

    /// The same under another noise.
    pub fn under(&self, segment: &Segment, course: &Course, noise: &[f64]) -> Option<Self> {
        Self::new(Arc::clone(&self.columns), segment, course, noise)
    }

    /// The corrections that suit a residual best, and what the prior charges for them.
    pub fn corrections(&self, residual: &DVector<f64>) -> (Corrections, f64) {
        let gradient = self.whitened.tr_mul(residual) - self.prior.tr_mul(&self.off);
        let corrections = self.information.solve(&gradient);
        let charge = (&self.off + &self.prior * &corrections).norm_squared();
        (corrections, charge)
    }

    /// A residual without what the corrections explain.
    pub fn without(
        &self,
        residual: &[Complex<f64>],
        corrections: &Corrections,
        course: &Course,
    ) -> Vec<Complex<f64>> {
        let mut left = residual.to_vec();
        for (c, column) in self.columns.iter().enumerate() {
            let by = corrections[c] * if c == 0 { 1.0 } else { course.gain };
            left.iter_mut().zip(column).for_each(|(x, y)| *x -= y * by);
        }
        left
    }

    /// Whitened directions without what the nuisances do.
    pub fn project(&self, directions: &DMatrix<f64>) -> DMatrix<f64> {
        let inside = self.information.solve(&self.whitened.tr_mul(directions));
        directions - &self.whitened * inside
    }

    /// Moves a course to where a residual wants it.
    pub fn settle(&self, course: &mut Course, segment: &Segment, corrections: &Corrections) {
        course.gain += corrections[0];
        for q in 0..SEEN {
            course.seen[q] += corrections[1 + q];
            course.bent[q] = self.columns[1 + q].clone();
        }
        for (knot, by) in course.knots.iter_mut().zip(corrections.iter().skip(FIXED)) {
            *knot += by.clamp(-5e-3, 5e-3);
        }
        course.settle(segment);
    }
}

fn lags(segment: &Segment, knots: usize) -> Vec<f64> {
    let last = (segment.steps() - 1) as f64;
    let lag = |knot: usize| {
        let place = (knot as f64 * KNOT_S / segment.step).min(last);
        place * segment.step - between(&segment.stood, place)
    };
    (0..knots).map(lag).collect()
}

/// Rows that the prior adds to the least squares.
fn prior(segment: &Segment, knots: usize) -> Option<DMatrix<f64>> {
    let lags = lags(segment, knots);
    let covariance = DMatrix::from_fn(knots, knots, |i, j| {
        let own = if i == j { EACH_S * EACH_S } else { 0.0 };
        own + COMMON_S * COMMON_S + OF_LAG * OF_LAG * lags[i] * lags[j]
    });
    let root = covariance.cholesky()?.inverse().cholesky()?.l().transpose();
    let mut rows = DMatrix::zeros(knots + FIXED, knots + FIXED);
    rows[(0, 0)] = 1.0 / GAIN;
    rows[(1, 1)] = 1.0 / PATCH;
    rows[(2, 2)] = 1.0 / PATCH;
    rows[(3, 3)] = 1.0 / TRACKS;
    rows.view_mut((FIXED, FIXED), (knots, knots))
        .copy_from(&root);
    Some(rows)
}

/// Real numbers of unit variance under a noise: real parts, then imaginary ones.
pub fn whitened(values: &[Complex<f64>], noise: &[f64]) -> DVector<f64> {
    let n = values.len();
    DVector::from_fn(2 * n, |i, _| {
        let (k, imaginary) = (i % n, i >= n);
        let scale = (2.0 / noise[k]).sqrt();
        scale
            * if imaginary {
                values[k].im
            } else {
                values[k].re
            }
    })
}

/// Spectra by segment as one whitened column.
pub fn column(spectra: &[Vec<Complex<f64>>], noise: &[f64]) -> DVector<f64> {
    let parts = spectra
        .iter()
        .flat_map(|s| whitened(s, noise).data.as_vec().clone());
    DVector::from_vec(parts.collect())
}
