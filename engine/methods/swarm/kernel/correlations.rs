//! Lagged products of a record's signals, by Fourier transform, block by block.

use std::ops::Range;

use veloid_fourier::Complex;

/// Signals that are correlated with each other.
pub const SIGNALS: usize = 3;
/// Ordered pairs of them.
pub const PAIRS: usize = SIGNALS * SIGNALS;

/// S_ab[m] = sum over n of a(n) b(n - m) for m = 0 to `most`, by lag, then by pair (a first). Beyond each of the
/// `runs` the signals count as zero.
pub fn correlations(
    signals: [&[f64]; SIGNALS],
    runs: &[Range<usize>],
    most: usize,
) -> Vec<[f64; PAIRS]> {
    let length = (4 * most).next_power_of_two().max(4096);
    let block = length - most;
    let forward = veloid_fourier::forward(length);
    let inverse = veloid_fourier::inverse(length);
    let mut padded = forward.make_input_vec();
    let mut now = signals.map(|_| forward.make_output_vec());
    let mut before = signals.map(|_| forward.make_output_vec());
    let mut products = [(); PAIRS].map(|()| forward.make_output_vec());
    for run in runs {
        for start in run.clone().step_by(block) {
            let end = run.end.min(start + block);
            let first = start.saturating_sub(most).max(run.start);
            for (s, signal) in signals.iter().enumerate() {
                // Fails only on lengths other than planned.
                let mut transform = |range: Range<usize>, at: usize, out: &mut [Complex<f64>]| {
                    padded.fill(0.0);
                    padded[at..at + range.len()].copy_from_slice(&signal[range]);
                    let _ = forward.process(&mut padded, out);
                };
                transform(start..end, most, &mut now[s]);
                transform(first..end, most - (start - first), &mut before[s]);
            }
            for (pair, product) in products.iter_mut().enumerate() {
                let (a, b) = (&now[pair / SIGNALS], &before[pair % SIGNALS]);
                for ((p, a), b) in product.iter_mut().zip(a).zip(b) {
                    *p += a * b.conj();
                }
            }
        }
    }
    let mut all = vec![[0.0; PAIRS]; most + 1];
    for (pair, mut product) in products.into_iter().enumerate() {
        // What is not real there is rounding.
        for end in [0, length / 2] {
            product[end].im = 0.0;
        }
        let _ = inverse.process(&mut product, &mut padded);
        for (lag, sum) in all.iter_mut().zip(&padded) {
            lag[pair] = sum / length as f64;
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lagged_products_as_by_definition() {
        let wave = |f: f64| -> Vec<f64> {
            (0..9000)
                .map(|i| (f * i as f64).sin() + 0.1 * (0.37 * f * (i * i) as f64).cos())
                .collect()
        };
        let signals = [wave(0.1), wave(0.73), wave(0.011)];
        let runs = [10..300, 301..8900];
        let found = correlations(signals.each_ref().map(Vec::as_slice), &runs, 1500);
        for m in [0, 1, 7, 299, 1499, 1500] {
            for pair in 0..PAIRS {
                let (a, b) = (&signals[pair / SIGNALS], &signals[pair % SIGNALS]);
                let inside = |run: &Range<usize>| {
                    (run.start + m..run.end)
                        .map(|n| a[n] * b[n - m])
                        .sum::<f64>()
                };
                let want: f64 = runs.iter().map(inside).sum();
                assert!((found[m][pair] - want).abs() < 1e-9, "lag {m} pair {pair}");
            }
        }
    }
}
