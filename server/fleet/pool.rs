//! One estimate out of many: random-effects meta-analysis (DerSimonian and Laird, Controlled
//! Clinical Trials 7, 1986). What the rides differ by beyond their own errors is said, not hidden.

use serde::Serialize;
use statrs::distribution::{ChiSquared, ContinuousCDF};
use utoipa::ToSchema;

use super::weighted;

/// Several rides' estimates joined.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct Pooled {
    pub value: f64,
    pub std_error: f64,
    pub rides: usize,
    /// Standard deviation between rides beyond their own errors.
    pub between_rides: f64,
    /// Share of the scatter that the rides' own errors do not explain (I^2), from 0 to 1.
    pub heterogeneity: f64,
    /// Chance of so much scatter if the rides differed by their own errors only.
    pub p_heterogeneous: Option<f64>,
}

impl Pooled {
    /// Joins values with standard errors; none where there is no value.
    pub fn of(values: &[(f64, f64)]) -> Option<Self> {
        let n = values.len();
        if n == 0 {
            return None;
        }
        let fixed = values.iter().map(|(value, error)| (*value, error.powi(-2)));
        let (mean, total) = weighted(fixed.clone());
        let q: f64 = fixed
            .clone()
            .map(|(value, weight)| weight * (value - mean).powi(2))
            .sum();
        let freedom = (n - 1) as f64;
        let squares: f64 = fixed.map(|(_, weight)| weight * weight).sum();
        let scale = total - squares / total;
        let variance = if n > 1 && scale > 0.0 {
            ((q - freedom) / scale).max(0.0)
        } else {
            0.0
        };
        let random = values
            .iter()
            .map(|(value, error)| (*value, 1.0 / (error * error + variance)));
        let (value, total) = weighted(random);
        Some(Self {
            value,
            std_error: total.sqrt().recip(),
            rides: n,
            between_rides: variance.sqrt(),
            heterogeneity: if q > freedom { (q - freedom) / q } else { 0.0 },
            p_heterogeneous: ChiSquared::new(freedom).ok().map(|chi| chi.sf(q)),
        })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// Worked by hand: weights 1 and 1, Q = 8, tau^2 = (8 - 1) / (2 - 1) = 7.
    #[test]
    fn two_rides_that_disagree_widen_the_interval() {
        let pooled = Pooled::of(&[(10.0, 1.0), (14.0, 1.0)]).unwrap();
        assert!((pooled.value - 12.0).abs() < 1e-12);
        assert!((pooled.between_rides.powi(2) - 7.0).abs() < 1e-12);
        assert!((pooled.std_error - 2.0).abs() < 1e-12);
        assert!((pooled.heterogeneity - 7.0 / 8.0).abs() < 1e-12);
        assert!(pooled.p_heterogeneous.unwrap() < 0.005);
    }

    #[test]
    fn rides_that_agree_are_averaged_by_their_errors() {
        let pooled = Pooled::of(&[(10.0, 1.0), (10.5, 2.0)]).unwrap();
        assert!((pooled.value - 10.1).abs() < 1e-12, "weights 4 to 1");
        assert_eq!(pooled.between_rides, 0.0);
        let one = Pooled::of(&[(3.0, 0.5)]).unwrap();
        assert_eq!(
            (one.value, one.std_error, one.p_heterogeneous),
            (3.0, 0.5, None)
        );
        assert_eq!(Pooled::of(&[]), None);
    }
}
