//! Two plain axles: from the spectra, from many starts, and then with everything that wanders.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};

use super::fit::{Fit, Frame, level, noise};
use super::model::{BETA, Base, KAPPA, Model};
use super::nuisance::{Course, whitened};
use super::predict::Spectra;
use super::record::{Record, spectrum};
use veloid_core::bicycle::{Axle, PerAxle};
use veloid_core::numerics::lanes::Lanes;
use veloid_fourier::Complex;
use veloid_model::law::Scale;

/// k/m (1/s^2) and B/m (1/s) of starts: light wheels and heavy ones on soft and hard tyres.
const STARTS: [[f64; 4]; 6] = [
    [4000.0, 30.0, 1500.0, 10.0],
    [2500.0, 15.0, 1000.0, 5.0],
    [6500.0, 50.0, 2500.0, 18.0],
    [4000.0, 15.0, 2500.0, 18.0],
    [2500.0, 40.0, 1500.0, 5.0],
    [1500.0, 12.0, 4000.0, 30.0],
];
/// Delays (s) that starts are tried with.
const DELAYS: [f64; 3] = [0.0, -6e-3, 6e-3];
/// Limits of the delay (s) and the gain.
const MOST_DELAY: f64 = 0.03;
const GAINS: [f64; 2] = [0.8, 1.2];
const ITERATIONS: usize = 40;
/// Rounds in which the nuisances follow the model.
const ROUNDS: usize = 6;

/// z/u of a plain axle.
fn transfer(w: f64, [kappa, beta]: [f64; 2]) -> Complex<f64> {
    let force = Complex::new(kappa, w * beta);
    force / (force - w * w)
}

/// Logarithms of k/m, B/m of the leading and the other axle, delay (s), gain.
type Unknowns = [f64; 6];

/// By the ratio of the axles' transfer functions, the leading one's spectrum brought to the other's time.
pub fn by_spectra(record: &Record) -> Vec<(f64, Unknowns)> {
    let shifted: Vec<Vec<Complex<f64>>> = (record.segments.iter())
        .map(|segment| {
            let course = Course::new(segment, record.lines.len());
            let a: Vec<Lanes> = segment.lead.a.iter().map(|a| Lanes::all(*a)).collect();
            // An acceleration goes with the square of the speeds' ratio, a rate with the ratio.
            let under = course.with_ratio(course.under(&a));
            let values = under.iter().zip(&segment.window).map(|(a, w)| a.0[0] * w);
            spectrum(
                &*record.fourier,
                values.collect(),
                &record.lines,
                segment.over,
            )
        })
        .collect();
    let starts = STARTS.iter().flat_map(|s| {
        DELAYS.map(|delay| {
            let [a, b, c, d] = match record.lead {
                Axle::Front => *s,
                Axle::Rear => [s[2], s[3], s[0], s[1]],
            };
            [a.ln(), b.ln(), c.ln(), d.ln(), delay, 1.0]
        })
    });
    let mut found: Vec<(f64, Unknowns)> = starts
        .map(|start| fitted(record, &shifted, start))
        .collect();
    found.retain(|(cost, _)| cost.is_finite());
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found
}

fn limited(mut x: Unknowns) -> Unknowns {
    for i in 0..4 {
        let [low, high] = if i % 2 == 0 { KAPPA } else { BETA };
        x[i] = x[i].clamp(low.ln(), high.ln());
    }
    x[4] = x[4].clamp(-MOST_DELAY, MOST_DELAY);
    x[5] = x[5].clamp(GAINS[0], GAINS[1]);
    x
}

fn left(record: &Record, shifted: &[Vec<Complex<f64>>], x: &Unknowns) -> Vec<Vec<Complex<f64>>> {
    let [lead, other] = [[x[0].exp(), x[1].exp()], [x[2].exp(), x[3].exp()]];
    let filter: Vec<Complex<f64>> = (0..record.lines.len())
        .map(|k| {
            let w = TAU * record.hz(k);
            let turn = Complex::new(0.0, -w * x[4]).exp();
            transfer(w, other) / transfer(w, lead) * turn * x[5]
        })
        .collect();
    (record.segments.iter().zip(shifted))
        .map(|(segment, shifted)| {
            (segment.measured.iter().zip(shifted).zip(&filter))
                .map(|((m, s), f)| m - s * f)
                .collect()
        })
        .collect()
}

fn fitted(record: &Record, shifted: &[Vec<Complex<f64>>], start: Unknowns) -> (f64, Unknowns) {
    let mut x = limited(start);
    let mut residuals = left(record, shifted, &x);
    let mut cost = level(record, &residuals);
    let mut damping = 1e-2;
    for _ in 0..ITERATIONS {
        let Some((normal, gradient)) = gradient(record, shifted, &x, &residuals) else {
            break;
        };
        let mut better = None;
        for _ in 0..4 {
            let mut matrix = normal.clone();
            for i in 0..6 {
                matrix[(i, i)] += damping * (matrix[(i, i)] + 1e-9);
            }
            let Some(step) = matrix.cholesky().map(|c| c.solve(&gradient)) else {
                break;
            };
            let next = limited(std::array::from_fn(|i| x[i] + step[i].clamp(-0.5, 0.5)));
            let trial = left(record, shifted, &next);
            let trial_cost = level(record, &trial);
            if trial_cost < cost {
                better = Some((next, trial, trial_cost));
                break;
            }
            damping *= 10.0;
        }
        let Some((next, trial, trial_cost)) = better else {
            break;
        };
        let gained = cost - trial_cost;
        (x, residuals, cost) = (next, trial, trial_cost);
        damping = f64::max(damping / 10.0, 1e-5);
        if gained < 0.05 {
            break;
        }
    }
    (cost, x)
}

fn gradient(
    record: &Record,
    shifted: &[Vec<Complex<f64>>],
    x: &Unknowns,
    residuals: &Spectra,
) -> Option<(DMatrix<f64>, DVector<f64>)> {
    let noise = noise(record, residuals)?;
    let column = |values: &[Vec<Complex<f64>>]| -> DVector<f64> {
        let parts = values
            .iter()
            .flat_map(|v| whitened(v, &noise).data.as_vec().clone());
        DVector::from_vec(parts.collect())
    };
    let r = column(residuals);
    let columns: Vec<DVector<f64>> = (0..6)
        .map(|i| {
            let mut moved = *x;
            moved[i] += 1e-5;
            (&r - column(&left(record, shifted, &moved))) / 1e-5
        })
        .collect();
    let jacobian = DMatrix::from_columns(&columns);
    Some((jacobian.tr_mul(&jacobian), jacobian.tr_mul(&r)))
}

/// The plain model with the courses that suit it, from the best of the starts.
pub fn settled(
    record: &Record,
    scales: &PerAxle<Scale>,
    start: &Unknowns,
) -> Option<(Fit, Vec<Course>)> {
    let base = |at: usize| -> Base { [start[at], start[at + 1]] };
    let mut model = match record.lead {
        Axle::Front => Model::new(base(0), base(2)),
        Axle::Rear => Model::new(base(2), base(0)),
    };
    let mut courses: Vec<Course> = (record.segments.iter())
        .map(|segment| Course::started(segment, record.lines.len(), start[4], start[5]))
        .collect();
    let mut best: Option<(Fit, Vec<Course>)> = None;
    for _ in 0..ROUNDS {
        let frame = Frame::around(record, scales, &courses, &model)?;
        let fit = frame.fit(&model, 3, 0.1)?;
        let gained = best
            .as_ref()
            .map_or(f64::INFINITY, |(b, _)| b.cost - fit.cost);
        model = fit.model.clone();
        let next = frame.settled(&model)?;
        if gained > 0.0 {
            best = Some((fit, courses.clone()));
        }
        if gained < 0.5 {
            break;
        }
        courses = next;
    }
    best
}
