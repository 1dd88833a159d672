//! Levenberg-Marquardt where eight sets of numbers cost what one costs: every step tries eight dampings at once.

use nalgebra::{DMatrix, DVector};

use crate::numerics::lanes::LANES;

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
