//! A ride that is wrong, as with somebody else's mass, must not pass for a change.

use nalgebra::{DMatrix, DVector};

use crate::Ride;
use crate::least_squares::{information, median};

/// Huber's constant: 95 % efficient under a normal distribution (Huber 1964, doi:10.1214/aoms/1177703732).
const HUBER: f64 = 1.345;
const ROUNDS: usize = 8;
/// Standard deviations up to which a ride is believed.
const BELIEVED: f64 = 3.5;
/// Rides beyond the columns from which on their scatter is known.
const FEW: usize = 5;
/// Makes the median absolute deviation of a normal scatter its standard deviation.
pub const NORMAL: f64 = 1.4826;

/// The values of rides, each moved to what is believed of it at most.
pub fn believed(rides: &[Ride], columns: &DMatrix<f64>) -> Vec<f64> {
    let values = rides.iter().map(|ride| ride.value);
    let is_known = rides.len() > FEW + columns.ncols();
    let Some((fitted, scale)) = fit(rides, columns).filter(|_| is_known) else {
        return values.collect();
    };
    // The scatter of few rides is known badly.
    let wide = BELIEVED * (1.0 + 2.0 / rides.len() as f64);
    let nearest = |(ride, fitted): (&Ride, &f64)| {
        let most = wide * scale.max(ride.std_error);
        ride.value.clamp(fitted - most, fitted + most)
    };
    rides.iter().zip(fitted.iter()).map(nearest).collect()
}

/// The ride that is farthest off.
pub fn farthest(rides: &[Ride], columns: &DMatrix<f64>) -> usize {
    let Some((fitted, scale)) = fit(rides, columns) else {
        return 0;
    };
    let off =
        |i: &usize| (rides[*i].value - fitted[*i]).abs() / rides[*i].std_error.hypot(0.5 * scale);
    let by_distance = |a: &usize, b: &usize| off(a).total_cmp(&off(b));
    (0..rides.len()).max_by(by_distance).unwrap_or(0)
}

/// What is fitted by Huber's weights, from the median on, and the scale of what is left (median absolute deviation).
fn fit(rides: &[Ride], columns: &DMatrix<f64>) -> Option<(DVector<f64>, f64)> {
    let values = DVector::from_iterator(rides.len(), rides.iter().map(|ride| ride.value));
    let scale = |fitted: &DVector<f64>| {
        let left = (&values - fitted).abs();
        NORMAL * median(left.iter().copied().collect())
    };
    let middle = median(values.iter().copied().collect());
    let mut fitted = DVector::from_element(rides.len(), middle);
    // The median of a level alone is as robust as can be.
    let rounds = if columns.ncols() == 1 { 0 } else { ROUNDS };
    for _ in 0..rounds {
        let scale = scale(&fitted);
        let weight = |(i, ride): (usize, &Ride)| {
            let usual = ride.std_error.hypot(scale);
            let off = (values[i] - fitted[i]).abs() / usual;
            (HUBER / off).min(1.0) / (usual * usual)
        };
        let weights: Vec<f64> = rides.iter().enumerate().map(weight).collect();
        let weighed = values.component_mul(&DVector::from_column_slice(&weights));
        let coefficients = information(columns, &weights)?.solve(&columns.tr_mul(&weighed));
        fitted = columns * coefficients;
    }
    let scale = scale(&fitted);
    Some((fitted, scale))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::structure::Structure;

    fn rides(values: &[f64]) -> Vec<Ride> {
        let ride = |(i, value): (usize, &f64)| Ride {
            day: i as f64,
            value: *value,
            std_error: 1.0,
        };
        values.iter().enumerate().map(ride).collect()
    }

    #[test]
    fn a_ride_is_believed_up_to_three_and_a_half_deviations() {
        let mut values = [10.0, 11.0, 9.0, 10.5, 9.5, 10.0, 11.0, 9.0, 10.0, 50.0];
        let columns = |rides: &[Ride]| Structure::default().columns(rides, &[]);
        let odd = rides(&values);
        let found = believed(&odd, &columns(&odd));
        let most = BELIEVED * 1.2 * NORMAL * 0.75;
        assert!((found[9] - (10.0 + most)).abs() < 1e-9, "{found:?}");
        assert_eq!(found[..9], values[..9]);
        assert_eq!(farthest(&odd, &columns(&odd)), 9);
        values[9] = 10.0 + 0.99 * most;
        let usual = rides(&values);
        assert_eq!(believed(&usual, &columns(&usual)), values);
        let few = rides(&values[4..]);
        assert_eq!(believed(&few, &columns(&few)).len(), FEW + 1);
    }
}
