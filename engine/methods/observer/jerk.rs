//! The jerk bound f of paper eq. (15), estimated from the ride.

use std::ops::RangeInclusive;

/// Half widths (samples) of the local cubics that the jerk is read from.
const HALF_WIDTHS: RangeInclusive<usize> = 2..=25;
/// RMS of the jerk over that of its noise, at which a window counts as wide enough.
const CLEAR_OF_NOISE: f64 = 3.0;
/// Least bound (m/s^3), for rides at rest.
const FLOOR: f64 = 1e-6;

/// Twice the largest jerk |y'''| (m/s^3): paper eq. (15) and the remark below it.
///
/// The jerk is the third derivative of least-squares cubics over the narrowest window in which it
/// stands clear of the measurement noise, whose size comes from the sixth differences of `y`: so
/// noise does not set the bound. Windows that touch a sample not `valid` are left out.
pub fn bound(y: &[f64], valid: &[bool], step: f64) -> f64 {
    let noise = noise(y);
    let mut best = (0.0, 0.0);
    for m in HALF_WIDTHS {
        if 2 * m + 1 > y.len() {
            break;
        }
        let cubic = Cubic::new(m, step);
        let (rms, largest) = cubic.jerk(y, valid);
        let clear = rms / (noise * cubic.gain).max(f64::MIN_POSITIVE);
        if clear > best.0 {
            best = (clear, largest);
        }
        if clear >= CLEAR_OF_NOISE {
            break;
        }
    }
    (2.0 * best.1).max(FLOOR)
}

/// Standard deviation of the white part of `y`, by the median of its absolute sixth differences.
fn noise(y: &[f64]) -> f64 {
    const GAUSS_MEDIAN: f64 = 0.6745;
    /// Sum of the squares of 1, 6, 15, 20, 15, 6, 1.
    const SQUARES: f64 = 924.0;
    let mut sixth: Vec<f64> = y
        .windows(7)
        .map(|w| (w[0] + w[6] - 6.0 * (w[1] + w[5]) + 15.0 * (w[2] + w[4]) - 20.0 * w[3]).abs())
        .collect();
    if sixth.is_empty() {
        return 0.0;
    }
    let middle = sixth.len() / 2;
    let (_, median, _) = sixth.select_nth_unstable_by(middle, f64::total_cmp);
    *median / (GAUSS_MEDIAN * SQUARES.sqrt())
}

/// Third derivative of the least-squares cubic over 2m + 1 samples.
struct Cubic {
    /// Weights of y at +1 .. +m; those at -1 .. -m are their negatives.
    weights: Vec<f64>,
    /// Standard deviation of the derivative per standard deviation of white noise on y.
    gain: f64,
}

impl Cubic {
    fn new(m: usize, step: f64) -> Self {
        let mf = m as f64;
        // The third orthogonal polynomial over -m .. m.
        let orthogonal = |i: f64| 5.0 * i * i * i - (3.0 * mf * mf + 3.0 * mf - 1.0) * i;
        let on_cube: f64 = (1..=m)
            .map(|i| 2.0 * orthogonal(i as f64) * (i as f64).powi(3))
            .sum();
        let weights: Vec<f64> = (1..=m)
            .map(|i| 6.0 * orthogonal(i as f64) / (on_cube * step.powi(3)))
            .collect();
        let gain = weights.iter().map(|w| 2.0 * w * w).sum::<f64>().sqrt();
        Self { weights, gain }
    }

    /// RMS and largest magnitude over the record.
    fn jerk(&self, y: &[f64], valid: &[bool]) -> (f64, f64) {
        let m = self.weights.len();
        let (mut sum, mut count, mut largest) = (0.0, 0_usize, 0.0_f64);
        let mut clean = 0;
        for (last, ok) in valid.iter().enumerate() {
            clean = if *ok { clean + 1 } else { 0 };
            if clean < 2 * m + 1 {
                continue;
            }
            let middle = last - m;
            let jerk: f64 = self
                .weights
                .iter()
                .enumerate()
                .map(|(i, w)| w * (y[middle + 1 + i] - y[middle - 1 - i]))
                .sum();
            sum += jerk * jerk;
            count += 1;
            largest = largest.max(jerk.abs());
        }
        ((sum / count.max(1) as f64).sqrt(), largest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cubic_reads_its_own_derivative() {
        let step = 0.01;
        let y: Vec<f64> = (0..100)
            .map(|i| {
                let t = i as f64 * step;
                3.0 * t * t * t - t * t + 0.4
            })
            .collect();
        for m in [2, 5, 20] {
            let (rms, largest) = Cubic::new(m, step).jerk(&y, &[true; 100]);
            assert!((rms - 18.0).abs() < 1e-6 && (largest - 18.0).abs() < 1e-5);
        }
    }

    #[test]
    fn noise_does_not_set_the_bound() {
        let (step, w, n) = (0.01, 30.0_f64, 3000);
        let clean: Vec<f64> = (0..n)
            .map(|i| 0.005 * (w * i as f64 * step).sin())
            .collect();
        let truth = 2.0 * 0.005 * w.powi(3);
        let mut state = 1_u64;
        let mut white = || {
            state = state
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        for size in [0.0, 1e-4, 5e-4, 2e-3] {
            let y: Vec<f64> = clean.iter().map(|y| y + size * white()).collect();
            let found = bound(&y, &vec![true; n], step);
            assert!(
                found > 0.5 * truth && found < 3.0 * truth,
                "noise {size}: {found} m/s^3 for {truth}"
            );
        }
    }

    #[test]
    fn samples_not_valid_are_left_out() {
        let mut y: Vec<f64> = (0..500).map(|i| 0.01 * (0.1 * i as f64).sin()).collect();
        let mut valid = vec![true; 500];
        let calm = bound(&y, &valid, 0.01);
        y[250] = 1.0;
        valid[250] = false;
        assert_eq!(bound(&y, &valid, 0.01), calm);
    }
}
