//! The library of physics that the plain model leaves out: one file per effect.
//!
//! An effect hooks into the motion of one axle at the place where it acts: the tyre's force, the
//! force on the mass, its inertia, states of its own, the road under the wheel, or the sensor. To
//! add one, write its file and add its line to the list below.

use crate::diagnosis::Stronger;
use crate::diagnosis::scene::Scale;
use crate::simulate::lanes::Lanes;

/// Parameters that an effect may have at most.
pub const MAX_PARAMETERS: usize = 4;
/// States that an effect may have at most.
pub const MAX_STATES: usize = 2;

/// One effect's parameters, for one parameter set and for eight.
pub type Values = [f64; MAX_PARAMETERS];
pub type LaneValues = [Lanes; MAX_PARAMETERS];
pub type States = [Lanes; MAX_STATES];

/// Where an effect can act.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Acts {
    /// On the front or the rear axle separately.
    OneAxle,
    /// On the rear axle only.
    Rear,
    /// On both axles with one set of parameters.
    Both,
}

/// What a ride must have for an effect to be spoken about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Need {
    /// A road that moves.
    Road,
    Speed,
    VaryingSpeed,
    Cadence,
    /// The masses of both axles and their distances from the centre of gravity.
    Geometry,
    WheelRadius,
    StaticLoad,
}

/// A fitted parameter.
pub struct Parameter {
    pub name: &'static str,
    pub unit: &'static str,
    /// A typical size, from which the fit takes its steps.
    pub size: fn(&Scale) -> f64,
    /// Hard limits of the fit.
    pub limits: fn(&Scale) -> [f64; 2],
}

/// A parameter as it is reported.
pub struct Reported {
    pub name: &'static str,
    pub unit: &'static str,
    pub value: f64,
    /// Whether a real bicycle can have this value.
    pub physical: bool,
}

pub struct Spec {
    pub id: &'static str,
    pub acts: Acts,
    pub needs: &'static [Need],
    /// The parameters that the fit moves. Values beyond them are choices that starts make.
    pub parameters: &'static [Parameter],
    /// Parameters in which the effect is nearly linear and that are zero without it: their starts are
    /// scaled to the residual. None: starts are taken as they are.
    pub amplitudes: &'static [usize],
    /// The parameter, fitted and reported under this number, that tells how large the effect is, and whether it does more
    /// when it is larger.
    pub told: usize,
    pub stronger: Stronger,
    /// Parameter sets to start the fit from; with two amplitudes, one of them zero, in pairs.
    pub starts: fn(&Scale) -> Vec<Values>,
    /// Starts between the best start and its neighbours, at the given zoom (1, 2, ..), if any.
    pub nearer: fn(&Values, &Scale, u32) -> Vec<Values>,
    pub report: fn(&Values, &Scale) -> Vec<Reported>,
    /// Stiffness (N/m) that the effect adds at most, which the integrator must resolve.
    pub stiffens: fn(&Values, &Scale) -> f64,
    /// Damping (N s/m) that the effect adds at most, likewise.
    pub damps: fn(&Values, &Scale) -> f64,
    /// k/m and B/m of an axle that moves slowly as it does with the effect, for a fit without it to start from.
    pub alone: fn([f64; 2], &Values) -> [f64; 2],
    pub states: usize,
    pub on_road: bool,
    pub on_sensor: bool,
    /// Whether the effect belongs to a moment of this ride, so that the held-out part need not show it.
    pub local: bool,
    /// Whether the effect is so slow that coloured noise imitates it: what it promises under the noise of
    /// a model without it says nothing, only a refit does.
    pub slow: bool,
    /// Whether the force has corners, which the integrator must meet with shorter steps.
    pub corners: bool,
    /// Whether the likelihood has many peaks, so that a fit also starts from afar.
    pub peaks: bool,
    /// Parameters for which a value and a deviation are expected where the ride says nothing.
    pub expected: &'static [(usize, f64, f64)],
    /// The effect in plain words.
    pub words: &'static str,
    pub confused_with: &'static [&'static str],
    pub source: &'static str,
}

impl Spec {
    /// What most effects have in common; the rest each says for itself.
    const ORDINARY: Spec = Spec {
        id: "",
        acts: Acts::OneAxle,
        needs: &[],
        parameters: &[],
        amplitudes: &[],
        told: 0,
        stronger: Stronger::Larger,
        starts: |_| Vec::new(),
        nearer: |_, _, _| Vec::new(),
        report: |_, _| Vec::new(),
        stiffens: |_, _| 0.0,
        damps: |_, _| 0.0,
        alone: |base, _| base,
        states: 0,
        on_road: false,
        on_sensor: false,
        local: false,
        slow: false,
        corners: false,
        peaks: false,
        expected: &[],
        words: "",
        confused_with: &[],
        source: "",
    };
}

/// One axle at one instant, for eight parameter sets.
pub struct Motion<'a> {
    /// Deflection across the tyre d = u - z (m) and its rate w (m/s).
    pub d: Lanes,
    pub w: Lanes,
    /// Height (m) and velocity (m/s) of the axle mass.
    pub z: Lanes,
    pub v: Lanes,
    /// k/m (1/s^2), B/m (1/s), 1/m (1/kg).
    pub kappa: Lanes,
    pub beta: Lanes,
    pub per_mass: Lanes,
    /// Time since the first sample (s).
    pub t: f64,
    /// Speed (m/s) and its smoothed rate (m/s^2).
    pub speed: f64,
    pub speed_rate: f64,
    /// Sine and cosine of twice the crank angle.
    pub crank: [f64; 2],
    /// Step of the integrator (s).
    pub step: f64,
    pub scale: &'a Scale,
}

/// Where an effect reads the road at one sample, for one parameter set.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tap {
    /// The road is read `shift` (s) earlier, averaged over `half_window` (s) to both sides.
    pub shift: f64,
    pub half_window: f64,
    /// Added height (m) and its rate (m/s).
    pub value: f64,
    pub slope: f64,
}

/// What is known of the sample at which the road is read.
pub struct Spot {
    pub speed: f64,
    /// Distance ridden (m).
    pub distance: f64,
}

/// How the displacement sensor reads, for one parameter set at one sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pickup {
    pub delay: f64,
    pub gain: f64,
    pub offset: f64,
}

/// The hooks of an effect. Forces are divided by the axle mass (m/s^2).
pub trait Effect {
    const SPEC: Spec;

    /// The tyre's force with this effect, given the force without it.
    #[inline(always)]
    fn tyre(_p: &LaneValues, _m: &Motion, _s: &States, force: Lanes) -> Lanes {
        force
    }

    /// The other forces on the axle mass.
    #[inline(always)]
    fn body(_p: &LaneValues, _m: &Motion, force: Lanes) -> Lanes {
        force
    }

    /// The acceleration, given the force over the axle mass.
    #[inline(always)]
    fn inertia(_p: &LaneValues, _m: &Motion, _s: &States, force: Lanes) -> Lanes {
        force
    }

    /// Rates of the effect's own states.
    #[inline(always)]
    fn rates(_p: &LaneValues, _m: &Motion, _s: &States) -> States {
        [Lanes::ZERO; MAX_STATES]
    }

    fn road(_p: &Values, _spot: &Spot, _scale: &Scale, _tap: &mut Tap) {}

    fn sensor(_p: &Values, _t: f64, _pickup: &mut Pickup) {}

    /// The values that are reported as these, in the order of the report.
    fn from_reported(reported: &[f64], _scale: &Scale) -> Values {
        std::array::from_fn(|i| reported.get(i).copied().unwrap_or(0.0))
    }
}

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

/// A parameter that is reported as it is fitted, physical within `range`.
fn reported(parameter: &Parameter, value: f64, range: [f64; 2]) -> Reported {
    Reported {
        name: parameter.name,
        unit: parameter.unit,
        value,
        physical: (range[0]..=range[1]).contains(&value),
    }
}
