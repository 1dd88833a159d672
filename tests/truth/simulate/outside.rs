//! Physics that is NOT in the library: what the diagnosis must call `unnamed`.
//!
//! Each is an additional force on one axle's tyre or body, written so that no combination of one library effect and k, B reproduces it.
//! d is the deflection (m, positive pressed), w its rate (m/s), z' the rate of the axle mass (m/s), k and B those of the axle.

mod damping;
mod input;
mod known;
mod memory;
mod spring;

use serde_json::{Value, json};

use super::contact::Contact;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Strange {
    PowerDamping,
    CubicDamping,
    StribeckFriction,
    ParametricWheel,
    HardeningFrameMode,
    ImpactBacklash,
    ThermalSoftening,
    PostureBursts,
    LateralCoupling,
    DampingSteps,
    MagneticRepulsion,
    PositionDamping,
    TwoPowerSpring,
    RateStiffenedSpring,
    InterlinkedSprings,
    WanderingStop,
    LoadFriction,
    EddyDamping,
    SlackCable,
    CrankDamping,
    ValveBump,
    Gusts,
    ThixotropicGrease,
    DelayedRelief,
    LogCreep,
    SlowFollower,
    InertiaValve,
    RectifiedGenerator,
    ImpactPreload,
    SnapDome,
    DetentRipple,
    SkyhookDamper,
    DwellFriction,
    BistableLatch,
    Slosh,
    LeakingAirSpring,
    GranularJamming,
    BreakingBond,
    HydraulicMount,
    DeflectionDamping,
}

/// One strange law on one axle. `values` has the meaning that its law gives it; `events` are (from s, to s, size) for the
/// laws that act in stretches, and the sines of gusts.
#[derive(Clone, Debug)]
pub struct Outside {
    pub kind: Strange,
    pub axle: usize,
    pub values: Vec<f64>,
    pub events: Vec<[f64; 3]>,
}

impl Strange {
    /// Those of the suites `standard` and `beside`.
    pub const KNOWN: [Strange; 12] = [
        Strange::PowerDamping,
        Strange::CubicDamping,
        Strange::StribeckFriction,
        Strange::ParametricWheel,
        Strange::HardeningFrameMode,
        Strange::ImpactBacklash,
        Strange::ThermalSoftening,
        Strange::PostureBursts,
        Strange::LateralCoupling,
        Strange::DampingSteps,
        Strange::MagneticRepulsion,
        Strange::PositionDamping,
    ];

    /// Those that development may look at from suite `strange` on.
    pub const OPEN: [Strange; 17] = [
        Strange::TwoPowerSpring,
        Strange::RateStiffenedSpring,
        Strange::InterlinkedSprings,
        Strange::WanderingStop,
        Strange::LoadFriction,
        Strange::EddyDamping,
        Strange::SlackCable,
        Strange::CrankDamping,
        Strange::ValveBump,
        Strange::Gusts,
        Strange::ThixotropicGrease,
        Strange::DelayedRelief,
        Strange::LogCreep,
        Strange::SlowFollower,
        Strange::InertiaValve,
        Strange::RectifiedGenerator,
        Strange::ImpactPreload,
    ];

    /// Those that nobody runs through veloid, nor tunes it for, before a blind proof: only suite `strange` has them.
    pub const KEPT_BACK: [Strange; 10] = [
        Strange::SnapDome,
        Strange::DetentRipple,
        Strange::SkyhookDamper,
        Strange::DwellFriction,
        Strange::BistableLatch,
        Strange::Slosh,
        Strange::LeakingAirSpring,
        Strange::GranularJamming,
        Strange::BreakingBond,
        Strange::HydraulicMount,
    ];

    /// Those of rides without a road alone; no suite has them.
    pub const WITHOUT_ROAD: [Strange; 1] = [Strange::DeflectionDamping];

    pub fn all() -> impl Iterator<Item = Strange> {
        let later = Self::OPEN.into_iter().chain(Self::KEPT_BACK);
        Self::KNOWN.into_iter().chain(later)
    }

    pub fn id(self) -> &'static str {
        match self {
            Strange::PowerDamping => "power_damping",
            Strange::CubicDamping => "cubic_damping",
            Strange::StribeckFriction => "stribeck_friction",
            Strange::ParametricWheel => "parametric_wheel",
            Strange::HardeningFrameMode => "hardening_frame_mode",
            Strange::ImpactBacklash => "impact_backlash",
            Strange::ThermalSoftening => "thermal_softening",
            Strange::PostureBursts => "posture_bursts",
            Strange::LateralCoupling => "lateral_coupling",
            Strange::DampingSteps => "damping_steps",
            Strange::MagneticRepulsion => "magnetic_repulsion",
            Strange::PositionDamping => "position_damping",
            Strange::TwoPowerSpring => "two_power_spring",
            Strange::RateStiffenedSpring => "rate_stiffened_spring",
            Strange::InterlinkedSprings => "interlinked_springs",
            Strange::WanderingStop => "wandering_stop",
            Strange::LoadFriction => "load_friction",
            Strange::EddyDamping => "eddy_damping",
            Strange::SlackCable => "slack_cable",
            Strange::CrankDamping => "crank_damping",
            Strange::ValveBump => "valve_bump",
            Strange::Gusts => "gusts",
            Strange::ThixotropicGrease => "thixotropic_grease",
            Strange::DelayedRelief => "delayed_relief",
            Strange::LogCreep => "log_creep",
            Strange::SlowFollower => "slow_follower",
            Strange::InertiaValve => "inertia_valve",
            Strange::RectifiedGenerator => "rectified_generator",
            Strange::ImpactPreload => "impact_preload",
            Strange::SnapDome => "snap_dome",
            Strange::DetentRipple => "detent_ripple",
            Strange::SkyhookDamper => "skyhook_damper",
            Strange::DwellFriction => "dwell_friction",
            Strange::BistableLatch => "bistable_latch",
            Strange::Slosh => "slosh",
            Strange::LeakingAirSpring => "leaking_air_spring",
            Strange::GranularJamming => "granular_jamming",
            Strange::BreakingBond => "breaking_bond",
            Strange::HydraulicMount => "hydraulic_mount",
            Strange::DeflectionDamping => "deflection_damping",
        }
    }

    pub fn from_id(id: &str) -> Option<Self> {
        let mut known = Self::all().chain(Self::WITHOUT_ROAD);
        known.find(|k| k.id() == id)
    }

    /// Needs distance, speed or cranks.
    pub fn needs_road(self) -> bool {
        matches!(
            self,
            Strange::ParametricWheel
                | Strange::LateralCoupling
                | Strange::CrankDamping
                | Strange::ValveBump
        )
    }

    /// Internal states.
    pub fn states(self) -> usize {
        match self {
            Strange::DelayedRelief => 4,
            _ => 2,
        }
    }
}

impl Outside {
    pub fn to_json(&self) -> Value {
        let axle = if self.axle == 0 { "front" } else { "rear" };
        json!({"id": self.kind.id(), "axle": axle, "values": self.values, "events": self.events})
    }

    pub fn from_json(value: &Value) -> Option<Self> {
        Some(Self {
            kind: Strange::from_id(value["id"].as_str()?)?,
            axle: usize::from(value["axle"].as_str()? == "rear"),
            values: serde_json::from_value(value["values"].clone()).ok()?,
            events: serde_json::from_value(value["events"].clone()).ok()?,
        })
    }

    fn event(&self, t: f64) -> Option<&[f64; 3]> {
        self.events.iter().find(|e| (e[0]..e[1]).contains(&t))
    }

    /// Force on the axle mass (N, up) with the internal states `s`, and their rates.
    pub fn force(&self, c: &Contact, s: &[f64], rate: &mut [f64]) -> f64 {
        let p = &self.values;
        match self.kind {
            Strange::PowerDamping => known::power_damping(p, c),
            Strange::CubicDamping => p[0] * c.w.powi(3),
            Strange::StribeckFriction => known::stribeck_friction(p, c, s, rate),
            Strange::ParametricWheel => known::parametric_wheel(p, c),
            Strange::HardeningFrameMode => known::hardening_frame_mode(p, c, s, rate),
            Strange::ImpactBacklash => known::impact_backlash(p, c, s, rate),
            Strange::ThermalSoftening => known::thermal_softening(p, c, s, rate),
            Strange::PostureBursts => known::posture_burst(self.event(c.t), c),
            Strange::LateralCoupling => p[0] * c.speed * c.other_d,
            Strange::DampingSteps => self.event(c.t).map_or(0.0, |e| e[2] * c.b * c.w),
            Strange::MagneticRepulsion => known::magnetic_repulsion(p, c),
            Strange::PositionDamping => p[0] * c.w * (c.d / p[1]).tanh(),
            Strange::TwoPowerSpring => spring::two_power_spring(p, c),
            Strange::RateStiffenedSpring => spring::rate_stiffened_spring(p, c),
            Strange::InterlinkedSprings => spring::interlinked_springs(p, c),
            Strange::WanderingStop => spring::wandering_stop(p, c, self.event(c.t).is_some()),
            Strange::LoadFriction => damping::load_friction(p, c),
            Strange::EddyDamping => damping::eddy_damping(p, c),
            Strange::SlackCable => damping::slack_cable(p, c),
            Strange::CrankDamping => damping::crank_damping(p, c),
            Strange::ValveBump => input::valve_bump(p, c),
            Strange::Gusts => input::gusts(&self.events, c),
            Strange::ThixotropicGrease => memory::thixotropic_grease(p, c, s, rate),
            Strange::DelayedRelief => memory::delayed_relief(p, c, s, rate),
            Strange::LogCreep => memory::log_creep(p, c, s, rate),
            Strange::SlowFollower => memory::slow_follower(p, c, s, rate),
            Strange::InertiaValve => memory::inertia_valve(p, c, s, rate),
            Strange::RectifiedGenerator => memory::rectified_generator(p, c, s, rate),
            Strange::ImpactPreload => memory::impact_preload(p, c, s, rate),
            Strange::SnapDome => spring::snap_dome(p, c),
            Strange::DetentRipple => spring::detent_ripple(p, c),
            Strange::SkyhookDamper => damping::skyhook_damper(p, c),
            Strange::DeflectionDamping => p[0] * c.d * c.d * c.w,
            Strange::DwellFriction => memory::dwell_friction(p, c, s, rate),
            Strange::BistableLatch => memory::bistable_latch(p, c, s, rate),
            Strange::Slosh => memory::slosh(p, c, s, rate),
            Strange::LeakingAirSpring => memory::leaking_air_spring(p, c, s, rate),
            Strange::GranularJamming => memory::granular_jamming(p, c, s, rate),
            Strange::BreakingBond => memory::breaking_bond(p, c, s, rate),
            Strange::HydraulicMount => memory::hydraulic_mount(p, c, s, rate),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_are_at_least_thirty_one_kinds_each_once() {
        let mut ids: Vec<&str> = Strange::all().map(Strange::id).collect();
        ids.sort();
        ids.dedup();
        assert!(ids.len() >= 31);
        assert_eq!(ids.len(), Strange::all().count());
        assert!(Strange::all().all(|kind| Strange::from_id(kind.id()) == Some(kind)));
    }

    #[test]
    fn json_round_trip_keeps_a_law() {
        let law = Outside {
            kind: Strange::WanderingStop,
            axle: 1,
            values: vec![1e-3, 2e5],
            events: vec![[1.0, 4.0, 1.0]],
        };
        let back = Outside::from_json(&law.to_json()).expect("read");
        assert_eq!((back.kind, back.axle), (law.kind, law.axle));
        assert_eq!((back.values, back.events), (law.values, law.events));
    }

    #[test]
    fn laws_have_the_forces_that_they_say() {
        let force = |kind, values: &[f64], d, w, s: &[f64]| {
            let law = Outside {
                kind,
                axle: 0,
                values: values.to_vec(),
                events: Vec::new(),
            };
            let c = Contact {
                d,
                w,
                k: 1e5,
                ..Contact::default()
            };
            law.force(&c, s, &mut [0.0; 4])
        };
        let near = |got: f64, expected: f64| {
            assert!((got - expected).abs() < 1e-6 * expected.abs().max(1.0));
        };
        // A dome pulls hardest one width before its centre, and not at all there.
        near(
            force(Strange::SnapDome, &[50.0, 2e-3, 1e-3], 1e-3, 0.0, &[]),
            50.0,
        );
        near(
            force(Strange::SnapDome, &[50.0, 2e-3, 1e-3], 2e-3, 0.0, &[]),
            0.0,
        );
        near(
            force(Strange::EddyDamping, &[1e3, 0.05], 0.0, 0.05, &[]),
            25.0,
        );
        near(
            force(Strange::DetentRipple, &[30.0, 4e-3], 1e-3, 0.0, &[]),
            30.0,
        );
        near(
            force(Strange::LoadFriction, &[0.2, 1e-3], -2e-3, 1.0, &[]),
            40.0,
        );
        near(
            force(Strange::SlackCable, &[1e3, 1e-3, 1e-3], 3e-3, 0.1, &[]),
            100.0,
        );
        near(
            force(Strange::SlackCable, &[1e3, 1e-3, 1e-3], 3e-3, -0.1, &[]),
            0.0,
        );
        near(
            force(Strange::BreakingBond, &[0.5, 1e-3, 9.0], 1e-3, 0.0, &[1.0]),
            0.0,
        );
        near(
            force(Strange::SlowFollower, &[0.5, 0.1, 1e-3], 3e-3, 0.0, &[1e-3]),
            100.0,
        );
    }
}
