//! From one clock to another: cubic splines from uneven stamps, windowed sinc between even clocks.

use crate::clocks::clock::Grid;
use veloid_core::numerics::filter::mirrored;

/// Longest run of missing samples that a spline goes through; longer ones are bridged straight.
const SHORT_GAP: f64 = 4.0;

/// Values on the clock's own grid, from samples at `knots` (steps).
///
/// Even samples without gaps pass unchanged. Otherwise a cubic spline through the stamps, broken at
/// gaps of more than three samples, which are bridged by a straight line.
pub fn to_own_grid(values: Vec<f64>, knots: Option<&[f64]>, count: usize) -> Vec<f64> {
    match knots {
        None => values,
        Some(knots) => spline_at(knots, &values, (0..count).map(|k| k as f64)),
    }
}

/// The spline through (knots, values) at increasing `instants`; held beyond the ends.
pub fn spline_at(knots: &[f64], values: &[f64], instants: impl Iterator<Item = f64>) -> Vec<f64> {
    let slopes = slopes(knots, values);
    let last = knots.len() - 1;
    let mut i = 0;
    instants
        .map(|x| {
            while i + 1 < last && knots[i + 1] < x {
                i += 1;
            }
            if last == 0 || x <= knots[0] {
                return values[0];
            }
            if x >= knots[last] {
                return values[last];
            }
            let width = knots[i + 1] - knots[i];
            let s = (x - knots[i]) / width;
            let rise = values[i + 1] - values[i];
            if width > SHORT_GAP {
                return values[i] + s * rise;
            }
            let (a, b) = (slopes[i] * width, slopes[i + 1] * width);
            values[i] + s * (a + s * (3.0 * rise - 2.0 * a - b + s * (a + b - 2.0 * rise)))
        })
        .collect()
}

/// Slopes of the C2 cubic spline through uneven knots, piece by piece between long gaps; at the
/// ends of a piece those of the cubic through four samples.
fn slopes(x: &[f64], y: &[f64]) -> Vec<f64> {
    let mut out = vec![0.0; x.len()];
    let mut from = 0;
    for i in 1..=x.len() {
        if i == x.len() || x[i] - x[i - 1] > SHORT_GAP {
            piece(&x[from..i], &y[from..i], &mut out[from..i]);
            from = i;
        }
    }
    out
}

fn piece(x: &[f64], y: &[f64], m: &mut [f64]) {
    let n = x.len();
    if n < 4 {
        for (i, slope) in m.iter_mut().enumerate() {
            let (a, b) = (i.saturating_sub(1), (i + 1).min(n - 1));
            *slope = if a == b {
                0.0
            } else {
                (y[b] - y[a]) / (x[b] - x[a])
            };
        }
        return;
    }
    m[0] = end_slope(&x[..4], &y[..4], x[0]);
    m[n - 1] = end_slope(&x[n - 4..], &y[n - 4..], x[n - 1]);
    // 1/h0 m(i-1) + 2 (1/h0 + 1/h1) m(i) + 1/h1 m(i+1) = 3 (d0/h0 + d1/h1), d the chord slopes.
    let mut upper = vec![0.0; n];
    for i in 1..n - 1 {
        let (h0, h1) = (x[i] - x[i - 1], x[i + 1] - x[i]);
        let (d0, d1) = ((y[i] - y[i - 1]) / h0, (y[i + 1] - y[i]) / h1);
        let pivot = 2.0 * (1.0 / h0 + 1.0 / h1) - upper[i - 1] / h0;
        upper[i] = 1.0 / h1 / pivot;
        m[i] = (3.0 * (d0 / h0 + d1 / h1) - m[i - 1] / h0) / pivot;
    }
    for i in (1..n - 1).rev() {
        m[i] -= upper[i] * m[i + 1];
    }
}

/// Slope at `at` of the cubic through four points.
fn end_slope(x: &[f64], y: &[f64], at: f64) -> f64 {
    let mut slope = 0.0;
    for i in 0..4 {
        let others: Vec<f64> = (0..4).filter(|j| *j != i).map(|j| x[j]).collect();
        let scale: f64 = others.iter().map(|o| x[i] - o).product();
        let derivative: f64 = (0..3)
            .map(|skip| {
                let rest = others.iter().enumerate().filter(|(j, _)| *j != skip);
                rest.map(|(_, o)| at - o).product::<f64>()
            })
            .sum();
        slope += y[i] * derivative / scale;
    }
    slope
}

/// How rough samples are when placed at `knots`: mean square deviation from the cubic through two
/// neighbours on either side. Used to distinguish stamps that jitter from sampling that does.
pub fn roughness(knots: &[f64], values: &[f64]) -> f64 {
    let stride = (knots.len() / 20_000).max(1);
    let (mut sum, mut n) = (0.0, 0usize);
    for (x, y) in knots.windows(5).zip(values.windows(5)).step_by(stride) {
        if x[4] - x[0] > 6.0 {
            continue;
        }
        let mut off = y[2];
        for i in [0, 1, 3, 4] {
            let weight: f64 = ([0, 1, 3, 4].iter().filter(|j| **j != i))
                .map(|j| (x[2] - x[*j]) / (x[i] - x[*j]))
                .product();
            off -= weight * y[i];
        }
        if off.is_finite() {
            sum += off * off;
            n += 1;
        }
    }
    sum / n.max(1) as f64
}

/// Half width of the kernel in samples of the slower clock, and its table's resolution.
const HALF_WIDTH: f64 = 32.0;
const TABLE: usize = 512;
/// Cutoff in cycles per sample of the slower clock: flat to 0.42, 80 dB down at 0.5.
const CUTOFF: f64 = 0.46;
const KAISER: f64 = 8.0;
/// Up to here [`convert`] leaves a channel as it was, in cycles per sample of the slower clock.
pub const FLAT: f64 = 0.42;

/// Values on the grid `to` from values on the grid `from`: low-passed for the slower of the two by
/// a Kaiser-windowed sinc, symmetric in time, mirrored at the ends and held beyond what that gives.
pub fn convert(values: &[f64], from: Grid, to: Grid) -> Vec<f64> {
    let ratio = (from.step_s / to.step_s).min(1.0);
    let n = values.len() as f64;
    // No further than once over the record on either side of it, whatever the two rates are.
    let reach = (HALF_WIDTH / ratio).min(n);
    let mut before: Option<(f64, f64)> = None;
    let table: Vec<f64> = (0..=(HALF_WIDTH as usize) * TABLE + 1)
        .map(|i| kernel(i as f64 / TABLE as f64))
        .collect();
    (0..to.count)
        .map(|k| {
            let x = ((to.at(k) - from.start_s) / from.step_s).clamp(-n, 2.0 * n);
            if let Some((at, value)) = before
                && at == x
            {
                return value;
            }
            let (first, last) = ((x - reach).ceil() as isize, (x + reach).floor() as isize);
            let (mut sum, mut weights) = (0.0, 0.0);
            for j in first..=last {
                let at = (x - j as f64).abs() * ratio * TABLE as f64;
                let i = at as usize;
                let part = at - i as f64;
                let (Some(h0), Some(h1)) = (table.get(i), table.get(i + 1)) else {
                    continue;
                };
                let h = h0 + part * (h1 - h0);
                sum += h * mirrored(values, j);
                weights += h;
            }
            before = Some((x, sum / weights));
            sum / weights
        })
        .collect()
}

/// Kaiser-windowed sinc at `x` samples from its middle.
fn kernel(x: f64) -> f64 {
    let inside = 1.0 - (x / HALF_WIDTH).powi(2);
    if inside <= 0.0 {
        return 0.0;
    }
    let angle = std::f64::consts::TAU * CUTOFF * x;
    let sinc = if angle == 0.0 {
        1.0
    } else {
        angle.sin() / angle
    };
    sinc * bessel_i0(KAISER * inside.sqrt())
}

/// Modified Bessel function of the first kind, order 0, by its series.
fn bessel_i0(x: f64) -> f64 {
    let (mut term, mut sum, mut k) = (1.0, 1.0, 1.0);
    while term > 1e-17 * sum {
        term *= (x / (2.0 * k)) * (x / (2.0 * k));
        sum += term;
        k += 1.0;
    }
    sum
}

/// Largest mismatch (steps) of two clocks that are taken for one.
const SAME: f64 = 5e-3;

/// Whether every instant of `to` is one of `from`; the offset if so.
pub fn offset(from: Grid, to: Grid) -> Option<usize> {
    let drift = (to.step_s / from.step_s - 1.0).abs() * to.count as f64;
    let shift = (to.start_s - from.start_s) / from.step_s;
    let whole = shift.round();
    let fits = drift < SAME
        && (shift - whole).abs() < SAME
        && whole >= 0.0
        && whole as usize + to.count <= from.count;
    fits.then_some(whole as usize)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn grid(rate: f64, count: usize) -> Grid {
        Grid {
            start_s: 0.0,
            step_s: 1.0 / rate,
            count,
        }
    }

    fn sine(hz: f64, grid: Grid) -> Vec<f64> {
        (0..grid.count)
            .map(|k| (TAU * hz * grid.at(k) + 0.3).sin())
            .collect()
    }

    fn worst(a: &[f64], b: &[f64]) -> f64 {
        let margin = a.len() / 8;
        (margin..a.len() - margin)
            .map(|i| (a[i] - b[i]).abs())
            .fold(0.0, f64::max)
    }

    #[test]
    fn cubics_pass_through_uneven_knots() {
        let f = |x: f64| 1.0 - x + 0.5 * x * x - 0.01 * x * x * x;
        let knots: Vec<f64> = (0..40).map(|i| i as f64 + 0.3 * (i as f64).sin()).collect();
        let values: Vec<f64> = knots.iter().map(|x| f(*x)).collect();
        let at: Vec<f64> = (1..380).map(|i| i as f64 * 0.1).collect();
        for (x, y) in at
            .iter()
            .zip(spline_at(&knots, &values, at.iter().copied()))
        {
            assert!((y - f(*x)).abs() < 1e-9, "at {x}: {y} is not {}", f(*x));
        }
    }

    #[test]
    fn long_gaps_are_bridged_straight() {
        let knots = [0.0, 1.0, 2.0, 3.0, 13.0, 14.0, 15.0, 16.0];
        let values = [0.0, 1.0, 4.0, 9.0, 19.0, 5.0, 5.0, 5.0];
        let y = to_own_grid(values.to_vec(), Some(&knots), 17);
        assert!(
            (4..13).all(|k| (y[k] - (9.0 + (k as f64 - 3.0))).abs() < 1e-12),
            "{y:?}"
        );
        assert!((y[2] - 4.0).abs() + (y[14] - 5.0).abs() < 1e-12);
    }

    #[test]
    fn decimation_keeps_the_band_and_drops_what_would_alias() {
        let (fast, slow) = (grid(250.0, 5000), grid(100.0, 2000));
        assert!(worst(&convert(&sine(11.0, fast), fast, slow), &sine(11.0, slow)) < 2e-4);
        assert!(worst(&convert(&sine(41.0, fast), fast, slow), &sine(41.0, slow)) < 2e-3);
        for hz in [51.0, 70.0, 89.0, 110.0] {
            let left = convert(&sine(hz, fast), fast, slow);
            assert!(worst(&left, &vec![0.0; 2000]) < 1e-3, "{hz} Hz");
        }
    }

    #[test]
    fn interpolation_is_true_to_near_the_nyquist_rate() {
        let (slow, fast) = (grid(30.0, 1200), grid(100.0, 4000));
        assert!(worst(&convert(&sine(11.0, slow), slow, fast), &sine(11.0, fast)) < 1e-3);
        let shifted = Grid {
            start_s: 0.0123,
            ..slow
        };
        assert!(
            worst(
                &convert(&sine(11.0, slow), slow, shifted),
                &sine(11.0, shifted)
            ) < 1e-3
        );
        assert!(
            convert(&vec![2.5; 1200], slow, fast)
                .iter()
                .all(|y| (y - 2.5).abs() < 1e-12)
        );
    }

    #[test]
    fn equal_clocks_are_known() {
        let g = grid(100.0, 1000);
        assert_eq!(
            offset(
                g,
                Grid {
                    start_s: 0.05,
                    count: 900,
                    ..g
                }
            ),
            Some(5)
        );
        assert_eq!(
            offset(
                g,
                Grid {
                    start_s: 0.055,
                    count: 900,
                    ..g
                }
            ),
            None
        );
        assert_eq!(
            offset(
                g,
                Grid {
                    start_s: 0.05,
                    count: 996,
                    ..g
                }
            ),
            None
        );
        assert_eq!(
            offset(
                g,
                Grid {
                    step_s: 0.0101,
                    count: 900,
                    ..g
                }
            ),
            None
        );
    }

    #[test]
    fn roughness_shows_true_stamps_from_noisy_ones() {
        let even: Vec<f64> = (0..3000).map(|i| i as f64).collect();
        let uneven: Vec<f64> = even.iter().map(|x| x + 0.15 * (x * x).sin()).collect();
        let at = |knots: &[f64]| -> Vec<f64> { knots.iter().map(|x| (0.5 * x).sin()).collect() };
        assert!(roughness(&uneven, &at(&uneven)) < 0.1 * roughness(&even, &at(&uneven)));
        assert!(roughness(&even, &at(&even)) < 0.1 * roughness(&uneven, &at(&even)));
    }
}
