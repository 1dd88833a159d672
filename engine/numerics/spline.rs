//! Cubic spline through uniform samples, kept as values and slopes.

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
