//! Rides on which nothing more is missing, made from a fitted model with the noise of both sensors
//! drawn again: what an effect gains on them, noise in the road channel alone can gain.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use crate::policy;
use veloid_core::numerics::random::normal;
use veloid_core::numerics::spectrum::{Spectrum, deviation};
use veloid_model::dataset::{Dataset, Track};
use veloid_model::fit::{COARSE, Fitter, Model};

/// Replicates of the ride.
const REPLICATES: usize = 12;
/// Road noise below this share of the sensor's (in density) cannot matter.
const NEGLIGIBLE: f64 = 0.003;

/// Whether the road channel is noisy enough to matter.
pub fn is_noisy(track: &Track) -> bool {
    track.has_road && track.road_floor > NEGLIGIBLE * track.sensor_floor
}

/// Whether a score of rides, each with its model, lies beyond what it is on rides that differ from them by nothing but
/// fresh noise in both channels, as they would be under these models.
pub fn exceeds(
    own: f64,
    rides: &[(&Dataset, &Model)],
    seed: u64,
    score: impl Fn(&[Dataset]) -> f64 + Sync,
) -> bool {
    let each = rides.iter();
    let quiet: Vec<Dataset> = each
        .map(|(dataset, model)| quiet(dataset, model, model.substeps(dataset, COARSE)))
        .collect();
    let scores: Vec<f64> = (0..REPLICATES)
        .into_par_iter()
        .map(|replicate| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream(u64::MAX - replicate as u64);
            let again: Vec<Dataset> = quiet.iter().map(|ride| noisy(ride, &mut rng)).collect();
            score(&again)
        })
        .collect();
    is_beyond(own, &scores)
}

/// Whether a score lies beyond those of replicates.
fn is_beyond(own: f64, scores: &[f64]) -> bool {
    let n = scores.len() as f64;
    let mean = scores.iter().sum::<f64>() / n;
    let variance = scores.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / (n - 1.0);
    own > policy::ROAD_NOISE_UNSURE * mean + policy::BEYOND * variance.sqrt().max(1.0)
}

/// The ride as it is under `model` if neither channel had noise: the recorded road without what its
/// noise floor can be (Wiener's filter), and the motion over it.
fn quiet(dataset: &Dataset, model: &Model, substeps: usize) -> Dataset {
    let mut quiet = dataset.clone();
    for track in quiet.tracks.iter_mut().filter(|t| t.has_road) {
        let road = denoised(&track.input.road, dataset.step, track.road_floor);
        track.set_road(&road);
    }
    let fitter = Fitter {
        dataset: &quiet,
        samples: dataset.samples,
    };
    let motion: Vec<Vec<f64>> = (0..dataset.tracks.len())
        .map(|t| {
            let (fit, a) = model.of_track(t);
            let residuals = fitter.residuals(&fit.unit, &fit.point, substeps);
            let pairs = dataset.tracks[t].measured.iter().zip(&residuals[a]);
            pairs.map(|(y, r)| y - r).collect()
        })
        .collect();
    for (track, motion) in quiet.tracks.iter_mut().zip(motion) {
        track.measured = motion;
    }
    quiet
}

/// A record without white noise of one-sided density `floor` (m^2/Hz).
fn denoised(record: &[f64], step: f64, floor: f64) -> Vec<f64> {
    let n = record.len();
    let Some(spectrum) = Spectrum::new(record, step) else {
        return record.to_vec();
    };
    let (forward, back) = (veloid_fourier::forward(n), veloid_fourier::inverse(n));
    // Without the line from end to end the record is periodic enough.
    let line = |i: usize| record[0] + (record[n - 1] - record[0]) * i as f64 / (n - 1) as f64;
    let mut level: Vec<f64> = (0..n).map(|i| record[i] - line(i)).collect();
    let mut bins = forward.make_output_vec();
    if forward.process(&mut level, &mut bins).is_err() {
        return record.to_vec();
    }
    let last = spectrum.density.len() - 1;
    for (i, bin) in bins.iter_mut().enumerate() {
        let at = (i as f64 / (n as f64 * step) / spectrum.hz[1]).round() as usize;
        *bin *= (1.0 - floor / spectrum.density[at.min(last)]).max(0.0) / n as f64;
    }
    if back.process(&mut bins, &mut level).is_err() {
        return record.to_vec();
    }
    level.iter().enumerate().map(|(i, x)| x + line(i)).collect()
}

/// The quiet ride recorded with fresh white noise in both channels.
fn noisy(quiet: &Dataset, rng: &mut ChaCha8Rng) -> Dataset {
    let mut again = quiet.clone();
    for track in &mut again.tracks {
        let sensor = deviation(track.sensor_floor, quiet.step);
        for z in &mut track.measured {
            *z += sensor * normal(rng);
        }
        if track.has_road {
            track.add_road_noise(deviation(track.road_floor, quiet.step), rng);
        }
    }
    again
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_score_lies_beyond_replicates_whose_noise_may_be_too_small() {
        // Mean 30 and, with one score less than there are, a variance of 4.
        let scores = [28.0, 32.0, 30.0];
        let bound = policy::ROAD_NOISE_UNSURE * 30.0 + policy::BEYOND * 2.0;
        assert!(is_beyond(1.001 * bound, &scores) && !is_beyond(0.999 * bound, &scores));
        // Replicates that hardly differ show no less than a nat.
        let alike = [30.0; 3];
        let bound = policy::ROAD_NOISE_UNSURE * 30.0 + policy::BEYOND;
        assert!(is_beyond(1.001 * bound, &alike) && !is_beyond(0.999 * bound, &alike));
    }

    #[test]
    fn a_road_without_noise_is_what_was_recorded() {
        let record: Vec<f64> = (0..600).map(|i| (0.05 * f64::from(i)).sin()).collect();
        let clean = denoised(&record, 0.01, 0.0);
        let off = record.iter().zip(&clean).map(|(a, b)| (a - b).abs());
        assert!(off.fold(0.0, f64::max) < 1e-9);
        // A floor above all that the road has leaves the line from end to end.
        let line = denoised(&record, 0.01, 1e6);
        let bend = line.windows(3).map(|x| (x[0] - 2.0 * x[1] + x[2]).abs());
        assert!(bend.fold(0.0, f64::max) < 1e-9);
    }
}
