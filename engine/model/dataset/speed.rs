//! Acceleration from a noisy speed channel.

use nalgebra::DMatrix;

/// Half windows (s) to choose among.
const HALVES_S: [f64; 8] = [0.05, 0.1, 0.15, 0.25, 0.4, 0.6, 0.9, 1.3];
/// Samples that span the widest half window: above 1 kHz means over several samples stand for them, so that the
/// work for each does not grow with the rate.
const FINEST: f64 = 1300.0;
/// Degree of the local polynomials: quadratics take 1.5 % off the acceleration of a bicycle, quartics 0.2 %.
const DEGREE: usize = 4;

/// Rate of change of `x` for each second, by local polynomials (Savitzky & Golay 1964, Anal. Chem.
/// 36:1627) over the window that predicts left-out samples best.
pub fn rate(x: &[f64], step: f64) -> Vec<f64> {
    let widest_s = HALVES_S[HALVES_S.len() - 1];
    let together = (widest_s / step / FINEST).floor().min(x.len() as f64 / 4.0) as usize;
    if together > 1 {
        let means: Vec<f64> = (x.chunks_exact(together))
            .map(|x| x.iter().sum::<f64>() / together as f64)
            .collect();
        let rates = rate(&means, step * together as f64);
        let last = rates.len() - 1;
        let between = |i: usize| {
            // From the middle of one mean to that of the next.
            let at = ((i as f64 + 0.5) / together as f64 - 0.5).clamp(0.0, last as f64);
            let (j, part) = (at as usize, at.fract());
            rates[j] + part * (rates[(j + 1).min(last)] - rates[j])
        };
        return (0..x.len()).map(between).collect();
    }
    let widest = x.len().saturating_sub(1) / 2;
    if widest < DEGREE || x.iter().all(|v| *v == x[0]) {
        return vec![0.0; x.len()];
    }
    let fitting = HALVES_S
        .map(|s| ((s / step).round() as usize).clamp(DEGREE, widest))
        .into_iter()
        .filter_map(Local::new);
    let best = fitting.min_by(|a, b| a.error(x).total_cmp(&b.error(x)));
    let Some(best) = best else {
        return vec![0.0; x.len()];
    };
    (0..x.len())
        .map(|i| {
            let centre = i.clamp(best.half, x.len() - 1 - best.half);
            best.slope(x, centre, i as f64 - centre as f64) / step
        })
        .collect()
}

/// Polynomials through windows of `2 half + 1` samples, by least squares.
struct Local {
    half: usize,
    /// Weights of the window's samples in each coefficient, by column; the place in it runs from -1 to 1.
    weights: DMatrix<f64>,
}

impl Local {
    fn new(half: usize) -> Option<Self> {
        let powers = DMatrix::from_fn(2 * half + 1, DEGREE + 1, |i, p| {
            (i as f64 / half as f64 - 1.0).powi(p as i32)
        });
        let weights = powers.pseudo_inverse(1e-12).ok()?.transpose();
        Some(Self { half, weights })
    }

    fn coefficient(&self, x: &[f64], at: usize, power: usize) -> f64 {
        let window = &x[at - self.half..=at + self.half];
        let weights = self.weights.column(power);
        window.iter().zip(weights.iter()).map(|(x, w)| x * w).sum()
    }

    /// Mean square error of samples predicted from their neighbours.
    fn error(&self, x: &[f64]) -> f64 {
        let own = self.weights[(self.half, 0)];
        let inner = self.half..x.len() - self.half;
        let count = inner.len() as f64;
        let off = |i: usize| (x[i] - self.coefficient(x, i, 0)) / (1.0 - own);
        inner.map(|i| off(i).powi(2)).sum::<f64>() / count
    }

    /// Slope for each sample, `off` samples beside the middle of the window around `at`.
    fn slope(&self, x: &[f64], at: usize, off: f64) -> f64 {
        let place = off / self.half as f64;
        let terms = (1..=DEGREE).filter(|power| *power == 1 || off != 0.0);
        let slope: f64 = terms
            .map(|p| p as f64 * place.powi(p as i32 - 1) * self.coefficient(x, at, p))
            .sum();
        slope / self.half as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quartic_is_exact_to_the_ends() {
        let x: Vec<f64> = (0..300)
            .map(|i| i as f64 / 100.0)
            .map(|t| 2.0 + 3.0 * t - t * t + 0.5 * t.powi(4))
            .collect();
        for (i, r) in rate(&x, 0.01).iter().enumerate() {
            let t = i as f64 / 100.0;
            assert!(
                (r - (3.0 - 2.0 * t + 2.0 * t.powi(3))).abs() < 1e-8,
                "{i}: {r}"
            );
        }
    }

    /// Above 1 kHz means over several samples are looked at; they say the same.
    #[test]
    fn a_fast_logger_shows_the_same_acceleration() {
        let x: Vec<f64> = (0..40_000).map(|i| (i as f64 / 10_000.0).sin()).collect();
        for (i, r) in rate(&x, 1e-4).iter().enumerate() {
            let t = i as f64 / 10_000.0;
            assert!((r - t.cos()).abs() < 1e-3, "{i}: {r}");
        }
        // As many steps as at 1 kHz, however short the step.
        assert_eq!(rate(&x, 1e-20).len(), x.len());
    }

    #[test]
    fn noise_widens_the_window() {
        let mut state = 1_u64;
        let mut noise = || {
            state = state
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let x: Vec<f64> = (0..4000)
            .map(|i| (0.005 * i as f64).sin() + 0.03 * noise())
            .collect();
        let off = rate(&x, 0.01)
            .iter()
            .enumerate()
            .map(|(i, r)| (r - 0.5 * (0.005 * i as f64).cos()).powi(2))
            .sum::<f64>();
        assert!((off / 4000.0).sqrt() < 0.02, "{}", (off / 4000.0).sqrt());
    }

    #[test]
    fn a_few_samples_do_no_harm() {
        assert_eq!(rate(&[1.0, 2.0], 0.01), vec![0.0; 2]);
    }
}
