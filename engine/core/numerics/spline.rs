//! Cubic spline through uniform samples, kept as values and slopes.

use std::f64::consts::PI;

/// Slopes du/dt at the samples of the not-a-knot cubic spline through `values` spaced `step` (s).
///
/// Exact for cubics. Fewer than four samples fall back to differences.
pub fn slopes(values: &[f64], step: f64) -> Vec<f64> {
    let n = values.len();
    if n < 4 {
        return differences(values, step);
    }
    let y = values;
    let per_step = 3.0 / step;
    let mut m = vec![0.0; n];
    m[0] = (-5.0 * y[0] + 4.0 * y[1] + y[2]) / (2.0 * step);
    for i in 1..n - 1 {
        m[i] = (per_step * (y[i + 1] - y[i - 1]) - m[i - 1]) * upper(i);
    }
    let last = (5.0 * y[n - 1] - 4.0 * y[n - 2] - y[n - 3]) / (2.0 * step);
    m[n - 1] = (last - 2.0 * m[n - 2]) / (1.0 - 2.0 * upper(n - 2));
    for i in (0..n - 1).rev() {
        m[i] -= upper(i) * m[i + 1];
    }
    m
}

/// Weights of the even central differences of order 4, 6 and 8 in [`lifted`]: the series of one over the part that the spline passes on, in
/// powers of the square of the second difference.
const LIFT: [f64; 3] = [1.0 / 720.0, 17.0 / 30240.0, 23.0 / 151_200.0];

/// Values whose cubic spline passes on a sine of the measured ones whole, where the spline through these takes off 0.5 % at a fifth of
/// the rate: 0.03 % there, at most 1.1 times at half the rate. The ends, where differences do not reach, are as measured.
///
/// Source: Unser 1999, IEEE Signal Process. Mag. 16(6):22, eq. (13), the spline's frequency response.
pub fn lifted(values: &[f64]) -> Vec<f64> {
    let mut lifted = values.to_vec();
    // Of second, fourth, .. order; each reaches one sample less far to both ends.
    let mut difference = values.to_vec();
    for (order, weight) in [0.0].into_iter().chain(LIFT).enumerate() {
        let second = difference.windows(3).map(|y| 2.0 * y[1] - y[0] - y[2]);
        difference = second.collect();
        for (y, difference) in lifted.iter_mut().skip(order + 1).zip(&difference) {
            *y += weight * difference;
        }
    }
    lifted
}

/// Part of a sine (turns a sample) that the spline through its samples has.
pub fn response(turns: f64) -> f64 {
    let x = PI * turns;
    let sinc = if x == 0.0 { 1.0 } else { x.sin() / x };
    3.0 * sinc.powi(4) / (2.0 + (2.0 * x).cos())
}

/// Part of a sine (turns a sample) that the spline through its lifted values has.
pub fn passes(turns: f64) -> f64 {
    lift(turns) * response(turns)
}

/// How many times larger [`lifted`] makes a sine (turns a sample).
pub fn lift(turns: f64) -> f64 {
    let square = 2.0 - 2.0 * (2.0 * PI * turns).cos();
    let powers = LIFT
        .iter()
        .rev()
        .fold(0.0, |sum, weight| sum * square + weight);
    1.0 + square * square * powers
}

/// Elements above the diagonal after elimination; the last one repeats for ever.
const UPPER: [f64; 32] = {
    let mut upper = [2.0; 32];
    let mut i = 1;
    while i < upper.len() {
        upper[i] = 1.0 / (4.0 - upper[i - 1]);
        i += 1;
    }
    upper
};

#[inline(always)]
fn upper(i: usize) -> f64 {
    UPPER[i.min(UPPER.len() - 1)]
}

fn differences(y: &[f64], step: f64) -> Vec<f64> {
    let n = y.len();
    (0..n)
        .map(|i| {
            let (a, b) = (i.saturating_sub(1), (i + 1).min(n - 1));
            if a == b {
                0.0
            } else {
                (y[b] - y[a]) / ((b - a) as f64 * step)
            }
        })
        .collect()
}

/// The cubic on one interval: value(s) = c0 + c1 s + c2 s^2 + c3 s^3, s from 0 to 1.
#[inline(always)]
pub fn cubic(y0: f64, y1: f64, m0: f64, m1: f64, step: f64) -> [f64; 4] {
    let (d, a, b) = (y1 - y0, m0 * step, m1 * step);
    [y0, a, 3.0 * d - 2.0 * a - b, a + b - 2.0 * d]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sine's own part of the spline through its lifted samples, by projection over many periods.
    #[test]
    fn val_sines_pass_whole_through_lifted_values() {
        const FINE: usize = 20;
        for (turns, left) in [(0.1, 1e-6), (0.2, 3e-4), (0.25, 2.2e-3)] {
            let sine = |t: f64| (2.0 * PI * turns * t).sin();
            let y = lifted(&(0..2000).map(|i| sine(f64::from(i))).collect::<Vec<_>>());
            let m = slopes(&y, 1.0);
            let (mut with, mut own) = (0.0, 0.0);
            for i in 500..1500 {
                let c = cubic(y[i], y[i + 1], m[i], m[i + 1], 1.0);
                for s in (0..FINE).map(|s| (s as f64 + 0.5) / FINE as f64) {
                    let truth = sine(i as f64 + s);
                    with += truth * (c[0] + s * (c[1] + s * (c[2] + s * c[3])));
                    own += truth * truth;
                }
            }
            let passed = with / own;
            assert!((passed - passes(turns)).abs() < 1e-6, "{turns}: {passed}");
            assert!((passed - 1.0).abs() < left, "{turns}: {passed}");
        }
        assert!(passes(0.5) < 0.6);
    }

    #[test]
    fn cubics_and_short_records_are_as_measured() {
        let cubic: Vec<f64> = (0..20)
            .map(|i| f64::from(i).powi(3) - 4.0 * f64::from(i))
            .collect();
        let same = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-9;
        assert!(lifted(&cubic).iter().zip(&cubic).all(same));
        for count in 0..5 {
            let few: Vec<f64> = (0..count).map(|i| f64::from(i % 2)).collect();
            assert_eq!(lifted(&few).len(), count as usize);
        }
        assert_eq!(lifted(&[1.0, -1.0, 3.0, 2.0]), [1.0, -1.0, 3.0, 2.0]);
    }

    #[test]
    fn cubics_are_met_exactly() {
        let step = 0.01;
        let f = |t: f64| 1.0 - 2.0 * t + 30.0 * t * t - 400.0 * t * t * t;
        let y: Vec<f64> = (0..50).map(|i| f(i as f64 * step)).collect();
        for (i, m) in slopes(&y, step).into_iter().enumerate() {
            let t = i as f64 * step;
            assert!(
                (m - (-2.0 + 60.0 * t - 1200.0 * t * t)).abs() < 1e-9,
                "slope {i}: {m}"
            );
        }
        let m = slopes(&y, step);
        let c = cubic(y[7], y[8], m[7], m[8], step);
        let mid = c[0] + 0.5 * (c[1] + 0.5 * (c[2] + 0.5 * c[3]));
        assert!((mid - f(7.5 * step)).abs() < 1e-13);
    }

    #[test]
    fn elimination_has_come_to_rest() {
        let [.., before, last] = UPPER;
        assert_eq!(before, last);
        assert_eq!(last, 1.0 / (4.0 - last));
    }

    #[test]
    fn short_records_have_slopes_too() {
        assert_eq!(slopes(&[1.0], 0.1), [0.0]);
        assert!((slopes(&[1.0, 2.0, 3.0], 0.1)[1] - 10.0).abs() < 1e-12);
    }
}
