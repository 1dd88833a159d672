//! Levenberg-Marquardt where eight sets of numbers cost what one costs: every step tries eight dampings at once.

use nalgebra::{DMatrix, DVector};

use veloid_core::numerics::lanes::LANES;

/// How hard a fit tries.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    pub iterations: usize,
    /// Stops when a step gains less than this in log likelihood.
    pub gain: f64,
    pub substeps: usize,
}

/// A typical size and the limits of a number.
pub type Range = (f64, [f64; 2]);

/// The whitened normal equations at a point.
pub struct Normal {
    pub cost: f64,
    pub gradient: DVector<f64>,
    pub matrix: DMatrix<f64>,
    /// Measured minus simulated, by axle, where they are one ride's.
    pub residuals: Vec<Vec<f64>>,
}

impl Normal {
    /// Without any sample of so many numbers.
    pub fn zero(count: usize) -> Self {
        Self {
            cost: 0.0,
            gradient: DVector::zeros(count),
            matrix: DMatrix::zeros(count, count),
            residuals: Vec::new(),
        }
    }
}

/// Values at a minimum within `ranges` and the normal equations there; nothing where the start has no finite cost.
pub fn minimise(
    mut values: Vec<f64>,
    ranges: &[Range],
    effort: Effort,
    equations: impl Fn(&[f64]) -> Option<Normal>,
    costs: impl Fn(&[Vec<f64>; LANES]) -> [f64; LANES],
) -> Option<(Vec<f64>, Normal)> {
    let mut damping = 1e-3;
    let mut normal = equations(&values)?;
    for _ in 0..effort.iterations {
        let dampings: [f64; LANES] = std::array::from_fn(|i| damping * 10_f64.powi(i as i32 - 2));
        let tried = dampings.map(|d| stepped(&values, ranges, &normal, d));
        let costs = costs(&tried);
        let best = (0..LANES).min_by(|a, b| costs[*a].total_cmp(&costs[*b]))?;
        let gained = normal.cost - costs[best];
        if gained > 0.0 {
            values = tried[best].clone();
            damping = (0.3 * dampings[best]).clamp(1e-9, 1e6);
            normal = equations(&values)?;
            if gained < 2.0 * effort.gain {
                break;
            }
        } else {
            damping *= 1e4;
            if damping > 1e8 {
                break;
            }
        }
    }
    Some((values, normal))
}

/// The values that a damped Gauss-Newton step leads to, kept within the limits.
pub fn stepped(values: &[f64], ranges: &[Range], normal: &Normal, damping: f64) -> Vec<f64> {
    let n = values.len();
    // A value at its limit and pushed outwards stays where it is.
    let stuck: Vec<bool> = (0..n)
        .map(|i| {
            let (value, g) = (values[i], normal.gradient[i]);
            (value <= ranges[i].1[0] && g < 0.0) || (value >= ranges[i].1[1] && g > 0.0)
        })
        .collect();
    let scale = DVector::from_fn(n, |i, _| {
        let d = normal.matrix[(i, i)];
        if d > 0.0 && !stuck[i] {
            d.sqrt().recip()
        } else {
            0.0
        }
    });
    let mut matrix = DMatrix::from_fn(n, n, |i, j| scale[i] * normal.matrix[(i, j)] * scale[j]);
    for i in 0..n {
        matrix[(i, i)] = 1.0 + damping;
    }
    let right = DVector::from_fn(n, |i, _| scale[i] * normal.gradient[i]);
    let mut next = values.to_vec();
    if let Some(factor) = matrix.cholesky() {
        let step = factor.solve(&right);
        for i in 0..n {
            let [low, high] = ranges[i].1;
            next[i] = (values[i] + scale[i] * step[i]).max(low).min(high);
        }
    }
    next
}

/// Inverse of a Gauss-Newton matrix; a number without any influence gets an infinite variance.
pub fn inverse(matrix: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let n = matrix.nrows();
    let scale: Vec<f64> = (0..n).map(|i| matrix[(i, i)].max(0.0).sqrt()).collect();
    let unit = DMatrix::from_fn(n, n, |i, j| {
        if i == j {
            1.0 + 1e-12
        } else if scale[i] > 0.0 && scale[j] > 0.0 {
            matrix[(i, j)] / (scale[i] * scale[j])
        } else {
            0.0
        }
    });
    let inverse = unit
        .clone()
        .cholesky()
        .map(|c| c.inverse())
        .or_else(|| unit.pseudo_inverse(1e-12).ok())?;
    Some(DMatrix::from_fn(n, n, |i, j| {
        let s = scale[i] * scale[j];
        if s > 0.0 {
            inverse[(i, j)] / s
        } else if i == j {
            f64::INFINITY
        } else {
            0.0
        }
    }))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    const FREE: Range = (1.0, [f64::NEG_INFINITY, f64::INFINITY]);

    /// Normal equations of (x - 3)^2 + 4 (y + 1)^2 + (x + y - c)^2.
    fn normal(values: &[f64], c: f64) -> Normal {
        let [x, y] = [values[0], values[1]];
        let errors = [3.0 - x, 2.0 * (-1.0 - y), c - x - y];
        let rows = [[1.0, 0.0], [0.0, 2.0], [1.0, 1.0]];
        let entry = |i: usize, j: usize| -> f64 { rows.iter().map(|r| r[i] * r[j]).sum() };
        let slope = |i: usize| -> f64 { rows.iter().zip(errors).map(|(r, e)| r[i] * e).sum() };
        Normal {
            cost: errors.iter().map(|e| e * e).sum(),
            gradient: DVector::from_fn(2, |i, _| slope(i)),
            matrix: DMatrix::from_fn(2, 2, entry),
            residuals: Vec::new(),
        }
    }

    /// Where that is least: 2x + y = 3 + c and x + 5y = c - 4.
    fn least(c: f64) -> [f64; 2] {
        [
            (5.0 * (3.0 + c) - (c - 4.0)) / 9.0,
            (2.0 * (c - 4.0) - (3.0 + c)) / 9.0,
        ]
    }

    #[test]
    fn a_step_without_damping_ends_at_the_least_of_squares() {
        let next = stepped(&[0.0, 0.0], &[FREE; 2], &normal(&[0.0, 0.0], 6.0), 0.0);
        let [x, y] = least(6.0);
        assert!(
            (next[0] - x).abs() < 1e-12 && (next[1] - y).abs() < 1e-12,
            "{next:?}"
        );
        // One number alone moves 1 / (1 + damping) of the way.
        let one = Normal {
            cost: 25.0,
            gradient: DVector::from_element(1, 20.0),
            matrix: DMatrix::from_element(1, 1, 4.0),
            residuals: Vec::new(),
        };
        let damped = stepped(&[0.0], &[FREE], &one, 3.0);
        assert!((damped[0] - 5.0 / 4.0).abs() < 1e-12);
    }

    #[test]
    fn a_value_pushed_out_of_its_limits_stays_at_them() {
        let ranges = [(1.0, [0.0, 0.5]), FREE];
        let next = stepped(&[0.0, 0.0], &ranges, &normal(&[0.0, 0.0], 6.0), 0.0);
        assert_eq!(next[0], 0.5);
        // At its limit it is left out, and the other has its least beside it: 5 y = c - 4 - x.
        let next = stepped(&[0.5, 0.0], &ranges, &normal(&[0.5, 0.0], 6.0), 0.0);
        assert_eq!(next[0], 0.5);
        assert!((next[1] - (6.0 - 4.0 - 0.5) / 5.0).abs() < 1e-12);
    }

    #[test]
    fn a_minimum_is_found_within_the_limits() {
        let effort = Effort {
            iterations: 50,
            gain: 1e-15,
            substeps: 1,
        };
        let found = |ranges: &[Range]| {
            let costs = |all: &[Vec<f64>; LANES]| all.each_ref().map(|v| normal(v, 6.0).cost);
            let equations = |values: &[f64]| Some(normal(values, 6.0));
            minimise(vec![-5.0, 9.0], ranges, effort, equations, costs)
                .unwrap()
                .0
        };
        let free = found(&[FREE; 2]);
        let [x, y] = least(6.0);
        assert!(
            (free[0] - x).abs() < 1e-5 && (free[1] - y).abs() < 1e-5,
            "{free:?}"
        );
        let held = found(&[(1.0, [-10.0, 1.0]), FREE]);
        assert_eq!(held[0], 1.0);
        assert!((held[1] - (6.0 - 4.0 - 1.0) / 5.0).abs() < 1e-5, "{held:?}");
    }

    #[test]
    fn the_inverse_of_what_shows_nothing_is_infinite() {
        let matrix = DMatrix::from_row_slice(3, 3, &[4.0, 2.0, 0.0, 2.0, 3.0, 0.0, 0.0, 0.0, 0.0]);
        let inverse = inverse(&matrix).unwrap();
        // Of the upper left four: 1/8 of [3 -2; -2 4].
        for ((i, j), x) in [((0, 0), 3.0), ((0, 1), -2.0), ((1, 0), -2.0), ((1, 1), 4.0)] {
            assert!((inverse[(i, j)] - x / 8.0).abs() < 1e-9);
        }
        assert_eq!(inverse[(2, 2)], f64::INFINITY);
        assert_eq!(inverse[(0, 2)], 0.0);
    }
}
