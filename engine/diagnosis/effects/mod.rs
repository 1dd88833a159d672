//! The library of physics that the plain model leaves out: one file per effect.
//!
//! An effect hooks into the motion of one axle at the place where it acts: the tyre's force, the
//! force on the mass, its inertia, states of its own, the road under the wheel, or the sensor. To
//! add one, write its file and add its line to the list below.

use std::borrow::Cow;

use crate::diagnosis::law::{
    Effect, LaneValues, Lanes, MAX_PARAMETERS, Motion, Need, Pickup, Scale, Spec, Spot, States,
    Tap, Values, as_reported,
};

pub mod catalogue;
mod from_settings;
mod own_law;
#[cfg(test)]
mod testing;

pub use from_settings::users_law;
pub use own_law::Shape;

/// Work that is compiled for each effect.
pub trait ForEffect {
    fn of<E: Effect>(self);

    fn of_own_law(self);
}

macro_rules! library {
    ($($file:ident :: $name:ident),* $(,)?) => {
        $(mod $file;)*

        /// Every effect that can be modelled, the library's and the user's.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Kind {
            /// The user's own law, which the sizes of the ride hold.
            Own(Shape),
            $($name),*
        }

        /// The library.
        pub const ALL: &[Kind] = &[$(Kind::$name),*];

        impl Kind {
            pub fn spec(self) -> &'static Spec {
                match self {
                    Kind::Own(shape) => shape.spec(),
                    $(Kind::$name => const { &<$file::$name as Effect>::SPEC }),*
                }
            }

            /// Has `work` done for the effect's type.
            pub fn visit(self, work: impl ForEffect) {
                match self {
                    Kind::Own(_) => work.of_own_law(),
                    $(Kind::$name => work.of::<$file::$name>()),*
                }
            }

            /// What the effect makes of the tyre's force and of the others on the mass.
            #[inline(always)]
            pub fn forces(
                self,
                p: &LaneValues,
                m: &Motion,
                s: &States,
                [tyre, body]: [Lanes; 2],
            ) -> [Lanes; 2] {
                match self {
                    Kind::Own(_) => [own_law::tyre(p, m, s, tyre), own_law::body(p, m, s, body)],
                    $(Kind::$name => [
                        $file::$name::tyre(p, m, s, tyre),
                        $file::$name::body(p, m, s, body),
                    ]),*
                }
            }

            /// The acceleration under a `force`, with the rates of the effect's own states.
            #[inline(always)]
            pub fn moved(
                self,
                p: &LaneValues,
                m: &Motion,
                s: &States,
                force: Lanes,
                rates: &mut States,
            ) -> Lanes {
                match self {
                    Kind::Own(_) => {
                        *rates = own_law::rates(p, m, s);
                        force
                    }
                    $(Kind::$name => {
                        *rates = $file::$name::rates(p, m, s);
                        $file::$name::inertia(p, m, s, force)
                    }),*
                }
            }

            #[inline(always)]
            pub fn road(self, p: &LaneValues, spot: &Spot, scale: &Scale, tap: &mut Tap) {
                match self {
                    Kind::Own(_) => {}
                    $(Kind::$name => $file::$name::road(p, spot, scale, tap)),*
                }
            }

            pub fn sensor(self, p: &Values, t: f64, pickup: &mut Pickup) {
                match self {
                    Kind::Own(_) => {}
                    $(Kind::$name => $file::$name::sensor(p, t, pickup)),*
                }
            }

            pub fn from_reported(self, reported: &[f64], scale: &Scale) -> Values {
                match self {
                    Kind::Own(_) => as_reported(reported),
                    $(Kind::$name => $file::$name::from_reported(reported, scale)),*
                }
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
    force_lag::ForceLag,
    power_damping::PowerDamping,
    position_damping::PositionDamping,
    friction_curve::FrictionCurve,
}

/// General shapes that are never named, against which names are held.
pub const GENERAL_LAWS: [Kind; 5] = [
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
        ALL.iter()
            .copied()
            .filter(|kind| !GENERAL_LAWS.contains(kind))
    }

    /// What a ride must have for the effect to be spoken about.
    pub fn needs(self, scale: &Scale) -> Vec<Need> {
        match (self, &scale.own) {
            (Self::Own(_), Some(law)) => law.needs(),
            _ => self.spec().needs.to_vec(),
        }
    }

    /// The id in reports.
    pub fn id_on(self, scale: &Scale) -> &str {
        match (self, &scale.own) {
            (Self::Own(_), Some(law)) => &law.id,
            _ => self.id(),
        }
    }

    /// The effect in plain words.
    pub fn words_on(self, scale: &Scale) -> &str {
        match (self, &scale.own) {
            (Self::Own(_), Some(law)) => &law.words,
            _ => self.spec().words,
        }
    }

    /// Names of the parameters as reports give them.
    pub fn reported(self) -> Vec<Cow<'static, str>> {
        let reported = (self.spec().report)(&[1.0; MAX_PARAMETERS], &Scale::TYPICAL);
        reported
            .into_iter()
            .map(|parameter| parameter.name)
            .collect()
    }
}
