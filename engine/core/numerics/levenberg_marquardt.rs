//! Levenberg and Marquardt's method: steps that solve damped normal equations, with less damping after each that leads down and
//! more after each that does not (Marquardt 1963, J. SIAM 11:431-441, <https://doi.org/10.1137/0111030>).
//!
//! The fits of eight sets of numbers at once (`diagnosis/fit/damped.rs`) try eight dampings in the place of one.

use nalgebra::{Cholesky, DMatrix, DVector};

/// What is minimised.
pub trait Descent {
    /// A point with all that is known there.
    type Point;

    /// What is to become small there.
    fn cost(&self, at: &Self::Point) -> f64;

    /// Gauss-Newton matrix and downward gradient of half the cost.
    fn equations(&self, at: &Self::Point) -> (DMatrix<f64>, DVector<f64>);

    /// The point that a step leads to; nothing where there is none that may be.
    fn moved(&self, at: &Self::Point, step: DVector<f64>) -> Option<Self::Point>;

    /// Whether steps that gain so little, and are predicted to, are worth nothing at a point of this cost.
    fn is_settled(&self, gained: f64, predicted: f64, cost: f64) -> bool;

    /// Whether a step that led up and was predicted to gain so much ends the descent.
    fn gives_up(&self, _predicted: f64) -> bool {
        false
    }
}

/// Damping at the start, at least, and from where on a failure ends a descent.
#[derive(Clone, Copy, Debug)]
pub struct Damping {
    /// Relative to the diagonal of the matrix, as all of them.
    pub first: f64,
    /// Least.
    pub least: f64,
    /// A tenth of the least after a step that led up.
    pub after_failure: f64,
    /// Most.
    pub most: f64,
}

/// The lowest point from a start on, in at most `steps`; nothing where the equations have no solution.
pub fn minimise<D: Descent>(
    descent: &D,
    start: D::Point,
    damping: Damping,
    steps: usize,
) -> Option<D::Point> {
    let mut at = start;
    let (mut matrix, mut gradient) = descent.equations(&at);
    let mut by = damping.first;
    for _ in 0..steps {
        let mut damped = matrix.clone();
        for i in 0..damped.nrows() {
            damped[(i, i)] *= 1.0 + by;
        }
        let step = Cholesky::new(damped)?.solve(&gradient);
        let predicted = 0.5 * gradient.dot(&step);
        let cost = descent.cost(&at);
        let next = descent.moved(&at, step);
        match next.filter(|next| descent.cost(next) <= cost) {
            Some(next) => {
                at = next;
                (matrix, gradient) = descent.equations(&at);
                by = (0.1 * by).max(damping.least);
                let gained = cost - descent.cost(&at);
                if descent.is_settled(gained, predicted, descent.cost(&at)) {
                    break;
                }
            }
            None if by > damping.most || descent.gives_up(predicted) => break,
            None => by = 10.0 * by.max(damping.after_failure),
        }
    }
    Some(at)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// Rosenbrock's valley as squares: 10 (y - x^2) and 1 - x.
    struct Valley;

    impl Descent for Valley {
        type Point = [f64; 2];

        fn cost(&self, [x, y]: &[f64; 2]) -> f64 {
            (10.0 * (y - x * x)).powi(2) + (1.0 - x).powi(2)
        }

        fn equations(&self, [x, y]: &[f64; 2]) -> (DMatrix<f64>, DVector<f64>) {
            let jacobian = DMatrix::from_row_slice(2, 2, &[-20.0 * x, 10.0, -1.0, 0.0]);
            let residual = DVector::from_row_slice(&[10.0 * (y - x * x), 1.0 - x]);
            (jacobian.tr_mul(&jacobian), -jacobian.tr_mul(&residual))
        }

        fn moved(&self, [x, y]: &[f64; 2], step: DVector<f64>) -> Option<[f64; 2]> {
            Some([x + step[0], y + step[1]])
        }

        fn is_settled(&self, gained: f64, _: f64, cost: f64) -> bool {
            gained <= 1e-14 * cost
        }
    }

    const DAMPING: Damping = Damping {
        first: 1e-3,
        least: 1e-12,
        after_failure: 1e-3,
        most: 1e12,
    };

    #[test]
    fn a_curved_valley_is_followed_to_its_end() {
        let [x, y] = minimise(&Valley, [-1.2, 1.0], DAMPING, 100).unwrap();
        assert!((x - 1.0).abs() < 1e-8 && (y - 1.0).abs() < 1e-8, "{x} {y}");
    }

    #[test]
    fn no_step_leads_up() {
        let mut last = Valley.cost(&[-1.2, 1.0]);
        for steps in 1..60 {
            let cost = Valley.cost(&minimise(&Valley, [-1.2, 1.0], DAMPING, steps).unwrap());
            assert!(cost <= last, "{steps}: {cost} after {last}");
            last = cost;
        }
        assert!(last < 1e-6);
    }
}
