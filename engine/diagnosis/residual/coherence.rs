//! Does a residual move with what drives the axle? Noise does not, whatever its spectrum. What a linear model leaves
//! that lacks a mode, a delay or a filter does, even where its spectrum passes for coloured noise.

use veloid_fourier::Complex;

use crate::policy;
use veloid_core::numerics::autoregressive::NoiseModel;
use veloid_core::numerics::spectrum::hann;
use veloid_model::dataset::Track;

/// Longest and shortest stretch (s, samples) whose spectra are averaged, and the fewest that show anything.
const STRETCH_S: f64 = 8.0;
const SHORTEST: usize = 64;
const FEWEST: f64 = 4.0;
/// Order of the autoregressive model that takes the residual's colour out first.
const WHITENED: usize = 4;
/// Share of the driving channel's density that its own noise may have where it is looked at.
const NOISE: f64 = 0.01;
/// Bins of Hann-windowed spectra that say as much as one by itself.
const ALIKE: f64 = 1.5;

/// What a residual has in common with the channel that drives the axle.
#[derive(Clone, Copy, Debug)]
pub struct Driven {
    /// How far it goes with that channel, as a normal deviate: the most of all octaves and of all frequencies together.
    pub score: f64,
    /// Share of the residual's power that goes with it.
    pub share: f64,
}

impl Driven {
    /// Whether the residual goes with the channel as no noise does.
    pub fn is_no_noise(&self) -> bool {
        self.score > policy::DRIVEN
    }
}

/// Compares the residual (m) of a track with the force that drives it, or with its road.
pub fn of_track(track: &Track, residual: &[f64]) -> Driven {
    let (driving, noise) = match &track.input.force {
        Some((force, _)) => (&force[..], track.force_most),
        None => (&track.input.road[..], track.road_most),
    };
    driven(residual, driving, noise, track.input.step)
}

/// Compares a residual (m) with the `driving` channel, whose own noise has at most the density `noise` (one-sided, the
/// channel's unit squared per Hz) and is white. The score is minus infinity where the record is too short or drives nothing.
fn driven(residual: &[f64], driving: &[f64], noise: f64, step: f64) -> Driven {
    // What a steep spectrum leaks into other bins goes with nothing.
    let white = NoiseModel::of_order(residual, WHITENED).whiten(residual);
    let (bins, total) = bins(residual, &white, driving, noise, step).unwrap_or_default();
    let mut bands: Vec<Vec<f64>> = vec![bins.iter().map(|b| b.gain).collect()];
    for octave in 0..usize::BITS {
        let inside = bins.iter().filter(|b| b.at.ilog2() == octave);
        bands.push(inside.map(|b| b.gain).collect());
    }
    let deviates = bands.iter().filter(|b| !b.is_empty()).map(|band| {
        let size = (ALIKE * band.len() as f64).sqrt();
        band.iter().map(|gain| gain - 1.0).sum::<f64>() / size
    });
    let common: f64 = bins.iter().map(|b| b.common).sum();
    Driven {
        score: deviates.fold(f64::NEG_INFINITY, f64::max),
        share: if total > 0.0 { common / total } else { 0.0 },
    }
}

struct Bin {
    at: usize,
    /// Gain in log likelihood that a linear relation brings, over what the channel's noise brings; one by chance.
    gain: f64,
    /// Power of the residual that goes with the channel, over what chance brings.
    common: f64,
}

/// The bins in which the channel drives the axle, and the residual's power in all.
fn bins(
    residual: &[f64],
    white: &[f64],
    driving: &[f64],
    noise: f64,
    step: f64,
) -> Option<(Vec<Bin>, f64)> {
    let n = residual.len();
    let length = ((STRETCH_S / step) as usize).min(n / 6) & !1;
    let starts = (0..n.saturating_sub(length)).step_by((length / 2).max(1));
    // Neighbouring Hann windows share about half of what they see.
    let stretches = 0.55 * starts.clone().count() as f64;
    if length < SHORTEST || stretches < FEWEST {
        return None;
    }
    let fourier = veloid_fourier::forward(length);
    let (window, power) = hann(length);
    let transform = |x: &[f64]| -> Option<Vec<Complex<f64>>> {
        let mean = x.iter().sum::<f64>() / length as f64;
        let mut part: Vec<f64> = x.iter().zip(&window).map(|(x, w)| (x - mean) * w).collect();
        let mut out = fourier.make_output_vec();
        fourier.process(&mut part, &mut out).ok()?;
        Some(out)
    };
    let mut sums = vec![(0.0, 0.0, Complex::new(0.0, 0.0)); length / 2 + 1];
    let mut power_of = vec![0.0; sums.len()];
    for start in starts {
        let x = transform(&driving[start..start + length])?;
        let y = transform(&white[start..start + length])?;
        for (s, (x, y)) in sums.iter_mut().zip(x.iter().zip(&y)) {
            s.0 += x.norm_sqr();
            s.1 += y.norm_sqr();
            s.2 += x.conj() * y;
        }
        let unfiltered = transform(&residual[start..start + length])?;
        for (sum, y) in power_of.iter_mut().zip(&unfiltered) {
            *sum += y.norm_sqr();
        }
    }
    let count = stretches / 0.55;
    let total = power_of.iter().sum();
    let reported = sums
        .iter()
        .enumerate()
        .skip(2)
        .filter_map(|(at, (x, y, xy))| {
            let share = noise * power * count / (2.0 * step) / x;
            let coherence = (xy.norm_sqr() / (x * y)).min(1.0 - 1e-9);
            let beyond = coherence - (1.0 - coherence) / (stretches - 1.0);
            let bin = Bin {
                at,
                gain: -(stretches - 1.0) * (1.0 - coherence).ln() - 2.0 * stretches * share,
                common: beyond.max(0.0) * power_of[at],
            };
            (share < NOISE && bin.gain.is_finite()).then_some(bin)
        });
    Some((reported.collect(), total))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use veloid_core::numerics::random::normal;

    const STEP: f64 = 0.01;

    fn noise(a: &[f64], seed: u64) -> Vec<f64> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let white: Vec<f64> = (0..6000).map(|_| normal(&mut rng)).collect();
        let noise_model = NoiseModel {
            a: a.to_vec(),
            variance: 1.0,
        };
        noise_model.noise_model(&white)
    }

    #[test]
    fn noise_of_any_colour_goes_with_nothing() {
        for a in [vec![], vec![-0.95], vec![-1.8, 0.9]] {
            let scores = (0..60).map(|seed| {
                let road = noise(&[-0.99], 1000 + seed);
                driven(&noise(&a, seed), &road, 1e-6, STEP).score
            });
            let most = scores.fold(f64::NEG_INFINITY, f64::max);
            assert!(most < 5.0, "{a:?}: {most}");
        }
    }

    #[test]
    fn a_mode_left_out_goes_with_what_shakes_it() {
        let shaken = noise(&[], 1);
        let mode = NoiseModel {
            a: vec![-1.8, 0.9],
            variance: 1.0,
        };
        let rms = |x: &[f64]| (x.iter().map(|x| x * x).sum::<f64>() / x.len() as f64).sqrt();
        let answer = mode.noise_model(&shaken);
        let share = 0.3 / rms(&answer);
        let pairs = answer.iter().zip(noise(&[], 2));
        let residual: Vec<f64> = pairs.map(|(a, n)| share * a + n).collect();
        let found = driven(&residual, &shaken, 0.0, STEP);
        assert!(found.score > 10.0, "{found:?}");
        let share = 0.09 / 1.09;
        assert!((found.share - share).abs() < 0.5 * share, "{found:?}");
    }

    #[test]
    fn noise_of_the_driving_channel_is_its_own() {
        let (road, noise) = (noise(&[-0.99], 3), noise(&[], 4));
        let logged: Vec<f64> = road.iter().zip(&noise).map(|(r, n)| r + 0.3 * n).collect();
        let density = 2.0 * STEP * 0.3 * 0.3;
        let reported = driven(&noise, &logged, density, STEP).score;
        assert!(reported < 5.0, "{reported}");
        let unreported = driven(&noise, &logged, 0.0, STEP).score;
        assert!(unreported > 10.0, "{unreported}");
    }

    #[test]
    fn noise_goes_with_nothing_by_so_many_deviations() {
        let goes = |score| Driven { score, share: 0.5 }.is_no_noise();
        assert!(goes(1.01 * policy::DRIVEN) && !goes(0.99 * policy::DRIVEN));
    }
}
