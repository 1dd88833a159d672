//! Rides on which nothing more is missing, made from a fitted model with the noise of both sensors
//! drawn anew: what an effect gains on them, noise in the road channel alone can gain.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::extend::{Model, tangent_for};
use super::fit::Fitter;
use super::model::Term;
use super::name::COARSE;
use super::null::normal;
use super::scene::Scene;

/// Replicates of the ride.
const REPLICATES: usize = 12;
/// Standard deviations of the replicates' scores by which a score must lie above their mean.
const BEYOND: f64 = 3.5;

/// Score (standard deviations) that `term` must beat on a ride whose road channel is noisy: what it
/// reaches on replicates of the ride under `model`, to first order. Zero where the road has no noise
/// that matters.
pub fn score_to_beat(fitter: &Fitter, model: &Model, term: Term, seed: u64) -> f64 {
    let scene = fitter.scene;
    let noisy = scene
        .tracks
        .iter()
        .any(|t| t.has_road && term.acts_on(t.axle) && t.road_floor > NEGLIGIBLE * t.sensor_floor);
    if !noisy {
        return 0.0;
    }
    let substeps = model.substeps(scene, COARSE);
    let truth: Vec<Vec<f64>> = (0..scene.tracks.len())
        .map(|t| {
            let (fit, a) = model.of_track(t);
            let track = &scene.tracks[t];
            let residuals = fitter.residuals_to(&fit.unit, &fit.point, substeps, scene.samples);
            let pairs = track.measured.iter().zip(&residuals[a]);
            pairs.map(|(y, r)| y - r).collect()
        })
        .collect();
    let scores: Vec<f64> = (0..REPLICATES)
        .into_par_iter()
        .map(|replicate| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream(u64::MAX - replicate as u64);
            let scene = replica(scene, &truth, &mut rng);
            let fitter = Fitter {
                scene: &scene,
                samples: fitter.samples,
            };
            let tangent = tangent_for(&fitter, model, term, substeps);
            let offer = tangent.signatures(&fitter, term, substeps);
            let gain = offer.starts.iter().map(|p| p.gain).fold(0.0, f64::max);
            (2.0 * gain).sqrt()
        })
        .collect();
    let n = scores.len() as f64;
    let mean = scores.iter().sum::<f64>() / n;
    let variance = scores.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / (n - 1.0);
    mean + BEYOND * variance.sqrt().max(1.0)
}

/// Road noise below this share of the sensor's (in density) cannot matter.
const NEGLIGIBLE: f64 = 0.003;

/// The ride again: the same motion, both channels with fresh white noise.
fn replica(scene: &Scene, truth: &[Vec<f64>], rng: &mut ChaCha8Rng) -> Scene {
    let mut again = scene.clone();
    for (track, truth) in again.tracks.iter_mut().zip(truth) {
        let deviation = |density: f64| (0.5 * density / scene.step).sqrt();
        let (road, sensor) = (deviation(track.road_floor), deviation(track.sensor_floor));
        track.measured = truth.iter().map(|z| z + sensor * normal(rng)).collect();
        if track.has_road {
            let noisy: Vec<f64> = track
                .input
                .road
                .iter()
                .map(|u| u + road * normal(rng))
                .collect();
            track.set_road(&noisy);
        }
    }
    again
}
