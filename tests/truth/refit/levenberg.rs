//! Levenberg-Marquardt with one-sided finite differences.

use nalgebra::{DMatrix, DVector};

/// Step of the finite differences; unknowns are scaled to order one.
const STEP: f64 = 1e-5;
const ITERATIONS: usize = 30;

/// Minimises |r(x)|^2 from `start`; `residual` returns `None` where the model breaks down.
/// Returns the best point and its cost, or `None` when the start itself breaks down.
pub fn minimise(
    start: &[f64],
    residual: impl Fn(&[f64]) -> Option<Vec<f64>>,
) -> Option<(Vec<f64>, f64)> {
    let evaluate = |x: &[f64]| {
        residual(x)
            .filter(|r| r.iter().all(|v| v.is_finite()))
            .map(DVector::from_vec)
    };
    let mut x = start.to_vec();
    let mut r = evaluate(&x)?;
    let (mut cost, mut damping) = (r.norm_squared(), 1e-3);
    for _ in 0..ITERATIONS {
        let Some(jacobian) = jacobian(&x, &r, evaluate) else {
            break;
        };
        let normal = jacobian.tr_mul(&jacobian);
        let gradient = jacobian.tr_mul(&r);
        let before = cost;
        while damping < 1e8 {
            let mut damped = normal.clone();
            for j in 0..x.len() {
                damped[(j, j)] += damping * normal[(j, j)].max(1e-30);
            }
            let tried = damped
                .cholesky()
                .map(|c| c.solve(&gradient))
                .and_then(|step| {
                    let next: Vec<f64> = x.iter().zip(step.iter()).map(|(x, s)| x - s).collect();
                    evaluate(&next).map(|r| (next, r))
                });
            if let Some((next, moved)) = tried.filter(|(_, moved)| moved.norm_squared() < cost) {
                (x, cost, r) = (next, moved.norm_squared(), moved);
                damping = (damping / 8.0).max(1e-9);
                break;
            }
            damping *= 6.0;
        }
        if before - cost < 1e-8 * before {
            break;
        }
    }
    Some((x, cost))
}

/// One-sided differences, forward or, where the model breaks down ahead, backward.
fn jacobian(
    x: &[f64],
    r: &DVector<f64>,
    evaluate: impl Fn(&[f64]) -> Option<DVector<f64>>,
) -> Option<DMatrix<f64>> {
    let mut jacobian = DMatrix::zeros(r.len(), x.len());
    for j in 0..x.len() {
        let slope = |step: f64| {
            let mut beside = x.to_vec();
            beside[j] += step;
            evaluate(&beside).map(|moved| (moved - r) / step)
        };
        jacobian.set_column(j, &slope(STEP).or_else(|| slope(-STEP))?);
    }
    Some(jacobian)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn solves_rosenbrock() {
        let (x, cost) = minimise(&[-1.2, 1.0], |x| {
            Some(vec![10.0 * (x[1] - x[0] * x[0]), 1.0 - x[0]])
        })
        .unwrap();
        assert!((x[0] - 1.0).abs() < 1e-4 && cost < 1e-8, "{x:?} {cost}");
    }
}
