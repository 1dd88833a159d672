//! Physics that is NOT in the library: what the diagnosis must call `unnamed`.
//!
//! Each is an additional force on one axle's tyre or body, written so that no combination of one library effect and k, B reproduces it.

use serde_json::{Value, json};

use super::vehicle::Contact;

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
}

/// One strange law on one axle. `values` has the meaning that [`Outside::force`] gives it; `events` are
/// (from s, to s, size) for the laws that act in stretches.
#[derive(Clone, Debug)]
pub struct Outside {
    pub kind: Strange,
    pub axle: usize,
    pub values: Vec<f64>,
    pub events: Vec<[f64; 3]>,
}

impl Strange {
    pub const ALL: [Strange; 12] = [
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
        }
    }

    pub fn from_id(id: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|k| k.id() == id)
    }

    /// Needs distance or speed.
    pub fn needs_road(self) -> bool {
        matches!(self, Strange::ParametricWheel | Strange::LateralCoupling)
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

    /// Force on the axle mass (N, up), with the two internal states and their rates.
    pub fn force(&self, c: &Contact, inside: [f64; 2], rate: &mut [f64]) -> f64 {
        let p = &self.values;
        match self.kind {
            // c |w|^p sign(w), regular within 0.2 mm/s
            Strange::PowerDamping => p[0] * c.w * (c.w * c.w + 4e-8).powf((p[1] - 1.0) / 2.0),
            Strange::CubicDamping => p[0] * c.w.powi(3),
            // LuGre: kinetic force, breakaway force, Stribeck speed, presliding distance
            Strange::StribeckFriction => {
                let bristle = p[0] / p[3];
                let limit = p[0] + (p[1] - p[0]) * (-(c.w / p[2]).powi(2)).exp();
                rate[0] = c.w - bristle * c.w.abs() / limit * inside[0];
                bristle * inside[0]
            }
            // share of k, rolling radius, phase
            Strange::ParametricWheel => p[0] * c.k * (c.x / p[1] + p[2]).cos() * c.d,
            // extra mass, linear and cubic spring, damper
            Strange::HardeningFrameMode => {
                let (q, q_rate) = (inside[0] - c.z, inside[1] - c.z_rate);
                let pull = p[1] * q + p[2] * q.powi(3) + p[3] * q_rate;
                rate[0] = inside[1];
                rate[1] = -pull / p[0];
                pull
            }
            // half gap, contact stiffness, impact loss s/m, lag s
            Strange::ImpactBacklash => {
                let depth = (c.d.abs() - p[0]).max(0.0) * c.d.signum();
                let contact = p[1] * depth * (1.0 + p[2] * c.w * c.d.signum()).max(0.0);
                rate[0] = (contact - inside[0]) / p[3];
                inside[0]
            }
            // loss of k per unit heat, typical rate m/s, time constant s
            Strange::ThermalSoftening => {
                rate[0] = ((c.w / p[1]).powi(2) - inside[0]) / p[2];
                -c.k * c.d * (p[0] * inside[0]).min(0.8)
            }
            Strange::PostureBursts => self.event(c.t).map_or(0.0, |&[from, to, size]| {
                size * (std::f64::consts::PI * (c.t - from) / (to - from)).sin()
            }),
            Strange::LateralCoupling => p[0] * c.speed * c.other_d,
            Strange::DampingSteps => self.event(c.t).map_or(0.0, |e| e[2] * c.b * c.w),
            // strength N m^2, gap m
            Strange::MagneticRepulsion => {
                let left = (p[1] - c.d).max(0.15 * p[1]);
                p[0] * (left.powi(-2) - p[1].powi(-2))
            }
            // damping, deflection scale
            Strange::PositionDamping => p[0] * c.w * (c.d / p[1]).tanh(),
        }
    }
}
