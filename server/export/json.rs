//! The identified model as JSON.

use serde::Serialize;
use utoipa::ToSchema;
use veloid_engine::bicycle::PerAxle;
use veloid_engine::report::diagnosis::{EffectName, EffectReport};
use veloid_engine::report::simulation::Simulation;
use veloid_engine::report::{Estimate, Report};

use super::head::left_out;

const EQUATION: &str = "m z'' = k (u - z) + B (u' - z') + F; where a rig prescribes the deflection d (mass 0): F = k d + B d' + constant";

/// The identified model, to simulate with.
#[derive(Serialize, ToSchema)]
pub struct IdentifiedModel {
    /// Version of veloid that identified it.
    pub veloid: String,
    pub bike: String,
    /// Equation of each axle; u road, z displacement, F applied force, all up; on a rig F is what was measured.
    #[schema(value_type = String)]
    pub equation: &'static str,
    /// Output error: the plain model at its best.
    pub plain: PerAxle<Estimate>,
    /// Stiffness and damping with the effects in the model.
    pub extended: Option<PerAxle<Estimate>>,
    /// What is added to the plain model; `simulation` has the laws.
    pub effects: Vec<EffectReport>,
    /// All that simulates the model with the effects: numbers, laws as expressions, start, and the held-out samples on which it leaves
    /// the report's `diagnosis.held_out.<axle>.extended_rms_m`. Null without a diagnosis.
    pub simulation: Option<Simulation>,
    /// Effects that the scripts do not simulate.
    pub not_in_script: Vec<EffectName>,
}

impl IdentifiedModel {
    pub fn of(report: Report) -> Self {
        let plain = match &report.latent_road {
            Some(latent) if report.has_no_road() => latent.axles(),
            _ => report.output_error,
        };
        let not_in_script = report.diagnosis.as_ref().map_or_else(Vec::new, left_out);
        let (extended, effects, simulation) = match report.diagnosis {
            Some(d) if !d.effects.is_empty() => (Some(d.extended), d.effects, d.model),
            Some(d) => (None, Vec::new(), d.model),
            None => (None, Vec::new(), None),
        };
        Self {
            veloid: report.veloid,
            bike: report.bike.bike,
            equation: EQUATION,
            plain,
            extended,
            effects,
            simulation,
            not_in_script,
        }
    }
}
