//! The report's `diagnosis.tried` section: what was fitted to the end beside the verdict, and why it is not the answer.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::parameter::{ParameterReport, Place};
use veloid_core::bicycle::{Axle, PerAxle};
use veloid_core::document::format_number::{Quantity, significant};

const UNKNOWN: &str = "–";

/// A set of effects that was fitted to the end.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Tried {
    /// Its effects with their values.
    pub effects: Vec<TriedEffect>,
    /// Number of parameters that its effects add to the plain model.
    pub parameters: usize,
    /// Gain in log likelihood over the plain model; null where none was computed.
    pub gain: Option<f64>,
    /// RMS error on parts that were not fitted (m, or N where a force is predicted), on axles where it is known; the plain model's is
    /// `held_out.<axle>.plain_rms_m`.
    pub held_out_rms_m: PerAxle<f64>,
    /// Why it is not the answer; absent where it is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub why_not: Option<String>,
}

/// An effect of such a set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct TriedEffect {
    /// Id in the library, or that of the custom law.
    pub id: String,
    /// The axle or axles that it acts on.
    pub axle: Place,
    /// Fitted parameters by name; empty where the effect could not be fitted.
    pub parameters: BTreeMap<String, ParameterReport>,
}

impl Tried {
    /// Whether an effect with this id is among its effects.
    pub fn has(&self, id: &str) -> bool {
        self.effects.iter().any(|effect| effect.id == id)
    }

    /// Values of its effects, and parameters, gain, errors on the held-out part in `unit` and why it is not the answer, in words.
    pub fn columns(&self, unit: &str) -> [String; 5] {
        let parameters = self.effects.iter().flat_map(|e| &e.parameters);
        let value = |(name, p): (&String, &ParameterReport)| {
            format!("{} {}", name.replace('_', " "), p.quantity(name))
        };
        let values: Vec<String> = parameters.map(value).collect();
        let rms = |(axle, rms): (Axle, &f64)| format!("{axle} {}", Quantity::rough(*rms, 3, unit));
        let held_out: Vec<String> = self.held_out_rms_m.iter().map(rms).collect();
        [
            values.join(", "),
            self.parameters.to_string(),
            self.gain
                .map_or(UNKNOWN.to_owned(), |gain| significant(gain, 3)),
            match held_out.is_empty() {
                true => UNKNOWN.to_owned(),
                false => held_out.join(", "),
            },
            self.why_not.clone().unwrap_or("the answer".to_owned()),
        ]
    }

    /// Its effects in words: `coulomb friction (front) with cubic stiffness (rear)`.
    pub fn name(&self) -> String {
        let named = |e: &TriedEffect| format!("{} ({})", e.id.replace('_', " "), e.axle.name());
        let effects: Vec<String> = self.effects.iter().map(named).collect();
        effects.join(" with ")
    }
}
