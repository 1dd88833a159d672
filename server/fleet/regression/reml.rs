//! The two variances: of rides beyond their own errors, and of bicycles. Maximised by average information (Gilmour, Thompson and
//! Cullis 1995, doi:10.2307/2533274), with steps halved until the likelihood rises and variances that stay positive.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn, Matrix2, Vector2};

const STEPS: usize = 100;
const HALVINGS: usize = 40;
/// Steps this small, as shares of the values' variance, end the search.
const SMALL: f64 = 1e-10;

/// Values of variance one, a design that holds the intercept, and the known variances of the values.
pub struct Problem<'a> {
    pub bikes: &'a [usize],
    pub bicycles: usize,
    pub design: DMatrix<f64>,
    pub values: DVector<f64>,
    pub known: DVector<f64>,
    /// Whether bicycles have levels of their own.
    pub levels: bool,
}

/// Everything at one pair of variances.
pub struct State {
    /// Of rides, of bicycles.
    pub variances: Vector2<f64>,
    pub coefficients: DVector<f64>,
    /// Inverse of the coefficients' covariance.
    pub information: Cholesky<f64, Dyn>,
    /// V^-1 (y - X b).
    pub weighted: DVector<f64>,
    /// Inverse variances of the rides.
    pub precisions: DVector<f64>,
    likelihood: f64,
    /// V^-1 X.
    weighted_design: DMatrix<f64>,
    /// Sums of the precisions of each bicycle's rides.
    of_bikes: DVector<f64>,
}

impl Problem<'_> {
    /// The state of the largest likelihood; nothing where the design has no full rank.
    pub fn solve(&self) -> Option<State> {
        let share = if self.levels { 0.3 } else { 0.0 };
        let mut state = self.at(Vector2::new(0.5, share))?;
        for _ in 0..STEPS {
            let step = self.step(&state)?;
            let Some(next) = self.upward(&state, step) else {
                break;
            };
            let moved = (next.variances - state.variances).amax();
            state = next;
            if moved < SMALL {
                break;
            }
        }
        Some(state)
    }

    /// The first of ever shorter steps that leads upward.
    fn upward(&self, from: &State, mut step: Vector2<f64>) -> Option<State> {
        for _ in 0..HALVINGS {
            let variances = (from.variances + step).map(|variance| variance.max(0.0));
            if let Some(next) = self.at(variances)
                && next.likelihood > from.likelihood
            {
                return Some(next);
            }
            step *= 0.5;
        }
        None
    }

    /// Restricted likelihood and generalised least squares at these variances.
    fn at(&self, variances: Vector2<f64>) -> Option<State> {
        let total = self.known.add_scalar(variances[0]);
        let precisions = total.map(f64::recip);
        let of_bikes = self.sums(&precisions);
        let mut weighted_design = DMatrix::zeros(self.design.nrows(), self.design.ncols());
        let weigh =
            |column: &DVector<f64>| weighed(self, &precisions, &of_bikes, variances[1], column);
        for (i, column) in self.design.column_iter().enumerate() {
            weighted_design.set_column(i, &weigh(&column.into_owned()));
        }
        let information = Cholesky::new(self.design.tr_mul(&weighted_design))?;
        let coefficients = information.solve(&weighted_design.tr_mul(&self.values));
        let left = &self.values - &self.design * &coefficients;
        let weighted = weigh(&left);
        let logs = total.map(f64::ln).sum()
            + of_bikes.map(|sum| (variances[1] * sum).ln_1p()).sum()
            + 2.0 * information.l_dirty().diagonal().map(f64::ln).sum();
        let likelihood = -0.5 * (logs + left.dot(&weighted));
        likelihood.is_finite().then_some(State {
            variances,
            coefficients,
            information,
            weighted,
            likelihood,
            weighted_design,
            precisions,
            of_bikes,
        })
    }

    /// Newton's step by the average information; variances at zero stay there unless the likelihood rises away from it.
    fn step(&self, state: &State) -> Option<Vector2<f64>> {
        let score = self.score(state);
        let free = |i: usize| state.variances[i] > 0.0 || score[i] > 0.0;
        let levels = self.levels && free(1);
        let along = [
            state.weighted.clone(),
            self.spread(&self.sums(&state.weighted)),
        ];
        let projected = along.each_ref().map(|a| self.projected(state, a));
        let average = Matrix2::from_fn(|i, j| 0.5 * along[i].dot(&projected[j]));
        let alone = |i: usize| {
            let mut step = Vector2::zeros();
            step[i] = score[i] / average[(i, i)];
            step
        };
        let step = match (free(0), levels) {
            (true, true) => match average.try_inverse() {
                Some(inverse) => inverse * score,
                None => alone(0),
            },
            (true, false) => alone(0),
            (false, true) => alone(1),
            (false, false) => Vector2::zeros(),
        };
        step.iter().all(|x| x.is_finite()).then_some(step)
    }

    /// Derivative of the likelihood by the variances.
    fn score(&self, state: &State) -> Vector2<f64> {
        let variance = state.variances[1];
        let shrunk = |sum: f64| variance / (1.0 + variance * sum);
        let squares = self.sums(&state.precisions.map(|p| p * p));
        let traces = Vector2::new(
            state.precisions.sum()
                - state
                    .of_bikes
                    .zip_map(&squares, |sum, square| shrunk(sum) * square)
                    .sum(),
            state.of_bikes.map(|sum| sum / (1.0 + variance * sum)).sum(),
        );
        let design = &state.weighted_design;
        let mut in_bikes = DMatrix::zeros(self.bicycles, design.ncols());
        for (i, column) in design.column_iter().enumerate() {
            in_bikes.set_column(i, &self.sums(&column.into_owned()));
        }
        let lost = |m: &DMatrix<f64>| state.information.solve(&m.tr_mul(m)).trace();
        let lost = Vector2::new(lost(design), lost(&in_bikes));
        let fits = Vector2::new(
            state.weighted.norm_squared(),
            self.sums(&state.weighted).norm_squared(),
        );
        0.5 * (fits - traces + lost)
    }

    /// P a, where P = V^-1 - V^-1 X (X' V^-1 X)^-1 X' V^-1.
    fn projected(&self, state: &State, a: &DVector<f64>) -> DVector<f64> {
        let fitted = state.information.solve(&state.weighted_design.tr_mul(a));
        let weighed = weighed(
            self,
            &state.precisions,
            &state.of_bikes,
            state.variances[1],
            a,
        );
        weighed - &state.weighted_design * fitted
    }

    /// Sums over each bicycle's rides.
    pub fn sums(&self, a: &DVector<f64>) -> DVector<f64> {
        let mut sums = DVector::zeros(self.bicycles);
        for (bike, a) in self.bikes.iter().zip(a.iter()) {
            sums[*bike] += a;
        }
        sums
    }

    /// Each bicycle's number at each of its rides.
    pub fn spread(&self, of_bikes: &DVector<f64>) -> DVector<f64> {
        DVector::from_iterator(
            self.bikes.len(),
            self.bikes.iter().map(|bike| of_bikes[*bike]),
        )
    }
}

/// V^-1 a, where V is diagonal but for a level that each bicycle's rides share (Woodbury).
fn weighed(
    problem: &Problem,
    precisions: &DVector<f64>,
    of_bikes: &DVector<f64>,
    variance: f64,
    a: &DVector<f64>,
) -> DVector<f64> {
    let direct = a.component_mul(precisions);
    if variance == 0.0 {
        return direct;
    }
    let levels = problem.sums(&direct).zip_map(of_bikes, |sum, total| {
        variance * sum / (1.0 + variance * total)
    });
    direct - problem.spread(&levels).component_mul(precisions)
}
