//! Where effects act, and their parameters.

use serde::{Deserialize, Serialize};

use veloid_core::bicycle::Axle;
use veloid_core::document::format_number::Quantity;

/// The axle or axles that an effect acts on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum Place {
    /// The front axle only.
    Front,
    /// The rear axle only.
    Rear,
    /// Both axles, with one set of parameters.
    Both,
}

impl From<Axle> for Place {
    fn from(axle: Axle) -> Self {
        match axle {
            Axle::Front => Place::Front,
            Axle::Rear => Place::Rear,
        }
    }
}

impl Place {
    /// Whether an effect in this place acts on `axle`.
    pub fn acts_on(self, axle: Axle) -> bool {
        match self {
            Place::Front => axle == Axle::Front,
            Place::Rear => axle == Axle::Rear,
            Place::Both => true,
        }
    }

    /// As reports write it: `front`, `rear` or `both`.
    pub fn name(self) -> &'static str {
        match self {
            Place::Front => "front",
            Place::Rear => "rear",
            Place::Both => "both",
        }
    }
}

/// One parameter of an effect.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct ParameterReport {
    /// Value in `unit`.
    pub value: f64,
    /// Standard error in `unit`; null where this ride does not determine the value.
    pub std_error: Option<f64>,
    /// Why there is no standard error.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub not_identifiable: Option<String>,
    /// SI unit, such as `N s/m`; for a parameter that is a choice, the choice in words.
    pub unit: String,
}

impl ParameterReport {
    /// As people read it, under its name in the effect.
    pub fn quantity(&self, name: &str) -> Quantity {
        match name {
            // A choice, reported by its unit; the number only distinguishes programs.
            "side" => Quantity::choice(&self.unit),
            _ => Quantity::new(self.value, self.std_error, &self.unit),
        }
    }
}
