//! The extended model as it is simulated: every number and every law that its held-out error comes from.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use veloid_core::bicycle::PerAxle;

/// All that simulates the extended model along the ride, from its first sample to its last: the classical Runge-Kutta method of fourth
/// order, the road and the force as cubic splines through their samples (not-a-knot), lifted as docs/decisions/lifted-inputs.md says where the model moves, speed, distance, crank angle and the rate of the
/// speed as straight lines between them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Simulation {
    /// Sample interval (s) of the ride as it was diagnosed, which may be longer than the file's.
    pub step_s: f64,
    /// Number of its samples.
    pub samples: usize,
    /// The held-out part: its first sample, and the one after its last, counted from 0.
    pub held_out: [usize; 2],
    /// The model of each axle.
    pub axles: PerAxle<AxleSimulation>,
    /// How the axles push each other, where `pitch_coupling` is among the effects.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pitch: Option<Pitch>,
}

/// Two axles whose accelerations a rigid body couples: with F = m z'' of each axle by itself, M = m_F + m_R and
/// `coupling` q, z_F'' = F_F (1/M + (1 + q) l_F/(l_R M)) - F_R q/M, and z_R'' likewise.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Pitch {
    /// q = m l_F l_R / I - 1 with the pitch inertia I.
    pub coupling: f64,
    /// Distance from the centre of gravity to the front wheel (m).
    pub l_front_m: f64,
    /// Distance from the centre of gravity to the rear wheel (m).
    pub l_rear_m: f64,
    /// Mass (kg) of the front axle in the equations above.
    pub mass_front_kg: f64,
    /// Mass (kg) of the rear axle.
    pub mass_rear_kg: f64,
}

/// One axle's model. With d = u - z + `rest_m` and w = u' - z' (u and u' less the height and the velocity of what stands on the tyre,
/// where an effect's `on_tyre` says so), m z'' = k d + B w + F + `constant_n` - k `rest_m` + the effects.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct AxleSimulation {
    /// Whether the motion is prescribed: z = z' = 0, u is the logged deflection, and what is predicted is the force (N) m z'', with a mass
    /// of 1 kg; else z (m) is predicted.
    pub prescribed: bool,
    /// Mass m (kg).
    pub mass_kg: f64,
    /// Stiffness k (N/m).
    pub k_n_m: f64,
    /// Damping B (N s/m).
    pub b_n_s_m: f64,
    /// Constant force on the mass (N): the rest point of a bench.
    pub constant_n: f64,
    /// What comes to the deflection (m), so that laws count from where the axle rests.
    pub rest_m: f64,
    /// Height z at the first sample (m).
    pub height_m: f64,
    /// Velocity z' at the first sample (m/s).
    pub velocity_m_s: f64,
    /// Steps of the integrator in each sample interval.
    pub steps: usize,
    /// Whether a road moves below the axle; else u = 0.
    pub road: bool,
    /// Whether a force F is applied to the mass.
    pub force: bool,
    /// The effects, in the order in which they act.
    pub effects: Vec<ActingEffect>,
    /// Samples of the held-out part that are not to be trusted and do not count, as stretches: from, and the one after the last.
    pub left_out: Vec<[usize; 2]>,
    /// RMS (m or N) of what was measured on the held-out samples that count, about zero: shows whether a table is the ride.
    pub measured_rms: f64,
}

/// An effect as it is simulated.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct ActingEffect {
    /// Id in the library, or that of the user's own law.
    pub id: String,
    /// Every number that its law names, in SI units: the parameters as the fit moves them, and sizes of the ride.
    pub numbers: BTreeMap<String, f64>,
    /// What it does.
    pub law: Law,
    /// Where its states start (SI units), in the order of `law.states`.
    pub initial: Vec<f64>,
    /// Whether its states are height and velocity of a mass that stands on the tyre and carries the axle's mass: the tyre's force acts
    /// on that, and the axle's mass has none of it.
    #[serde(default)]
    pub on_tyre: bool,
}

/// What an effect does, as expressions in the language of docs/own-law.md, which has d, w, z, z_dot, speed, t, crank and wheel. Further
/// names: k, B and m of the axle; `tyre`, the tyre's force so far (N); `acceleration`, the mass's so far (m/s^2); `speed_rate`
/// (m/s^2) and `distance` (m); `dt`, the integrator's step (s), and `felt_after`, the same, or 0 where the motion is prescribed.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
#[serde(default)]
pub struct Law {
    /// What comes to the tyre's force (N).
    #[serde(skip_serializing_if = "String::is_empty")]
    pub tyre: String,
    /// What comes to the other forces on the mass (N).
    #[serde(skip_serializing_if = "String::is_empty")]
    pub body: String,
    /// The mass's acceleration (m/s^2), in the place of `acceleration`.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub acceleration: String,
    /// States of its own, each with its rate.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub states: Vec<LawState>,
    /// How much earlier the road is read (s). This and the next three are taken at the samples, between which the road is then a cubic
    /// with these heights and rates.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub shift: String,
    /// The road is averaged over this time (s) to both sides; less near the ends of the record, beyond which the road stays as it is.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub half_window: String,
    /// What comes to the road's height (m).
    #[serde(skip_serializing_if = "String::is_empty")]
    pub height: String,
    /// What comes to the road's rate (m/s).
    #[serde(skip_serializing_if = "String::is_empty")]
    pub slope: String,
    /// How much earlier the sensor reads the motion (s): at samples z, between them quintics that have z, z' and z'' there.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub delay: String,
    /// What the sensor multiplies its reading by.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub gain: String,
    /// What the sensor adds to that (m).
    #[serde(skip_serializing_if = "String::is_empty")]
    pub offset: String,
    /// Time constant (s) with which the reading follows that.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub lag: String,
}

/// A state of an effect.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct LawState {
    /// As the law's expressions call it.
    pub name: String,
    /// Its rate for each second.
    pub rate: String,
}

impl Law {
    /// Every expression in it.
    pub fn expressions(&self) -> impl Iterator<Item = &str> {
        let rates = self.states.iter().map(|state| state.rate.as_str());
        [
            &self.tyre,
            &self.body,
            &self.acceleration,
            &self.shift,
            &self.half_window,
            &self.height,
            &self.slope,
            &self.delay,
            &self.gain,
            &self.offset,
            &self.lag,
        ]
        .into_iter()
        .map(String::as_str)
        .chain(rates)
        .filter(|text| !text.is_empty())
    }
}

/// Names that an expression speaks of, functions among them.
pub fn names(expression: &str) -> impl Iterator<Item = &str> {
    let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '.';
    expression
        .split(move |c| !is_word(c))
        .filter(|word| word.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_'))
}
