//! What a fit gains by one column more, without fitting it again (a score test).

use nalgebra::DVector;

use super::reml::{Problem, State};

/// Sums over rides of a column of numbers, weighed: its square, itself, what the fit leaves, and the design beside it.
pub struct Sums {
    square: f64,
    weight: f64,
    left: f64,
    design: DVector<f64>,
}

impl Sums {
    pub fn new(columns: usize) -> Self {
        let design = DVector::zeros(columns);
        Self {
            square: 0.0,
            weight: 0.0,
            left: 0.0,
            design,
        }
    }

    pub fn add(&mut self, problem: &Problem, state: &State, ride: usize, x: f64) {
        let weight = state.precisions[ride] * x;
        self.square += weight * x;
        self.weight += weight;
        self.left += state.weighted[ride] * x;
        self.design += problem.design.row(ride).transpose() * weight;
    }
}

/// What a bicycle's own level takes of a column of its rides.
pub struct Shape<'a> {
    state: &'a State,
    all: DVector<f64>,
    shrunk: f64,
}

impl<'a> Shape<'a> {
    pub fn of(problem: &Problem, state: &'a State, rides: &[usize]) -> Self {
        let mut all = Sums::new(problem.design.ncols());
        rides.iter().for_each(|i| all.add(problem, state, *i, 1.0));
        let shrunk = state.variances[1] / (1.0 + state.variances[1] * all.weight);
        Self {
            state,
            all: all.design,
            shrunk,
        }
    }

    /// Twice the gain in log likelihood of a column beside the fit.
    pub fn gain(&self, sums: &Sums) -> f64 {
        let across = &sums.design - &self.all * (self.shrunk * sums.weight);
        let own = sums.square - self.shrunk * sums.weight * sums.weight;
        let free = own - across.dot(&self.state.information.solve(&across));
        if free > 1e-9 * own {
            sums.left * sums.left / free
        } else {
            0.0
        }
    }
}
