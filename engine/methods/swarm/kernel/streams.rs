//! The inputs as the kernels read them, and what one exact step makes of them.
//!
//! The kernels simulate the compression d = z - u, which obeys
//!
//! ```text
//! d'' + (B/m) d' + (k/m) d = F/m - u''
//! ```
//!
//! u'' of a cubic spline is linear between the samples, and that of a linear road is zero between
//! them: so the road costs less than it does in z.

use crate::simulate::linear::Transition;
use veloid_core::numerics::spline::cubic;

/// Second derivatives, at the samples, of the cubic spline given by values and slopes.
pub fn curvature(values: &[f64], slopes: &[f64], step: f64) -> Vec<f64> {
    let n = values.len();
    let square = step * step;
    (0..n)
        .map(|i| {
            // From the interval after the sample, at last from the one before.
            let (j, s) = if i + 1 < n { (i, 0.0) } else { (i - 1, 1.0) };
            let c = cubic(values[j], values[j + 1], slopes[j], slopes[j + 1], step);
            (2.0 * c[2] + 6.0 * c[3] * s) / square
        })
        .collect()
}

/// Coefficients c_-1 .. c_n of the cubic B-splines that make up a spline given by values and slopes:
/// y_i = (c_{i-1} + 4 c_i + c_{i+1}) / 6. Four of them give the spline between two samples.
pub fn b_spline(values: &[f64], slopes: &[f64], step: f64) -> Vec<f64> {
    let n = values.len();
    let bend = curvature(values, slopes, step);
    let inner = (0..n).map(|i| values[i] - step * step * bend[i] / 6.0);
    let mut c: Vec<f64> = std::iter::once(0.0).chain(inner).collect();
    c[0] = c[2] - 2.0 * step * slopes[0];
    c.push(c[n - 1] + 2.0 * step * slopes[n - 1]);
    c
}

/// Powers of s in the four B-splines on one interval, times 6.
const B_SPLINES: [[f64; 4]; 4] = [
    [1.0, -3.0, 3.0, -1.0],
    [4.0, 0.0, -6.0, 3.0],
    [1.0, 3.0, 3.0, -3.0],
    [0.0, 0.0, 0.0, 1.0],
];

/// What a step adds to [d, d'] per B-spline coefficient of an acceleration.
pub fn spline_gains(t: &Transition) -> [[f64; 2]; 4] {
    B_SPLINES.map(|p| [0, 1].map(|r| (0..4).map(|j| p[j] * t.j[j][r]).sum::<f64>() / 6.0))
}

/// What a step adds to [d, d'] per end value of an acceleration that is linear in it.
pub fn linear_gains(t: &Transition) -> [[f64; 2]; 2] {
    let [constant, rising, ..] = t.j;
    [[0, 1].map(|r| constant[r] - rising[r]), rising]
}

#[cfg(test)]
mod tests {
    use super::*;
    use veloid_core::numerics::spline::slopes;

    #[test]
    fn b_splines_meet_values_and_slopes() {
        let y: Vec<f64> = (0..40)
            .map(|i| (0.3 * i as f64).sin() + 0.01 * i as f64)
            .collect();
        let m = slopes(&y, 0.02);
        let (c, bend) = (b_spline(&y, &m, 0.02), curvature(&y, &m, 0.02));
        assert_eq!((c.len(), bend.len()), (42, 40));
        for i in 0..40 {
            assert!(((c[i] + 4.0 * c[i + 1] + c[i + 2]) / 6.0 - y[i]).abs() < 1e-14);
            assert!(((c[i + 2] - c[i]) / 0.04 - m[i]).abs() < 1e-12);
            let second = (c[i] - 2.0 * c[i + 1] + c[i + 2]) / 0.0004;
            assert!((second - bend[i]).abs() < 1e-9);
        }
    }
}
