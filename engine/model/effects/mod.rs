//! The library of physics that the plain model leaves out: one file per effect.
//!
//! An effect hooks into the motion of one axle at the place where it acts: the tyre's force, the
//! force on the mass, its inertia, states of its own, the road under the wheel, or the sensor. To
//! add one, write its file and add its name, with what it does, to the list below.

use std::borrow::Cow;

use crate::law::{
    Effect, Family, LaneValues, Lanes, MAX_PARAMETERS, Motion, Need, Pickup, Scale, Spec, Spot,
    States, Tap, Values, as_reported,
};

pub mod catalogue;
#[cfg(test)]
mod formulas;
mod from_settings;
mod law_of;
mod own_law;
#[cfg(test)]
mod testing;

pub use from_settings::users_law;
pub use law_of::set_sizes;
pub use own_law::Shape;

/// Work that is compiled for each effect.
pub trait ForEffect {
    fn of<E: Effect>(self);

    fn of_own_law(self);
}

macro_rules! library {
    ($($(#[$doc:meta])* $file:ident :: $name:ident),* $(,)?) => {
        $(mod $file;)*

        /// Every effect that can be modelled, the library's and the user's.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Kind {
            /// The user's own law, which the sizes of the ride hold.
            Own(Shape),
            $($(#[$doc])* $name),*
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
                s: &[Lanes],
                [tyre, body]: [Lanes; 2],
            ) -> [Lanes; 2] {
                let few = &few(s);
                match self {
                    Kind::Own(_) => [own_law::tyre(p, m, s, tyre), own_law::body(p, m, s, body)],
                    $(Kind::$name => [
                        $file::$name::tyre(p, m, few, tyre),
                        $file::$name::body(p, m, few, body),
                    ]),*
                }
            }

            /// The acceleration under a `force`, with the rates of the effect's own states written to `rates`.
            #[inline(always)]
            pub fn moved(
                self,
                p: &LaneValues,
                m: &Motion,
                s: &[Lanes],
                force: Lanes,
                rates: &mut [Lanes],
            ) -> Lanes {
                let few = &few(s);
                match self {
                    Kind::Own(_) => {
                        own_law::rates(p, m, s, rates);
                        force
                    }
                    $(Kind::$name => {
                        let own = $file::$name::rates(p, m, few);
                        rates.iter_mut().zip(own).for_each(|(rate, own)| *rate = own);
                        $file::$name::inertia(p, m, few, force)
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

            pub fn values_of(self, reported: &[f64], scale: &Scale) -> Values {
                match self {
                    Kind::Own(_) => as_reported(reported),
                    $(Kind::$name => $file::$name::from_reported(reported, scale)),*
                }
            }
        }
    };
}

/// The states of an effect of the library; zeros where it has none.
#[inline(always)]
fn few(states: &[Lanes]) -> States {
    [0, 1].map(|q| states.get(q).copied().unwrap_or(Lanes::ZERO))
}

// In the order in which they act: the tyre's laws, what bounds the tyre's force, then the rest; the suspension
// carries the sprung mass too.
library! {
    /// The spring stiffens (or softens) with the cube of its deflection.
    cubic_stiffness::CubicStiffness,
    /// The spring stiffens in compression and softens in rebound.
    progressive_stiffness::ProgressiveStiffness,
    /// Damping grows with the speed of deflection.
    quadratic_damping::QuadraticDamping,
    /// Compression and rebound damp differently.
    asymmetric_damping::AsymmetricDamping,
    /// Dry friction acts along the suspension (fork, seat post, guide).
    coulomb_friction::CoulombFriction,
    /// The tyre or frame loses energy by rate-independent hysteresis.
    hysteresis::Hysteresis,
    /// The loss depends on the rate.
    rate_hysteresis::RateHysteresis,
    /// The tyre relaxes: part of its stiffness acts only while the deflection changes.
    viscoelastic_tyre::ViscoelasticTyre,
    /// The travel ends at a stop (bottoming, rim strike).
    bump_stop::BumpStop,
    /// There is backlash: no spring force within a gap.
    free_play::FreePlay,
    /// The stiffness drifts along the ride (pressure loss, warming).
    stiffness_drift::StiffnessDrift,
    /// The tyre's stiffness changes with speed.
    speed_dependent_stiffness::SpeedDependentStiffness,
    /// The tyre's damping falls with rolling speed.
    speed_dependent_damping::SpeedDependentDamping,
    /// The wheel leaves the ground: the tyre cannot pull.
    wheel_lift::WheelLift,
    /// A damper acts against the resting frame (a rig's guide, air).
    ground_damping::GroundDamping,
    /// Dry friction holds the mass against the resting frame.
    guide_friction::GuideFriction,
    /// Pedalling pushes the axle at twice the cadence.
    pedalling_force::PedallingForce,
    /// Braking and accelerating shift load between the axles.
    load_transfer::LoadTransfer,
    /// The wheel is a mass of its own on the tyre, below a fork or suspension stage.
    unsprung_mass::UnsprungMass,
    /// A part of the mass rides on its own spring (rider on the saddle, luggage).
    sprung_mass::SprungMass,
    /// The frequency of a second mass depends on how far it moves.
    hardening_mass::HardeningMass,
    /// Pitching couples the two axles.
    pitch_coupling::PitchCoupling,
    /// The mass on the axle changes for a while (the rider stands up, luggage falls off).
    mass_step::MassStep,
    /// The tyre's contact patch averages the road.
    tyre_enveloping::TyreEnveloping,
    /// The wheel is out of round.
    wheel_out_of_round::WheelOutOfRound,
    /// The rear road input is shifted by a wrong wheelbase.
    wheelbase_delay::WheelbaseDelay,
    /// The displacement is logged late or early against the road.
    sensor_delay::SensorDelay,
    /// The displacement sensor's gain is off.
    sensor_gain::SensorGain,
    /// The displacement sensor's zero point is off.
    sensor_offset::SensorOffset,
    /// The displacement sensor's zero point wanders.
    sensor_drift::SensorDrift,
    /// The force follows the motion with a lag of the first order (a fluid, a magnet, an amplifier).
    force_lag::ForceLag,
    /// The damper follows some power of the rate.
    power_damping::PowerDamping,
    /// The spring stiffens with some power of its deflection.
    power_stiffness::PowerStiffness,
    /// The damper depends on its position.
    position_damping::PositionDamping,
    /// Dry friction changes with the sliding rate.
    friction_curve::FrictionCurve,
}

impl Kind {
    /// Id in reports, such as `coulomb_friction`.
    pub fn id(self) -> &'static str {
        self.spec().id
    }

    /// The numbers of a fit behind the parameters that reports name.
    ///
    /// # Errors
    /// The first parameter without a value.
    pub fn values_named(
        self,
        parameter: impl Fn(&str) -> Option<f64>,
        scale: &Scale,
    ) -> Result<Values, Cow<'static, str>> {
        let reported = (self.spec().report)(&[1.0; MAX_PARAMETERS], scale).into_iter();
        let reported: Result<Vec<f64>, _> =
            reported.map(|p| parameter(&p.name).ok_or(p.name)).collect();
        Ok(self.values_of(&reported?, scale))
    }

    /// Whether it is a law of this variable that can be named.
    pub fn is_named(self, family: Family) -> bool {
        let spec = self.spec();
        spec.family == Some(family) && !spec.is_general
    }

    /// The general laws of a variable.
    pub fn general(family: Family) -> impl Iterator<Item = Kind> {
        let is_one = move |kind: &Kind| {
            let spec = kind.spec();
            spec.family == Some(family) && spec.is_general
        };
        ALL.iter().copied().filter(is_one)
    }

    /// The general law of which it is a case.
    pub fn case_of(self) -> Option<Kind> {
        self.spec().case_of.and_then(Kind::by_id)
    }

    /// Whether it is a limit of another law, as dry friction is of its hysteresis.
    pub fn is_limit_of(self, wide: Kind) -> bool {
        self.spec().limit_of.contains(&wide.id())
    }

    /// The effect of the library with this id.
    pub fn by_id(id: &str) -> Option<Self> {
        ALL.iter().copied().find(|k| k.id() == id)
    }

    /// Every effect that may be named.
    pub fn named() -> impl Iterator<Item = Self> {
        ALL.iter().copied().filter(|kind| !kind.spec().is_general)
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
