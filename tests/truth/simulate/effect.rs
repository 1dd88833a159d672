//! The effects of `effects.md`: ids, axles and parameter names. Their laws are in [`super::vehicle`] and [`super::drive`].

use serde_json::{Map, Value, json};

/// Front and rear as indices.
pub const FRONT: usize = 0;
pub const REAR: usize = 1;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Kind {
    CubicStiffness,
    ProgressiveStiffness,
    QuadraticDamping,
    AsymmetricDamping,
    CoulombFriction,
    Hysteresis,
    ViscoelasticTyre,
    BumpStop,
    FreePlay,
    WheelLift,
    SprungMass,
    UnsprungMass,
    PitchCoupling,
    LoadTransfer,
    TyreEnveloping,
    WheelOutOfRound,
    PedallingForce,
    StiffnessDrift,
    SpeedDependentStiffness,
    SpeedDependentDamping,
    MassStep,
    GroundDamping,
    GuideFriction,
    SensorDelay,
    WheelbaseDelay,
    SensorGain,
    SensorOffset,
    SensorDrift,
}

/// Where an effect may act.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Axle {
    Front,
    Rear,
    Both,
}

impl Axle {
    pub const ONE: [Axle; 2] = [Axle::Front, Axle::Rear];

    pub fn name(self) -> &'static str {
        match self {
            Axle::Front => "front",
            Axle::Rear => "rear",
            Axle::Both => "both",
        }
    }

    pub fn from_name(name: &str) -> Option<Self> {
        [Axle::Front, Axle::Rear, Axle::Both]
            .into_iter()
            .find(|a| a.name() == name)
    }

    pub fn covers(self, axle: usize) -> bool {
        self == Axle::Both || self as usize == axle
    }
}

impl Kind {
    pub const ALL: [Kind; 28] = [
        Kind::CubicStiffness,
        Kind::ProgressiveStiffness,
        Kind::QuadraticDamping,
        Kind::AsymmetricDamping,
        Kind::CoulombFriction,
        Kind::Hysteresis,
        Kind::ViscoelasticTyre,
        Kind::BumpStop,
        Kind::FreePlay,
        Kind::WheelLift,
        Kind::SprungMass,
        Kind::UnsprungMass,
        Kind::PitchCoupling,
        Kind::LoadTransfer,
        Kind::TyreEnveloping,
        Kind::WheelOutOfRound,
        Kind::PedallingForce,
        Kind::StiffnessDrift,
        Kind::SpeedDependentStiffness,
        Kind::SpeedDependentDamping,
        Kind::MassStep,
        Kind::GroundDamping,
        Kind::GuideFriction,
        Kind::SensorDelay,
        Kind::WheelbaseDelay,
        Kind::SensorGain,
        Kind::SensorOffset,
        Kind::SensorDrift,
    ];

    /// Id and parameter names, in the order of [`Effect::values`]. `side` is 1 compression, -1 rebound, 0 both.
    pub fn names(self) -> (&'static str, &'static [&'static str]) {
        match self {
            Kind::CubicStiffness => ("cubic_stiffness", &["k3"]),
            Kind::ProgressiveStiffness => ("progressive_stiffness", &["k2"]),
            Kind::QuadraticDamping => ("quadratic_damping", &["c2"]),
            Kind::AsymmetricDamping => ("asymmetric_damping", &["asymmetry"]),
            Kind::CoulombFriction => ("coulomb_friction", &["friction"]),
            Kind::Hysteresis => ("hysteresis", &["stiffness", "yield_force"]),
            Kind::ViscoelasticTyre => (
                "viscoelastic_tyre",
                &["branch_stiffness", "relaxation_time"],
            ),
            Kind::BumpStop => ("bump_stop", &["gap", "stop_stiffness", "side"]),
            Kind::FreePlay => ("free_play", &["gap"]),
            Kind::WheelLift => ("wheel_lift", &["static_load"]),
            Kind::SprungMass => (
                "sprung_mass",
                &["mass_fraction", "natural_frequency", "damping_ratio"],
            ),
            Kind::UnsprungMass => (
                "unsprung_mass",
                &["mass_fraction", "natural_frequency", "damping_ratio"],
            ),
            Kind::PitchCoupling => ("pitch_coupling", &["pitch_inertia"]),
            Kind::LoadTransfer => ("load_transfer", &["cog_height"]),
            Kind::TyreEnveloping => ("tyre_enveloping", &["patch_length"]),
            Kind::WheelOutOfRound => (
                "wheel_out_of_round",
                &["amplitude", "phase", "rolling_radius"],
            ),
            Kind::PedallingForce => ("pedalling_force", &["amplitude", "phase"]),
            Kind::StiffnessDrift => ("stiffness_drift", &["rate"]),
            Kind::SpeedDependentStiffness => ("speed_dependent_stiffness", &["slope"]),
            Kind::SpeedDependentDamping => ("speed_dependent_damping", &["share"]),
            Kind::MassStep => ("mass_step", &["fraction", "from", "to"]),
            Kind::GroundDamping => ("ground_damping", &["damping"]),
            Kind::GuideFriction => ("guide_friction", &["friction"]),
            Kind::SensorDelay => ("sensor_delay", &["delay"]),
            Kind::WheelbaseDelay => ("wheelbase_delay", &["wheelbase_error"]),
            Kind::SensorGain => ("sensor_gain", &["gain"]),
            Kind::SensorOffset => ("sensor_offset", &["offset"]),
            Kind::SensorDrift => ("sensor_drift", &["rate"]),
        }
    }

    pub fn id(self) -> &'static str {
        self.names().0
    }

    pub fn from_id(id: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|k| k.id() == id)
    }

    pub fn axles(self) -> &'static [Axle] {
        match self {
            Kind::PitchCoupling | Kind::LoadTransfer => &[Axle::Both],
            Kind::WheelbaseDelay => &[Axle::Rear],
            _ => &Axle::ONE,
        }
    }

    /// Needs distance ridden, speed or cranks, that is a ride on a road.
    pub fn needs_road(self) -> bool {
        matches!(
            self,
            Kind::LoadTransfer
                | Kind::TyreEnveloping
                | Kind::WheelOutOfRound
                | Kind::PedallingForce
                | Kind::SpeedDependentStiffness
                | Kind::SpeedDependentDamping
                | Kind::WheelbaseDelay
                | Kind::WheelLift
        )
    }

    /// Internal states per axle.
    pub fn states(self) -> usize {
        match self {
            Kind::Hysteresis | Kind::ViscoelasticTyre => 1,
            Kind::SprungMass | Kind::UnsprungMass => 2,
            _ => 0,
        }
    }
}

/// One effect with its parameters, SI.
#[derive(Clone, Debug)]
pub struct Effect {
    pub kind: Kind,
    pub axle: Axle,
    pub values: Vec<f64>,
}

impl Effect {
    pub fn new(kind: Kind, axle: Axle, values: &[f64]) -> Self {
        debug_assert_eq!(values.len(), kind.names().1.len());
        Self {
            kind,
            axle,
            values: values.to_vec(),
        }
    }

    pub fn to_json(&self) -> Value {
        let (id, names) = self.kind.names();
        let parameters: Map<String, Value> = names
            .iter()
            .zip(&self.values)
            .map(|(&name, &value)| {
                let shown = match name {
                    "side" if value > 0.0 => json!("compression"),
                    "side" if value < 0.0 => json!("rebound"),
                    "side" => json!("both"),
                    _ => json!(value),
                };
                (name.to_owned(), shown)
            })
            .collect();
        json!({"id": id, "axle": self.axle.name(), "parameters": parameters})
    }

    pub fn from_json(value: &Value) -> Option<Self> {
        let kind = Kind::from_id(value["id"].as_str()?)?;
        let axle = Axle::from_name(value["axle"].as_str()?)?;
        let values = kind
            .names()
            .1
            .iter()
            .map(|&name| match value["parameters"][name].as_str() {
                Some("compression") => Some(1.0),
                Some("rebound") => Some(-1.0),
                Some(_) => Some(0.0),
                None => value["parameters"][name].as_f64(),
            })
            .collect::<Option<Vec<_>>>()?;
        Some(Self { kind, axle, values })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn json_round_trip_keeps_every_kind() {
        for kind in Kind::ALL {
            let values: Vec<f64> = kind
                .names()
                .1
                .iter()
                .map(|&n| if n == "side" { -1.0 } else { 0.25 })
                .collect();
            let effect = Effect::new(kind, kind.axles()[0], &values);
            let back = Effect::from_json(&effect.to_json()).unwrap();
            assert_eq!(
                (back.kind, back.axle, back.values),
                (kind, effect.axle, values)
            );
        }
    }
}
