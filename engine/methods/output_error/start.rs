//! Where a fit starts.

use veloid_core::bicycle::PerAxle;
use veloid_report::Estimate;

/// Where a fit starts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start {
    /// k/m (1/s^2).
    pub kappa: f64,
    /// B/m (1/s).
    pub beta: f64,
    /// 1/m (1/kg).
    pub per_mass: f64,
}

pub fn starts_from(estimates: &PerAxle<Estimate>) -> PerAxle<Start> {
    estimates.map(|_, e| start_from(e))
}

pub fn start_from(e: &Estimate) -> Start {
    Start {
        kappa: e.k_n_m / e.mass_kg,
        beta: e.b_n_s_m / e.mass_kg,
        per_mass: 1.0 / e.mass_kg,
    }
}
