use nalgebra::{Cholesky, DMatrix, DVector};

use crate::Ride;

/// Smallest part of a column that the others may leave.
const INDEPENDENT: f64 = 1e-8;
/// Scatters between rides that are tried, from this part of their median error on, each twice the one before.
const SMALLEST: f64 = 0.25;
const SCATTERS: u32 = 12;

/// Generalised least squares of rides that scatter beyond their own errors.
pub struct Fit {
    /// Inverse variances of the rides.
    pub weights: Vec<f64>,
    pub coefficients: DVector<f64>,
    pub covariance: DMatrix<f64>,
    /// L^-1 x of each ride, where X'WX = LL'.
    pub turned: DMatrix<f64>,
    /// What is left of each value.
    pub left: DVector<f64>,
    /// Restricted log likelihood up to a constant of the columns.
    pub likelihood: f64,
}

impl Fit {
    /// None where the columns are not independent. `between`: standard deviation between rides.
    pub fn of(
        rides: &[Ride],
        values: &[f64],
        columns: &DMatrix<f64>,
        between: f64,
    ) -> Option<Self> {
        let weight = |ride: &Ride| (ride.std_error.powi(2) + between * between).recip();
        let weights: Vec<f64> = rides.iter().map(weight).collect();
        let values = DVector::from_column_slice(values);
        let information = information(columns, &weights)?;
        let weighed = DVector::from_iterator(
            values.len(),
            values.iter().zip(&weights).map(|(y, w)| w * y),
        );
        let coefficients = information.solve(&columns.tr_mul(&weighed));
        let left = values - columns * &coefficients;
        let lower = information.l();
        let turned = lower.solve_lower_triangular(&columns.transpose())?;
        let logs =
            weights.iter().map(|w| w.ln()).sum::<f64>() - 2.0 * lower.diagonal().map(f64::ln).sum();
        let squares: f64 = left.iter().zip(&weights).map(|(e, w)| w * e * e).sum();
        let likelihood = 0.5 * (logs - squares);
        likelihood.is_finite().then(|| Self {
            covariance: information.inverse(),
            weights,
            coefficients,
            turned,
            left,
            likelihood,
        })
    }

    /// At the scatter between rides that is most likely, with that scatter.
    pub fn most_likely(
        rides: &[Ride],
        values: &[f64],
        columns: &DMatrix<f64>,
    ) -> Option<(f64, Self)> {
        let fits = scatters(rides).filter_map(|between| {
            let fit = Self::of(rides, values, columns, between)?;
            Some((between, fit))
        });
        fits.max_by(|a, b| a.1.likelihood.total_cmp(&b.1.likelihood))
    }
}

/// X'WX; none where the columns are not independent.
pub fn information(
    columns: &DMatrix<f64>,
    weights: &[f64],
) -> Option<Cholesky<f64, nalgebra::Dyn>> {
    let mut weighed = columns.clone();
    for (mut row, weight) in weighed.row_iter_mut().zip(weights) {
        row *= *weight;
    }
    let products = columns.tr_mul(&weighed);
    let sizes = products.diagonal();
    let found = Cholesky::new(products)?;
    let own = found.l_dirty().diagonal();
    let is_own = |(own, size): (&f64, &f64)| own * own > INDEPENDENT * size;
    own.iter().zip(sizes.iter()).all(is_own).then_some(found)
}

/// Standard deviations between rides that are tried.
pub fn scatters(rides: &[Ride]) -> impl Iterator<Item = f64> {
    let smallest = SMALLEST * usual_error(rides);
    (0..SCATTERS).map(move |k| smallest * f64::from(1 << k))
}

/// Median of the rides' own standard errors.
pub fn usual_error(rides: &[Ride]) -> f64 {
    median(rides.iter().map(|ride| ride.std_error).collect())
}

/// 0 of nothing.
pub fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    match (values.len() % 2, values.get(middle)) {
        (_, None) => 0.0,
        (0, Some(upper)) => 0.5 * (values[middle - 1] + upper),
        (_, Some(middle)) => *middle,
    }
}
