//! Regressors of every library effect: the derivative of the axle's force (or of the logged z) with respect to its size.

use super::signals::Signals;
use crate::simulate::effect::{Axle, Kind};

/// What a column adds to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Adds {
    /// Force on the axle mass, up to a factor.
    Force,
    /// The logged z itself.
    Output,
}

/// Candidate columns of one effect; where the effect has inner parameters there are several candidates of the same kind.
#[derive(Clone, Debug)]
pub struct Group {
    pub kind: Kind,
    pub adds: Adds,
    pub columns: Vec<Vec<f64>>,
}

impl Group {
    pub fn name(&self, axle: usize) -> (String, String) {
        let at = match self.kind.axles() {
            [Axle::Both] => "both",
            _ if axle == 0 => "front",
            _ => "rear",
        };
        (self.kind.id().to_owned(), at.to_owned())
    }
}

/// All candidates for one axle. `output` asks for the sensor effects as additions to z (output error) and not to the force.
pub fn groups(s: &Signals, output: bool) -> Vec<Group> {
    let mut list = Vec::new();
    let mut add = |kind, columns| {
        list.push(Group {
            kind,
            adds: Adds::Force,
            columns,
        })
    };
    let n = s.t.len();
    let (d, w) = (s.deflection(), s.rate());
    let each = |f: &dyn Fn(usize) -> f64| -> Vec<f64> { (0..n).map(f).collect() };
    let rms = |y: &[f64]| (y.iter().map(|v| v * v).sum::<f64>() / n as f64).sqrt();
    let (sigma, slip) = (rms(&d), 5e-3);
    let span = s.t[n - 1] - s.t[0];

    add(Kind::CubicStiffness, vec![each(&|i| d[i].powi(3))]);
    add(Kind::ProgressiveStiffness, vec![each(&|i| d[i] * d[i])]);
    add(Kind::QuadraticDamping, vec![each(&|i| w[i] * w[i].abs())]);
    add(Kind::AsymmetricDamping, vec![each(&|i| w[i].abs())]);
    add(Kind::CoulombFriction, vec![each(&|i| (w[i] / slip).tanh())]);
    for share in [0.4, 0.8] {
        add(
            Kind::Hysteresis,
            vec![lag(&w, s.dt, |f, w| w - w.abs() * f / (share * sigma))],
        );
    }
    for tau in [0.015, 0.035, 0.08] {
        add(
            Kind::ViscoelasticTyre,
            vec![lag(&w, s.dt, |f, w| w - f / tau)],
        );
    }
    for gap in [1.2, 1.6, 2.0].map(|share| share * sigma) {
        let (up, down) = (
            each(&|i| (d[i] - gap).max(0.0)),
            each(&|i| (d[i] + gap).min(0.0)),
        );
        add(
            Kind::BumpStop,
            vec![up.iter().zip(&down).map(|(a, b)| a + b).collect()],
        );
        add(Kind::BumpStop, vec![up]);
        add(Kind::BumpStop, vec![down]);
    }
    for half in [0.2, 0.4, 0.7].map(|share| share * sigma) {
        add(Kind::FreePlay, vec![each(&|i| d[i].clamp(-half, half))]);
    }
    for f in [4.0, 5.0, 6.0] {
        add(Kind::SprungMass, vec![second_mass(s, f)]);
    }
    if s.u.iter().any(|u| *u != 0.0) {
        add(Kind::UnsprungMass, vec![s.u_bend.clone()]);
        add(Kind::GroundDamping, vec![s.z_rate.clone()]);
        add(
            Kind::GuideFriction,
            vec![each(&|i| (s.z_rate[i] / slip).tanh())],
        );
        let lifted = |i: usize| (-(s.k * d[i] + s.b * w[i]) - 9.81 * s.mass_kg).max(0.0);
        add(Kind::WheelLift, vec![each(&lifted)]);
    }
    add(Kind::PitchCoupling, vec![s.other.clone()]);
    add(Kind::StiffnessDrift, vec![each(&|i| s.t[i] * d[i])]);
    for from in [0.2, 0.3, 0.4].map(|share| s.t[0] + share * span) {
        add(
            Kind::MassStep,
            vec![each(&|i| {
                if s.t[i] > from {
                    s.k * d[i] + s.b * w[i]
                } else {
                    0.0
                }
            })],
        );
    }
    if !s.v.is_empty() {
        speed_groups(s, &d, &w, &mut add);
    }
    if !s.crank.is_empty() {
        add(
            Kind::PedallingForce,
            vec![
                each(&|i| (2.0 * s.crank[i]).sin()),
                each(&|i| (2.0 * s.crank[i]).cos()),
            ],
        );
    }
    sensor_groups(s, output, &mut list);
    list.retain(|g| g.columns.iter().all(|c| rms(c) > 0.0));
    list
}

fn speed_groups(s: &Signals, d: &[f64], w: &[f64], add: &mut impl FnMut(Kind, Vec<Vec<f64>>)) {
    let n = s.t.len();
    let each = |f: &dyn Fn(usize) -> f64| -> Vec<f64> { (0..n).map(f).collect() };
    let mean = s.v.iter().sum::<f64>() / n as f64;
    add(Kind::LoadTransfer, vec![s.v_rate.clone()]);
    add(
        Kind::SpeedDependentStiffness,
        vec![each(&|i| (s.v[i] - mean) * d[i])],
    );
    add(
        Kind::SpeedDependentDamping,
        vec![each(&|i| (5.0 / s.v[i].max(0.5) - 1.0) * w[i])],
    );
    let bend = each(&|i| s.u_bend[i] / s.v[i].max(0.5).powi(2));
    add(Kind::TyreEnveloping, vec![through_tyre(s, &bend)]);
    if s.axle == 1 {
        add(
            Kind::WheelbaseDelay,
            vec![through_tyre(s, &each(&|i| s.u_rate[i] / s.v[i].max(0.5)))],
        );
    }
    let mut x = 0.0;
    let distance: Vec<f64> =
        s.v.iter()
            .map(|v| {
                x += v * s.dt;
                x
            })
            .collect();
    for radius in [-0.02, -0.01, 0.0, 0.01, 0.02].map(|e| s.radius_m * (1.0 + e)) {
        let wave = |f: fn(f64) -> f64| through_tyre(s, &each(&|i| f(distance[i] / radius)));
        add(Kind::WheelOutOfRound, vec![wave(f64::sin), wave(f64::cos)]);
    }
}

/// Sensor effects: on z itself, or as the force that would do the same.
fn sensor_groups(s: &Signals, output: bool, list: &mut Vec<Group>) {
    let n = s.t.len();
    let (adds, delay, gain) = if output {
        (Adds::Output, s.z_rate.clone(), s.z.clone())
    } else {
        (
            Adds::Force,
            through_tyre(s, &s.u_rate),
            through_tyre(s, &s.u),
        )
    };
    let pushed: Vec<f64> = if output {
        vec![0.0; n]
    } else {
        s.force.clone()
    };
    let gain = gain.iter().zip(&pushed).map(|(g, f)| g + f).collect();
    for (kind, column) in [
        (Kind::SensorDelay, delay),
        (Kind::SensorGain, gain),
        (Kind::SensorOffset, vec![1.0; n]),
        (Kind::SensorDrift, s.t.clone()),
    ] {
        list.push(Group {
            kind,
            adds,
            columns: vec![column],
        });
    }
}

/// Force of a change of the road: k e + B e'.
fn through_tyre(s: &Signals, e: &[f64]) -> Vec<f64> {
    let n = e.len();
    (0..n)
        .map(|i| {
            let (a, b) = (i.saturating_sub(1), (i + 1).min(n - 1));
            s.k * e[i] + s.b * (e[b] - e[a]) / ((b - a).max(1) as f64 * s.dt)
        })
        .collect()
}

/// Integrates f' = law(f, w) with ten substeps per sample, w linear between samples.
fn lag(w: &[f64], dt: f64, law: impl Fn(f64, f64) -> f64) -> Vec<f64> {
    let mut f = 0.0;
    let mut out = Vec::with_capacity(w.len());
    for i in 0..w.len() {
        out.push(f);
        let next = w[(i + 1).min(w.len() - 1)];
        for sub in 0..10 {
            let at = w[i] + (next - w[i]) * (sub as f64 + 0.5) / 10.0;
            f += dt / 10.0 * law(f, at);
        }
    }
    out
}

/// Acceleration of a mass on the axle, on a spring of `f` Hz with damping ratio 0.3, relative to the axle.
fn second_mass(s: &Signals, f: f64) -> Vec<f64> {
    let (omega, zeta) = (std::f64::consts::TAU * f, 0.3);
    let (mut q, mut q_rate) = (0.0, 0.0);
    s.z_bend
        .iter()
        .map(|a| {
            let bend = -a - omega * omega * q - 2.0 * zeta * omega * q_rate;
            q_rate += s.dt * bend;
            q += s.dt * q_rate;
            bend
        })
        .collect()
}
