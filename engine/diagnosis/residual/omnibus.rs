//! Is anything left? The residual of a model against a broad set of generic features of its own
//! motion: an omnibus test that needs no name, and a free-form estimate of the missing force.

use std::ops::Range;

use super::features::{Feature, features};
use crate::policy;
use veloid_core::numerics::projection::{dot, orthonormal, without};
use veloid_core::numerics::statistics::chi_square_tail;
use veloid_core::plant::Coefficients;
use veloid_methods::simulate::linear::{Input, simulate};
use veloid_model::dataset::{Dataset, Track};
use veloid_model::fit::tangent::Tangent;
use veloid_model::fit::{FINE, Fitted, Fitter, Model, Motion};

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
    let noise_model = &fit.noise_models[a];
    let per = noise_model.variance.sqrt().recip();
    let white = |x: &[f64]| -> Vec<f64> { noise_model.whiten(x).iter().map(|x| x * per).collect() };
    let t = &dataset.tracks[track];
    let substeps = model.substeps(dataset, FINE);
    let beyond = reachable(fitter, model, (fit, a), substeps);
    let residual = fitter
        .residuals_to(&fit.unit, &fit.point, substeps, dataset.samples)
        .swap_remove(a);
    let features = features(dataset, motions, track);
    let responses: Vec<Vec<f64>> = (features.iter())
        .map(|feature| response(dataset, t, &fit.point.base[a], feature))
        .collect();
    let whitened: Vec<Vec<f64>> = responses.iter().map(|r| white(r)).collect();
    let train: Vec<&[f64]> = whitened.iter().map(|w| &w[..fitter.samples]).collect();
    let target = white(&residual);
    let basis = orthonormalised(&train, &beyond);
    let (q, weights) = along(&basis, &target[..fitter.samples], features.len());
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
    Remainder {
        p_value: chi_square_tail((q - 2.0 * t.unresolved).max(0.0), basis.len() as f64),
        held_gain: gain,
        held_before: (before / count.max(1.0)).sqrt(),
        held_after: (after / count.max(1.0)).sqrt(),
        force: force(dataset.samples, &weights, &features),
        residual,
    }
}

/// What the model's own parameters can do to the whitened residual of axle `a` of the fit's unit.
fn reachable(
    fitter: &Fitter,
    model: &Model,
    (fit, a): (&Fitted, usize),
    substeps: usize,
) -> Vec<Vec<f64>> {
    let tangent = Tangent::new(fitter, model, &fit.unit, substeps);
    // The unit's axles lie one after the other in the tangent's columns; this axle's part of them.
    let own: Range<usize> = a * fitter.samples..(a + 1) * fitter.samples;
    let parts = tangent.basis.iter().map(|b| b[own.clone()].to_vec());
    orthonormal(parts.collect(), &[])
}

/// What a feature does to the measurement; zero where that is not valid.
fn response(dataset: &Dataset, track: &Track, base: &Coefficients, feature: &Feature) -> Vec<f64> {
    let response = if feature.acts && !track.input.prescribed {
        let Coefficients { kappa, beta, .. } = *base;
        let still = vec![0.0; dataset.samples];
        simulate(
            &Input::new(&still, Some(&feature.signal), dataset.step),
            kappa.max(1.0),
            beta.max(0.02 * kappa.max(1.0).sqrt()),
            1.0,
            0.0,
            [0.0; 2],
        )
        .0
    } else {
        feature.signal.clone()
    };
    (response.into_iter().zip(&track.valid))
        .map(|(x, valid)| if *valid { x } else { 0.0 })
        .collect()
}

/// A direction of length 1, and which mix of features it is.
struct Direction {
    column: Vec<f64>,
    mix: Vec<f64>,
}

/// The columns one by one without what lies in `beyond` or in those before; nothing of those of which nothing is left.
fn orthonormalised(columns: &[&[f64]], beyond: &[Vec<f64>]) -> Vec<Direction> {
    let mut basis: Vec<Direction> = Vec::new();
    for (i, column) in columns.iter().enumerate() {
        let size = dot(column, column);
        let mut left = without(column, beyond);
        let mut mix = vec![0.0; columns.len()];
        mix[i] = 1.0;
        for _ in 0..2 {
            for b in &basis {
                let along = dot(&left, &b.column);
                (left.iter_mut().zip(&b.column)).for_each(|(x, b)| *x -= along * b);
                (mix.iter_mut().zip(&b.mix)).for_each(|(x, m)| *x -= along * m);
            }
        }
        let rest = dot(&left, &left);
        if rest > 1e-6 * size && rest.is_finite() && rest > 1e-8 {
            let scale = rest.sqrt().recip();
            left.iter_mut().for_each(|x| *x *= scale);
            mix.iter_mut().for_each(|x| *x *= scale);
            basis.push(Direction { column: left, mix });
        }
    }
    basis
}

/// The sum of squares of `target` along the basis, and the weight of every feature in its significant part.
fn along(basis: &[Direction], target: &[f64], features: usize) -> (f64, Vec<f64>) {
    let mut q = 0.0;
    let mut weights = vec![0.0; features];
    for b in basis {
        let c = dot(&b.column, target);
        q += c * c;
        if c.abs() > KEEP {
            (weights.iter_mut().zip(&b.mix)).for_each(|(w, m)| *w += c * m);
        }
    }
    (q, weights)
}

fn force(samples: usize, weights: &[f64], features: &[Feature]) -> Vec<f64> {
    (0..samples)
        .map(|i| {
            weights
                .iter()
                .zip(features)
                .filter(|(_, f)| f.acts)
                .map(|(w, f)| w * f.signal[i])
                .sum()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn something_is_left_where_chance_hardly_and_the_held_out_part_gains() {
        let structured = |p_value, gain: f64, after| {
            let found = Remainder {
                p_value,
                held_gain: gain * policy::STRUCTURED,
                held_before: 1.0,
                held_after: after,
                force: Vec::new(),
                residual: Vec::new(),
            };
            found.is_structured(0.05)
        };
        assert!(structured(0.024, 1.01, 0.9));
        assert!(!structured(0.024, 0.99, 0.9));
        assert!(!structured(0.026, 1.01, 0.9));
        assert!(!structured(0.024, 1.01, 1.1));
    }
}
