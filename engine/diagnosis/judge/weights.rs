//! How much each set of effects weighs by what it leaves of held-out windows: pseudo-BMA+ (Yao, Vehtari, Simpson & Gelman 2018,
//! doi:10.1214/17-BA1091), with Bayesian bootstrap over blocks of windows (Rubin 1981, doi:10.1214/aos/1176345338).
//!
//! The log score of a set that is complete counts with every sample. Where even the best one leaves more than noise, the same
//! model error repeats in every sample, and the record is worth fewer: `n` samples of which a part `m` of the squares is no noise count as
//! `n / (1 + n m / PATIENCE)`, the power posterior of Miller & Dunson (2019, doi:10.1080/01621459.2018.1469995).

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::numbers::Numbers;
use super::scores::{ScoredSet, Scores};

/// Draws of the bootstrap: the weight of a set that has a half is known to 0.025.
const DRAWS: usize = 400;
const SEED: u64 = 1;
/// Share of the variance that a model which runs away leaves.
pub const MOST: f64 = 1e4;

/// Weights of the sets at one length, in their order; they sum to one.
pub fn weights(scores: &Scores, sets: &[&ScoredSet], length: usize, numbers: &Numbers) -> Vec<f64> {
    let Some(windows) = scores.lengths.get(length) else {
        return Vec::new();
    };
    let best = sets.iter().map(|s| s.mean(length)).fold(MOST, f64::min);
    let floor = windows.noise.min(best);
    let samples = windows.samples as f64;
    let worth = samples / (1.0 + samples * (1.0 - floor / best) / numbers.patience);
    let logs: Vec<Vec<f64>> = (sets.iter())
        .map(|s| {
            s.left[length]
                .iter()
                .map(|left| (left.min(MOST) + floor).ln())
                .collect()
        })
        .collect();
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    let mut sums = vec![0.0; sets.len()];
    for _ in 0..DRAWS {
        let parts = dirichlet(&mut rng, logs.first().map_or(0, Vec::len));
        let score = |(logs, set): (&Vec<f64>, &&ScoredSet)| {
            let mean: f64 = logs.iter().zip(&parts).map(|(log, part)| log * part).sum();
            -0.5 * worth * mean - numbers.occam * set.parameters as f64
        };
        let scored: Vec<f64> = logs.iter().zip(sets).map(score).collect();
        let most = scored.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let odds: Vec<f64> = scored.iter().map(|s| (s - most).exp()).collect();
        let all: f64 = odds.iter().sum();
        sums.iter_mut()
            .zip(odds)
            .for_each(|(sum, odds)| *sum += odds / all);
    }
    sums.iter().map(|sum| sum / DRAWS as f64).collect()
}

/// Parts of one, uniform over all that sum to it.
fn dirichlet(rng: &mut ChaCha8Rng, count: usize) -> Vec<f64> {
    let draws: Vec<f64> = (0..count)
        .map(|_| -(1.0 - rng.random::<f64>()).ln())
        .collect();
    let all: f64 = draws.iter().sum();
    draws.iter().map(|draw| draw / all).collect()
}
