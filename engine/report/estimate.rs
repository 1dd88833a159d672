//! Stiffness and damping of an axle, as every method shows them.

use serde::{Deserialize, Serialize};

use veloid_core::numerics::finite::finite;

/// Stiffness and damping of one axle with their uncertainty.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Estimate {
    /// Stiffness k (N/m).
    pub k_n_m: f64,
    /// Damping B (N s/m).
    pub b_n_s_m: f64,
    /// Standard error of k (N/m); null where this ride does not determine k, and for the swarm, which has none.
    pub k_std_n_m: Option<f64>,
    /// Standard error of B (N s/m); null in the same cases as that of k.
    pub b_std_n_s_m: Option<f64>,
    /// Why there is no standard error of k.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub k_not_identifiable: Option<String>,
    /// Why there is no standard error of B.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub b_not_identifiable: Option<String>,
    /// Standard deviation of k (N/m) over the trials of the swarm: how well they agree, not how well the ride
    /// determines the value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub k_scatter_n_m: Option<f64>,
    /// Standard deviation of B (N s/m) over the trials of the swarm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub b_scatter_n_s_m: Option<f64>,
    /// Mass carried (kg): the bike file's, or estimated where that is null; 0 where a rig prescribes the motion and no mass
    /// moves.
    pub mass_kg: f64,
    /// Standard error of an estimated mass (kg).
    pub mass_std_kg: Option<f64>,
    /// Covariance of k (N/m), B (N s/m) and m (kg) as the fit gives it, before anything widens the standard errors; zeros beside a mass
    /// that is not estimated. Null for methods that do not give one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub covariance: Option<[[f64; 3]; 3]>,
    /// Difference of k from the output-error estimate (%): the method's bias on this ride.
    pub k_bias_percent: Option<f64>,
    /// Difference of B from the output-error estimate (%).
    pub b_bias_percent: Option<f64>,
}

/// Share of a limit within which a value counts as at it: rounding.
const ROUNDING: f64 = 1e-9;

/// Why a value has no interval of which the user has set the limits; nothing between them.
pub fn at_limit(value: f64, limit: Option<[f64; 2]>, unit: &str) -> Option<String> {
    let [low, high] = limit?;
    let is_at = |end: f64| (value - end).abs() <= ROUNDING * low.abs().max(high.abs());
    if low == high {
        return Some(format!("fixed at {low} {unit} by the user"));
    }
    let end = [low, high].into_iter().find(|end| is_at(*end))?;
    Some(format!(
        "at its bound of {end} {unit}, which the user has set"
    ))
}

impl Estimate {
    /// Without the intervals of k and B where the user has fixed them, or bounded them where they lie.
    pub fn limited(self, [k, b]: [Option<[f64; 2]>; 2]) -> Self {
        let k = at_limit(self.k_n_m, k, "N/m");
        let b = at_limit(self.b_n_s_m, b, "N s/m");
        Self {
            k_std_n_m: self.k_std_n_m.filter(|_| k.is_none()),
            b_std_n_s_m: self.b_std_n_s_m.filter(|_| b.is_none()),
            k_not_identifiable: k.or(self.k_not_identifiable),
            b_not_identifiable: b.or(self.b_not_identifiable),
            ..self
        }
    }

    /// Covariance of k, B and m from that of what a fit moves: `of` gives the covariance of two of its numbers, and each row of `by`
    /// how k, B and m change with them. None where it is not finite.
    pub fn propagated<const N: usize>(
        by: [[f64; N]; 3],
        of: impl Fn(usize, usize) -> f64,
    ) -> Option<[[f64; 3]; 3]> {
        let one = |p: usize, q: usize| -> f64 {
            let pairs = (0..N).flat_map(|a| (0..N).map(move |b| (a, b)));
            pairs.map(|(a, b)| by[p][a] * by[q][b] * of(a, b)).sum()
        };
        let found: [[f64; 3]; 3] = std::array::from_fn(|p| std::array::from_fn(|q| one(p, q)));
        (found.iter().flatten().all(|x| x.is_finite())).then_some(found)
    }

    /// With the difference to the reference estimate in percent.
    pub fn judged_by(self, reference: Option<&Estimate>) -> Self {
        let percent = |value: f64, by: f64| finite(100.0 * (value / by - 1.0));
        Self {
            k_bias_percent: reference.and_then(|r| percent(self.k_n_m, r.k_n_m)),
            b_bias_percent: reference.and_then(|r| percent(self.b_n_s_m, r.b_n_s_m)),
            ..self
        }
    }
}
