//! Is anything left? The residual of a model against a broad set of generic features of its own
//! motion: an omnibus test that needs no name, and a free-form estimate of the missing force.

use std::ops::Range;

use crate::diagnosis::dataset::Dataset;
use crate::diagnosis::fit::Motion;
use crate::diagnosis::fit::tangent::Tangent;
use crate::diagnosis::fit::{FINE, Fitter, Model};
use crate::diagnosis::policy;
use crate::numerics::projection::{dot, orthonormal, without};
use crate::numerics::statistics::chi_square_tail;
use crate::plant::Coefficients;
use crate::simulate::linear::{Input, simulate};

/// What the omnibus test and the free form found on one track.
pub struct Remainder {
    /// p value of the residual's part along the features.
    pub p_value: f64,
    /// Gain in log score on the held-out part by the features' significant part.
    pub held_gain: f64,
    /// RMS of the held-out residual before and after it (m).
    pub held_before: f64,
    pub held_after: f64,
    /// The missing force over the mass (m/s^2) at every sample, by the features that act as forces.
    pub force: Vec<f64>,
    /// Measured minus simulated over the whole ride (m).
    pub residual: Vec<f64>,
}

impl Remainder {
    /// Whether the residual moves with the features, on the fitted and on the held-out part.
    pub fn is_structured(&self, alpha: f64) -> bool {
        self.p_value < 0.5 * alpha
            && self.held_gain > policy::STRUCTURED
            && self.held_after < self.held_before
    }
}

/// A feature: its signal, and whether it acts as a force or on the sensor.
struct Feature {
    signal: Vec<f64>,
    acts: bool,
}

/// Coefficients below this many standard errors count as noise in the free form.
const KEEP: f64 = 3.0;

/// Tests the residual of one track.
pub fn remainder(
    fitter: &Fitter,
    model: &Model,
    motions: &[Motion],
    track: usize,
    held: &Range<usize>,
) -> Remainder {
    let dataset = fitter.dataset;
    let (fit, a) = model.of_track(track);
    let Coefficients { kappa, beta, .. } = fit.point.base[a];
    let noise_model = &fit.noise_models[a];
    let per = noise_model.variance.sqrt().recip();
    let t = &dataset.tracks[track];
    let substeps = model.substeps(dataset, FINE);
    let tangent = Tangent::new(fitter, model, &fit.unit, substeps);
    // The unit's axles lie one after the other in the tangent's columns; this axle's part of them.
    let own: Range<usize> = a * fitter.samples..(a + 1) * fitter.samples;
    let beyond = orthonormal(
        tangent
            .basis
            .iter()
            .map(|b| b[own.clone()].to_vec())
            .collect(),
        &[],
    );
    let residual = fitter
        .residuals_to(&fit.unit, &fit.point, substeps, dataset.samples)
        .swap_remove(a);
    let mask = |x: Vec<f64>| -> Vec<f64> {
        x.into_iter()
            .zip(&t.valid)
            .map(|(x, v)| if *v { x } else { 0.0 })
            .collect()
    };
    let features = features(dataset, motions, track);
    let mut responses = Vec::new();
    for f in &features {
        let response = if f.acts && !t.input.prescribed {
            let input = Input::new(&vec![0.0; dataset.samples], Some(&f.signal), dataset.step);
            simulate(
                &input,
                kappa.max(1.0),
                beta.max(0.02 * kappa.max(1.0).sqrt()),
                1.0,
                0.0,
                [0.0; 2],
            )
            .0
        } else {
            f.signal.clone()
        };
        responses.push(mask(response));
    }
    let white = |x: &[f64]| -> Vec<f64> { noise_model.whiten(x).iter().map(|x| x * per).collect() };
    let whitened: Vec<Vec<f64>> = responses.iter().map(|r| white(r)).collect();
    let train: Vec<Vec<f64>> = whitened
        .iter()
        .map(|w| w[..fitter.samples].to_vec())
        .collect();
    let target = white(&residual);
    // Orthonormalised one by one, each remembering which mix of features it is.
    let mut basis: Vec<(Vec<f64>, Vec<f64>)> = Vec::new();
    for (i, column) in train.iter().enumerate() {
        let size = dot(column, column);
        let mut left = without(column, &beyond);
        let mut mix = vec![0.0; features.len()];
        mix[i] = 1.0;
        for _ in 0..2 {
            for (b, m) in &basis {
                let along = dot(&left, b);
                left.iter_mut().zip(b).for_each(|(x, b)| *x -= along * b);
                mix.iter_mut().zip(m).for_each(|(x, m)| *x -= along * m);
            }
        }
        let rest = dot(&left, &left);
        if rest > 1e-6 * size && rest.is_finite() && rest > 1e-8 {
            let scale = rest.sqrt().recip();
            left.iter_mut().for_each(|x| *x *= scale);
            mix.iter_mut().for_each(|x| *x *= scale);
            basis.push((left, mix));
        }
    }
    let mut q = 0.0;
    let mut weights = vec![0.0; features.len()];
    for (b, mix) in &basis {
        let c = dot(b, &target[..fitter.samples]);
        q += c * c;
        if c.abs() > KEEP {
            weights.iter_mut().zip(mix).for_each(|(w, m)| *w += c * m);
        }
    }
    let explained: Vec<f64> = (0..dataset.samples)
        .map(|i| weights.iter().zip(&responses).map(|(w, r)| w * r[i]).sum())
        .collect();
    let explained_white = white(&explained);
    let (mut gain, mut before, mut after, mut count) = (0.0, 0.0, 0.0, 0.0_f64);
    for i in held.clone().filter(|i| t.valid[*i]) {
        gain += 0.5 * (target[i].powi(2) - (target[i] - explained_white[i]).powi(2));
        before += residual[i].powi(2);
        after += (residual[i] - explained[i]).powi(2);
        count += 1.0;
    }
    let force = (0..dataset.samples)
        .map(|i| {
            weights
                .iter()
                .zip(&features)
                .filter(|(_, f)| f.acts)
                .map(|(w, f)| w * f.signal[i])
                .sum()
        })
        .collect();
    Remainder {
        p_value: chi_square_tail(q, basis.len() as f64),
        held_gain: gain,
        held_before: (before / count.max(1.0)).sqrt(),
        held_after: (after / count.max(1.0)).sqrt(),
        force,
        residual,
    }
}

/// Powers and products of deflection and rate, memory of several lengths, time windows, the other
/// axle, speed, wheel and crank angle; on the sensor's side shifts, gain, zero point and drift.
fn features(dataset: &Dataset, motions: &[Motion], track: usize) -> Vec<Feature> {
    let m = &motions[track];
    let n = dataset.samples;
    let rms = |x: &[f64]| {
        (x.iter().map(|x| x * x).sum::<f64>() / n as f64)
            .sqrt()
            .max(1e-30)
    };
    let (ds, ws) = (rms(&m.d), rms(&m.w));
    let d: Vec<f64> = m.d.iter().map(|x| x / ds).collect();
    let w: Vec<f64> = m.w.iter().map(|x| x / ws).collect();
    let mut all = Vec::new();
    let mut act = |f: &dyn Fn(usize) -> f64| {
        all.push(Feature {
            signal: (0..n).map(f).collect(),
            acts: true,
        })
    };
    act(&|_| 1.0);
    for order in 1..=5 {
        for j in 0..=order {
            // Beyond three deviations powers only repeat single events.
            act(&|i| d[i].clamp(-4.0, 4.0).powi(order - j) * w[i].clamp(-4.0, 4.0).powi(j));
        }
    }
    act(&|i| d[i].abs());
    act(&|i| w[i].abs());
    act(&|i| w[i] / (w[i] * w[i] + 1e-3).sqrt());
    act(&|i| d[i] / (d[i] * d[i] + 1e-3).sqrt());
    act(&|i| (d[i] - 1.5).max(0.0));
    act(&|i| (d[i] + 1.5).min(0.0));
    act(&|i| w[i] * d[i].abs());
    for tau in [0.012, 0.04, 0.1, 0.4] {
        let keep = (-dataset.step / tau).exp();
        let (mut lag, mut out) = (0.0, Vec::with_capacity(n));
        for x in &d {
            lag = keep * lag + (1.0 - keep) * x;
            out.push(lag);
        }
        act(&|i| out[i]);
        act(&|i| (d[i] - out[i]) * d[i].abs());
    }
    let windows = 6;
    for k in 0..windows {
        let inside = move |i: usize| i * windows / n == k;
        act(&|i| if inside(i) { d[i] } else { 0.0 });
        act(&|i| if inside(i) { w[i] } else { 0.0 });
    }
    if let Some(other) = (0..motions.len()).find(|t| *t != track) {
        let a = rms(&motions[other].acceleration);
        act(&|i| motions[other].acceleration[i] / a);
    }
    let top = dataset.speed.iter().copied().fold(0.0, f64::max);
    if top > 0.3 {
        act(&|i| d[i] * dataset.speed[i] / top);
        act(&|i| w[i] * dataset.speed[i] / top);
        act(&|i| dataset.speed_rate[i]);
        let radius = dataset.tracks[track].scale.wheel_radius;
        if radius.is_finite() {
            for harmonic in [1.0, 2.0] {
                let angle = move |x: f64| harmonic * x / radius;
                act(&|i| angle(dataset.distance[i]).sin());
                act(&|i| angle(dataset.distance[i]).cos());
                act(&|i| angle(dataset.distance[i]).sin() * d[i]);
                act(&|i| angle(dataset.distance[i]).cos() * d[i]);
            }
        }
    }
    if dataset.crank.last().is_some_and(|c| *c > 1.0) {
        for harmonic in [1.0, 2.0] {
            act(&|i| (harmonic * dataset.crank[i]).sin());
            act(&|i| (harmonic * dataset.crank[i]).cos());
        }
    }
    let z = rms(&m.z);
    let mut sense = |f: &dyn Fn(usize) -> f64| {
        all.push(Feature {
            signal: (0..n).map(f).collect(),
            acts: false,
        })
    };
    sense(&|i| m.z[i] / z);
    for shift in [-2_isize, 2] {
        sense(&|i| m.z[(i as isize + shift).clamp(0, n as isize - 1) as usize] / z);
    }
    sense(&|_| 1.0);
    sense(&|i| i as f64 / n as f64);
    all
}
