//! The library of physics that the plain model leaves out: one file per effect.
//!
//! An effect hooks into the motion of one axle at the place where it acts: the tyre's force, the
//! force on the mass, its inertia, states of its own, the road under the wheel, or the sensor. To
//! add one, write its file and add its line to the list below.

use crate::diagnosis::law::{
    Effect, LaneValues, Lanes, MAX_PARAMETERS, Motion, Pickup, Scale, Spec, Spot, States, Tap,
    Values,
};

macro_rules! library {
    ($($file:ident :: $name:ident),* $(,)?) => {
        $(mod $file;)*

        /// Every effect that can be modelled.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Kind { $($name),* }

        pub const ALL: &[Kind] = &[$(Kind::$name),*];

        impl Kind {
            pub fn spec(self) -> &'static Spec {
                match self { $(Kind::$name => const { &<$file::$name as Effect>::SPEC }),* }
            }

            #[inline(always)]
            pub fn tyre(self, p: &LaneValues, m: &Motion, s: &States, force: Lanes) -> Lanes {
                match self { $(Kind::$name => $file::$name::tyre(p, m, s, force)),* }
            }

            #[inline(always)]
            pub fn body(self, p: &LaneValues, m: &Motion, force: Lanes) -> Lanes {
                match self { $(Kind::$name => $file::$name::body(p, m, force)),* }
            }

            #[inline(always)]
            pub fn inertia(self, p: &LaneValues, m: &Motion, s: &States, force: Lanes) -> Lanes {
                match self { $(Kind::$name => $file::$name::inertia(p, m, s, force)),* }
            }

            #[inline(always)]
            pub fn rates(self, p: &LaneValues, m: &Motion, s: &States) -> States {
                match self { $(Kind::$name => $file::$name::rates(p, m, s)),* }
            }

            pub fn road(self, p: &Values, spot: &Spot, scale: &Scale, tap: &mut Tap) {
                match self { $(Kind::$name => $file::$name::road(p, spot, scale, tap)),* }
            }

            pub fn sensor(self, p: &Values, t: f64, pickup: &mut Pickup) {
                match self { $(Kind::$name => $file::$name::sensor(p, t, pickup)),* }
            }

            pub fn from_reported(self, reported: &[f64], scale: &Scale) -> Values {
                match self { $(Kind::$name => $file::$name::from_reported(reported, scale)),* }
            }
        }
    };
}

// In the order in which they act: the tyre's laws, what bounds the tyre's force, then the rest; the suspension
// carries the sprung mass too.
library! {
    cubic_stiffness::CubicStiffness,
    progressive_stiffness::ProgressiveStiffness,
    quadratic_damping::QuadraticDamping,
    asymmetric_damping::AsymmetricDamping,
    coulomb_friction::CoulombFriction,
    hysteresis::Hysteresis,
    rate_hysteresis::RateHysteresis,
    viscoelastic_tyre::ViscoelasticTyre,
    bump_stop::BumpStop,
    free_play::FreePlay,
    stiffness_drift::StiffnessDrift,
    speed_dependent_stiffness::SpeedDependentStiffness,
    speed_dependent_damping::SpeedDependentDamping,
    wheel_lift::WheelLift,
    ground_damping::GroundDamping,
    guide_friction::GuideFriction,
    pedalling_force::PedallingForce,
    load_transfer::LoadTransfer,
    unsprung_mass::UnsprungMass,
    sprung_mass::SprungMass,
    hardening_mass::HardeningMass,
    pitch_coupling::PitchCoupling,
    mass_step::MassStep,
    tyre_enveloping::TyreEnveloping,
    wheel_out_of_round::WheelOutOfRound,
    wheelbase_delay::WheelbaseDelay,
    sensor_delay::SensorDelay,
    sensor_gain::SensorGain,
    sensor_offset::SensorOffset,
    sensor_drift::SensorDrift,
    power_damping::PowerDamping,
    position_damping::PositionDamping,
    friction_curve::FrictionCurve,
}

/// General shapes that are never named, against which names are held.
pub const FOILS: [Kind; 5] = [
    Kind::PowerDamping,
    Kind::PositionDamping,
    Kind::FrictionCurve,
    Kind::RateHysteresis,
    Kind::HardeningMass,
];

impl Kind {
    pub fn id(self) -> &'static str {
        self.spec().id
    }

    pub fn by_id(id: &str) -> Option<Self> {
        ALL.iter().copied().find(|k| k.id() == id)
    }

    /// Every effect that may be named.
    pub fn named() -> impl Iterator<Item = Self> {
        ALL.iter().copied().filter(|kind| !FOILS.contains(kind))
    }

    /// Names of the parameters as reports give them.
    pub fn reported(self) -> Vec<&'static str> {
        let told = (self.spec().report)(&[1.0; MAX_PARAMETERS], &Scale::TYPICAL);
        told.into_iter().map(|parameter| parameter.name).collect()
    }
}
