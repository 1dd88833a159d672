//! What a ride without a road can say of each effect of the library.

use veloid_model::effects::Kind;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Inverted on the one axle and driven on the other.
    LookedFor,
    /// Found as a delay between the sensors.
    Delay,
    /// Why it cannot be shown.
    Not(&'static str),
}

const COMMON: &str = "both wheels do it alike to an unknown road, which absorbs it";
const UNSTABLE: &str = "the axle's law cannot be solved for the road where it acts";
const OF_SENSOR: &str = "accelerometers have no zero point or scale against a road that is unknown";

pub fn role(kind: Kind) -> Role {
    match kind {
        Kind::CubicStiffness
        | Kind::ProgressiveStiffness
        | Kind::QuadraticDamping
        | Kind::AsymmetricDamping
        | Kind::CoulombFriction
        | Kind::Hysteresis
        | Kind::ViscoelasticTyre
        | Kind::BumpStop
        | Kind::PedallingForce
        | Kind::SprungMass
        | Kind::WheelOutOfRound
        | Kind::StiffnessDrift
        | Kind::PowerDamping
        | Kind::PowerStiffness
        | Kind::PositionDamping => Role::LookedFor,
        Kind::SensorDelay => Role::Delay,
        Kind::TyreEnveloping | Kind::PitchCoupling | Kind::LoadTransfer | Kind::WheelbaseDelay => {
            Role::Not(COMMON)
        }
        Kind::FreePlay | Kind::WheelLift | Kind::FrictionCurve => Role::Not(UNSTABLE),
        Kind::SensorGain | Kind::SensorOffset | Kind::SensorDrift => Role::Not(OF_SENSOR),
        Kind::UnsprungMass | Kind::ForceLag => {
            Role::Not("the accelerometer is not on the mass whose force it would have to measure")
        }
        Kind::GroundDamping | Kind::GuideFriction => {
            Role::Not("nothing holds a ridden bicycle to the ground")
        }
        Kind::RateHysteresis | Kind::HardeningMass => {
            Role::Not("it is not distinguished from the law of which it is the general case")
        }
        Kind::SpeedDependentStiffness
        | Kind::SpeedDependentDamping
        | Kind::MassStep
        | Kind::Own(_) => Role::Not("not looked for without a road"),
    }
}

/// Whether an effect is linear as the axles are, so that most of it passes for another k and B.
pub fn is_linear(kind: Kind) -> bool {
    matches!(kind, Kind::SprungMass | Kind::ViscoelasticTyre)
}
