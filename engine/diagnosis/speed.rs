//! Acceleration from a noisy speed channel.

/// Half windows (s) to choose among.
const HALVES_S: [f64; 8] = [0.05, 0.1, 0.15, 0.25, 0.4, 0.6, 0.9, 1.3];

/// Rate of change of `x` for each second, by local quadratics over the window that predicts left-out
/// samples best.
pub fn rate(x: &[f64], step: f64) -> Vec<f64> {
    let widest = x.len().saturating_sub(1) / 2;
    let halves = HALVES_S.map(|s| ((s / step).round() as usize).clamp(2, widest.max(2)));
    if widest < 2 || x.iter().all(|v| *v == x[0]) {
        return vec![0.0; x.len()];
    }
    let error = |half: usize| -> f64 {
        let own = 1.0 / moments(half).0 + leverage(half);
        (half..x.len() - half)
            .map(|i| ((x[i] - local(x, i, half)[0]) / (1.0 - own)).powi(2))
            .sum::<f64>()
            / (x.len() - 2 * half) as f64
    };
    let best = halves
        .into_iter()
        .min_by(|a, b| error(*a).total_cmp(&error(*b)))
        .unwrap_or(2);
    (0..x.len())
        .map(|i| {
            let centre = i.clamp(best, x.len() - 1 - best);
            let [_, b, c] = local(x, centre, best);
            (b + 2.0 * c * (i as f64 - centre as f64)) / step
        })
        .collect()
}

/// Number of samples and sums of squares and fourth powers of the places in a window.
fn moments(half: usize) -> (f64, f64, f64) {
    (1..=half).fold((1.0, 0.0, 0.0), |(n, s2, s4), k| {
        let q = (k * k) as f64;
        (n + 2.0, s2 + 2.0 * q, s4 + 2.0 * q * q)
    })
}

/// What the quadratic term adds to the weight of the middle sample in its own fit.
fn leverage(half: usize) -> f64 {
    let (n, s2, s4) = moments(half);
    let mean = s2 / n;
    mean * mean / (s4 - n * mean * mean)
}

/// Quadratic a + b k + c k^2 through the window around `at`, by least squares.
fn local(x: &[f64], at: usize, half: usize) -> [f64; 3] {
    let (n, s2, s4) = moments(half);
    let (mut y0, mut y1, mut y2) = (x[at], 0.0, 0.0);
    for k in 1..=half {
        let (later, earlier) = (x[at + k], x[at - k]);
        y0 += later + earlier;
        y1 += k as f64 * (later - earlier);
        y2 += (k * k) as f64 * (later + earlier);
    }
    let c = (y2 - s2 * y0 / n) / (s4 - s2 * s2 / n);
    [(y0 - c * s2) / n, y1 / s2, c]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parabola_is_exact_to_the_ends() {
        let x: Vec<f64> = (0..300)
            .map(|i| 2.0 + 0.03 * i as f64 - 1e-4 * (i * i) as f64)
            .collect();
        for (i, r) in rate(&x, 0.01).iter().enumerate() {
            assert!((r - (3.0 - 0.02 * i as f64)).abs() < 1e-8, "{i}: {r}");
        }
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
