//! The identified model as a document of its own: what simulates it and what compares it with other rides.

use serde::{Deserialize, Serialize};

use crate::diagnosis::{Base, Diagnosis, EffectName, EffectReport};
use crate::simulation::Simulation;
use crate::{AxleResult, Estimate, Report};
use veloid_core::bicycle::{Axle, Bike, PerAxle};

const EQUATION: &str = "m z'' = k (u - z) + B (u' - z') + F; where a rig prescribes the deflection d (mass 0): F = k d + B d' + constant";

/// The identified model, to simulate with.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct IdentifiedModel {
    /// Version of veloid that identified it.
    pub veloid: String,
    /// Name of the bicycle.
    pub bike: String,
    /// SHA-256 of the ride that it was identified from.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub ride_sha256: String,
    /// Equation of each axle; u road, z displacement, F applied force, all up; on a rig F is what was measured.
    pub equation: String,
    /// The one answer of each axle, as in the report.
    #[serde(default)]
    pub result: PerAxle<AxleResult>,
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
    /// Elements of the plain model.
    #[serde(default)]
    pub base: Base,
    /// The bike file of the ride.
    #[serde(default)]
    pub bicycle: Bike,
    /// The law of the user's own (TOML) that was searched for, if any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub law: Option<String>,
}

impl IdentifiedModel {
    /// The model of a report.
    pub fn of(report: Report) -> Self {
        let plain = match &report.latent_road {
            Some(latent) if report.has_no_road() => latent.axles(),
            _ => report.output_error,
        };
        let not_in_script = report.diagnosis.as_ref().map_or_else(Vec::new, left_out);
        let base = report.diagnosis.as_ref().map(|d| d.base);
        let (extended, effects, simulation) = match report.diagnosis {
            Some(d) if !d.effects.is_empty() => (Some(d.extended), d.effects, d.model),
            Some(d) => (None, Vec::new(), d.model),
            None => (None, Vec::new(), None),
        };
        Self {
            veloid: report.veloid,
            bike: report.bike.bike.clone(),
            ride_sha256: report.ride.sha256,
            equation: EQUATION.to_owned(),
            result: report.result,
            plain,
            extended,
            effects,
            simulation,
            not_in_script,
            base: base.unwrap_or_default(),
            bicycle: report.bike,
            law: report.settings.law,
        }
    }

    /// Drops every effect but those that are wanted.
    pub fn keep_effects(&mut self, wanted: &[EffectName]) {
        self.effects
            .retain(|effect| wanted.contains(&effect.name()));
        let kept: Vec<EffectName> = self.effects.iter().map(EffectReport::name).collect();
        let Some(simulation) = &mut self.simulation else {
            return;
        };
        for axle in Axle::BOTH {
            let Some(simulated) = simulation.axles.get_mut(axle) else {
                continue;
            };
            let is_kept = |id: &str| kept.iter().any(|e| e.id == id && e.axle.acts_on(axle));
            simulated.effects.retain(|effect| is_kept(&effect.id));
        }
    }

    /// Takes over an effect of another model of the same bicycle, with its numbers there.
    pub fn add_effect(&mut self, effect: &EffectName, of: &Self) {
        let reported = of.effects.iter().find(|e| e.name() == *effect);
        let (Some(reported), Some(simulation), Some(other)) =
            (reported, &mut self.simulation, &of.simulation)
        else {
            return;
        };
        self.effects.push(reported.clone());
        for axle in Axle::BOTH {
            let Some(simulated) = simulation.axles.get_mut(axle) else {
                continue;
            };
            let acting = other.axles.get(axle).into_iter().flat_map(|s| &s.effects);
            let acting = acting.filter(|acts| acts.id == effect.id && effect.axle.acts_on(axle));
            simulated.effects.extend(acting.cloned());
        }
        if simulation.pitch.is_none() {
            simulation.pitch.clone_from(&other.pitch);
        }
    }
}

/// Effects that the diagnosis found and a script does not simulate.
pub fn left_out(diagnosis: &Diagnosis) -> Vec<EffectName> {
    let is_in = |effect: &EffectName| {
        let Some(model) = &diagnosis.model else {
            return false;
        };
        let acted = model
            .axles
            .iter()
            .filter(|(axle, _)| effect.axle.acts_on(*axle));
        let mut acting = acted.flat_map(|(_, axle)| &axle.effects);
        acting.any(|acts| {
            let is_coupling = acts.law.expressions().next().is_none() && model.pitch.is_some();
            acts.id == effect.id && (acts.law.expressions().next().is_some() || is_coupling)
        })
    };
    let effects = diagnosis.effects.iter().map(EffectReport::name);
    effects.filter(|effect| !is_in(effect)).collect()
}
