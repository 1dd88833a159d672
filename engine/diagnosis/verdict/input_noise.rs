//! What noise in the road channel does to the estimates, and the estimates without it, by simulation
//! and extrapolation (Cook & Stefanski 1994, J. Am. Stat. Assoc. 89:1314): as much noise again is put
//! on the recorded road, and what that changes is taken off. How much noise it holds is reported by the
//! residual: roughness, which moves the axle, leaves nothing there.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use crate::residual::resonance::{Inputs, road_noise};
use veloid_core::numerics::autoregressive::NoiseModel;
use veloid_core::numerics::spectrum::deviation;
use veloid_model::dataset::Dataset;
use veloid_model::fit::{Effort, FINE, Fitted, Fitter, Model, Point};

/// Pairs of refits. The two of a pair see the same noise with opposite signs, so that only what does
/// not average out is left: the bias.
const PAIRS: u64 = 2;

/// The model with the values that its parameters would have if the road had been recorded without
/// noise. It describes the bicycle; what predicts the ride from its log is the model as fitted.
pub fn corrected(fitter: &Fitter, model: &Model, seed: u64) -> Model {
    let substeps = model.substeps(fitter.dataset, FINE);
    let fits = model
        .fits
        .iter()
        .map(|fit| without_bias(fitter, fit, substeps, seed).unwrap_or_else(|| fit.clone()))
        .collect();
    Model::new(model.terms.clone(), fits)
}

/// White noise (m, RMS) in the road of each axle of a fit, as far as its residual shows it.
fn noises(dataset: &Dataset, fit: &Fitted) -> Vec<f64> {
    let axles = fit.unit.tracks.iter().zip(&fit.point.base);
    axles
        .zip(&fit.residuals)
        .map(|((t, base), residual)| {
            let track = &dataset.tracks[*t];
            if !track.has_road {
                return 0.0;
            }
            let inputs = Inputs {
                road: track.road_floor,
                force: track.force_most * base.per_mass * base.per_mass,
                band: track.band,
            };
            let density = road_noise(residual, dataset.step, base.kappa, base.beta, &inputs);
            deviation(density, dataset.step)
        })
        .collect()
}

/// Road noise below this share of the residual (RMS) cannot matter.
const NEGLIGIBLE: f64 = 0.03;

fn without_bias(fitter: &Fitter, fit: &Fitted, substeps: usize, seed: u64) -> Option<Fitted> {
    let noises = noises(fitter.dataset, fit);
    let matters = |(noise, noise_model): (&f64, &NoiseModel)| {
        *noise > NEGLIGIBLE * noise_model.total_variance().sqrt()
    };
    if !noises.iter().zip(&fit.noise_models).any(matters) {
        return None;
    }
    let effort = Effort {
        iterations: 4,
        gain: 1e-3,
        substeps,
    };
    let refit = |dataset: &Dataset| -> Option<Point> {
        let fitter = Fitter {
            dataset,
            samples: fitter.samples,
        };
        let found = fitter.fit(&fit.unit, fit.point.clone(), &fit.noise_models, effort)?;
        Some(found.point)
    };
    let own = refit(fitter.dataset)?;
    let noisier: Vec<Point> = (0..2 * PAIRS)
        .into_par_iter()
        .filter_map(|draw| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream(u64::MAX / 2 - draw / 2);
            let sign = if draw % 2 == 0 { 1.0 } else { -1.0 };
            let noises = noises.iter().map(|n| sign * n);
            let pairs = fit.unit.tracks.iter().copied().zip(noises);
            refit(&noisier(fitter.dataset, pairs, &mut rng))
        })
        .collect();
    if noisier.len() < 2 * PAIRS as usize {
        return None;
    }
    let mut better = fit.clone();
    for slot in fit.unit.slots(fitter.dataset) {
        let mean = noisier.iter().map(|p| p.get(slot)).sum::<f64>() / noisier.len() as f64;
        let (_, [low, high]) = fit.unit.range(fitter.dataset, slot);
        let value = fit.point.get(slot) - (mean - own.get(slot));
        better.point.set(slot, value.max(low).min(high));
    }
    Some(better)
}

/// The ride with white noise (m, RMS) added to the roads of some tracks.
fn noisier(
    dataset: &Dataset,
    noises: impl Iterator<Item = (usize, f64)>,
    rng: &mut ChaCha8Rng,
) -> Dataset {
    let mut again = dataset.clone();
    for (track, noise) in noises {
        again.tracks[track].add_road_noise(noise, rng);
    }
    again
}
