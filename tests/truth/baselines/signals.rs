//! The series of one axle from which regressors are made: differentiated from the log, or simulated by the plain model.

use crate::refit::fit::plain;
use crate::refit::replay::Replay;
use crate::refit::spline::Spline;
use crate::simulate::sensors::Log;
use crate::simulate::vehicle::{Bike, STATES};

/// Half widths of the local cubic that differentiates, samples.
pub const WIDTHS: [i64; 4] = [3, 4, 6, 9];
/// Samples dropped at both ends.
const EDGE: usize = 60;

/// One axle, SI; every series has the same length. Empty where the ride has no such channel.
#[derive(Clone, Debug, Default)]
pub struct Signals {
    pub axle: usize,
    pub mass_kg: f64,
    pub radius_m: f64,
    /// Estimates from the plain model.
    pub k: f64,
    pub b: f64,
    pub t: Vec<f64>,
    pub dt: f64,
    pub u: Vec<f64>,
    pub u_rate: Vec<f64>,
    pub u_bend: Vec<f64>,
    pub z: Vec<f64>,
    pub z_rate: Vec<f64>,
    pub z_bend: Vec<f64>,
    pub force: Vec<f64>,
    pub v: Vec<f64>,
    pub v_rate: Vec<f64>,
    pub crank: Vec<f64>,
    /// Tyre force of the other axle by the plain model.
    pub other: Vec<f64>,
    /// Measured z minus simulated z; empty when the series are measured.
    pub residual: Vec<f64>,
}

impl Signals {
    pub fn deflection(&self) -> Vec<f64> {
        self.u.iter().zip(&self.z).map(|(u, z)| u - z).collect()
    }

    pub fn rate(&self) -> Vec<f64> {
        self.u_rate
            .iter()
            .zip(&self.z_rate)
            .map(|(u, z)| u - z)
            .collect()
    }
}

/// Value, first and second derivative by a local cubic (Savitzky-Golay).
fn local_cubic(y: &[f64], dt: f64, half: i64) -> [Vec<f64>; 3] {
    let (mut s0, mut s2, mut s4, mut s6) = (0.0, 0.0, 0.0, 0.0);
    for j in -half..=half {
        let x = (j * j) as f64;
        (s0, s2, s4, s6) = (s0 + 1.0, s2 + x, s4 + x * x, s6 + x * x * x);
    }
    let mut out = [0, 1, 2].map(|_| vec![0.0; y.len()]);
    for i in half as usize..y.len().saturating_sub(half as usize) {
        let mut p = [0.0; 4];
        for j in -half..=half {
            let v = y[(i as i64 + j) as usize];
            let x = j as f64;
            p = [
                p[0] + v,
                p[1] + x * v,
                p[2] + x * x * v,
                p[3] + x * x * x * v,
            ];
        }
        let even = s0 * s4 - s2 * s2;
        let odd = s2 * s6 - s4 * s4;
        out[0][i] = (p[0] * s4 - p[2] * s2) / even;
        out[1][i] = (p[1] * s6 - p[3] * s4) / odd / dt;
        out[2][i] = 2.0 * (p[2] * s0 - p[0] * s2) / even / (dt * dt);
    }
    out
}

/// Series differentiated from the log.
pub fn differentiated(log: &Log, bike: &Bike, half: i64) -> [Signals; 2] {
    let n = log.t.len();
    let dt = (log.t[n - 1] - log.t[0]) / (n - 1) as f64;
    let zero = vec![0.0; n];
    let fill = |v: &Vec<f64>| {
        if v.is_empty() {
            zero.clone()
        } else {
            v.clone()
        }
    };
    let axles = [0, 1].map(|axle| {
        let [z, z_rate, z_bend] = local_cubic(&log.z[axle], dt, half);
        let [u, u_rate, u_bend] = local_cubic(&fill(&log.u[axle]), dt, half);
        let mut s = Signals {
            axle,
            mass_kg: bike.mass_kg[axle],
            radius_m: bike.wheel_radius_m[axle],
            t: log.t.clone(),
            dt,
            u,
            u_rate,
            u_bend,
            z,
            z_rate,
            z_bend,
            force: fill(&log.force[axle]),
            ..Signals::default()
        };
        channels(&mut s, log);
        s
    });
    axles.map(trimmed)
}

/// Series of the plain model at its best, with the residual. `first` holds k and B to start from.
pub fn simulated(replay: &Replay, first: [(f64, f64); 2]) -> Option<[Signals; 2]> {
    let start = Bike {
        stiffness_n_m: first.map(|(k, _)| k.clamp(3e4, 3e5)),
        damping_n_s_m: first.map(|(_, b)| b.clamp(5.0, 2e3)),
        ..replay.bike.clone()
    };
    let vehicle = plain(replay, &start)?.vehicle;
    let log = &replay.log;
    let mut state = [[0.0; STATES]; 2];
    for (axle, own) in state.iter_mut().enumerate() {
        own[0] = log.z[axle][0];
    }
    let motion = replay.simulate(&vehicle, state, [true, true], f64::INFINITY);
    let mut axles = differentiated_whole(log, &replay.bike);
    for (axle, s) in axles.iter_mut().enumerate() {
        (s.k, s.b) = (
            vehicle.bike.stiffness_n_m[axle],
            vehicle.bike.damping_n_s_m[axle],
        );
        let road = (!log.u[axle].is_empty()).then(|| Spline::new(&log.t, &log.u[axle]));
        for i in 0..s.t.len() {
            let at = ((s.t[i] / motion.step_s).round() as usize).min(motion.z[axle].len() - 1);
            (s.u[i], s.u_rate[i]) = road.as_ref().map_or((0.0, 0.0), |r| r.at(s.t[i]));
            (s.z[i], s.z_rate[i]) = (motion.z[axle][at], motion.z_rate[axle][at]);
            s.z_bend[i] =
                (s.k * (s.u[i] - s.z[i]) + s.b * (s.u_rate[i] - s.z_rate[i]) + s.force[i])
                    / s.mass_kg;
        }
        s.residual = log.z[axle].iter().zip(&s.z).map(|(y, z)| y - z).collect();
    }
    let plain = [0, 1].map(|a| (axles[a].k, axles[a].b));
    couple(&mut axles, plain);
    Some(axles.map(trimmed))
}

fn differentiated_whole(log: &Log, bike: &Bike) -> [Signals; 2] {
    let n = log.t.len();
    let dt = (log.t[n - 1] - log.t[0]) / (n - 1) as f64;
    [0, 1].map(|axle| {
        let zero = || vec![0.0; n];
        let u_bend = if log.u[axle].is_empty() {
            zero()
        } else {
            local_cubic(&log.u[axle], dt, WIDTHS[1])[2].clone()
        };
        let mut s = Signals {
            axle,
            mass_kg: bike.mass_kg[axle],
            radius_m: bike.wheel_radius_m[axle],
            t: log.t.clone(),
            dt,
            u: zero(),
            u_rate: zero(),
            u_bend,
            z: zero(),
            z_rate: zero(),
            z_bend: zero(),
            force: if log.force[axle].is_empty() {
                zero()
            } else {
                log.force[axle].clone()
            },
            ..Signals::default()
        };
        channels(&mut s, log);
        s
    })
}

/// Speed, its rate (local quadratic over half a second, as two moving means) and crank angle.
fn channels(s: &mut Signals, log: &Log) {
    if !log.v.is_empty() {
        let half = (0.25 / s.dt) as usize;
        s.v = mean(&mean(&log.v, half), half);
        let n = s.v.len();
        s.v_rate = (0..n)
            .map(|i| {
                let (a, b) = (i.saturating_sub(1), (i + 1).min(n - 1));
                (s.v[b] - s.v[a]) / ((b - a).max(1) as f64 * s.dt)
            })
            .collect();
    }
    let mut angle = 0.0;
    s.crank = log
        .cadence
        .iter()
        .map(|rpm| {
            angle += rpm * std::f64::consts::TAU / 60.0 * s.dt;
            angle
        })
        .collect();
}

fn mean(y: &[f64], half: usize) -> Vec<f64> {
    (0..y.len())
        .map(|i| {
            let window = &y[i.saturating_sub(half)..(i + half + 1).min(y.len())];
            window.iter().sum::<f64>() / window.len() as f64
        })
        .collect()
}

/// Gives each axle the other's tyre force, from k and B of both.
pub fn couple(axles: &mut [Signals; 2], plain: [(f64, f64); 2]) {
    let force = [0, 1].map(|a| {
        let (k, b) = plain[a];
        axles[a]
            .deflection()
            .iter()
            .zip(axles[a].rate())
            .map(|(d, w)| k * d + b * w)
            .collect::<Vec<f64>>()
    });
    let [front, rear] = force;
    (axles[0].other, axles[1].other) = (rear, front);
}

/// Without the ends, where derivatives and the initial state are unsure.
fn trimmed(mut s: Signals) -> Signals {
    for series in [
        &mut s.t,
        &mut s.u,
        &mut s.u_rate,
        &mut s.u_bend,
        &mut s.z,
        &mut s.z_rate,
        &mut s.z_bend,
        &mut s.force,
        &mut s.v,
        &mut s.v_rate,
        &mut s.crank,
        &mut s.other,
        &mut s.residual,
    ] {
        if series.len() > 2 * EDGE {
            series.truncate(series.len() - EDGE);
            series.drain(..EDGE);
        }
    }
    s
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_local_cubic_is_exact_on_cubics() {
        let y: Vec<f64> = (0..40).map(|i| (0.1 * i as f64).powi(3)).collect();
        let [v, d, dd] = local_cubic(&y, 0.1, 4);
        for i in 4..36 {
            let t = 0.1 * i as f64;
            assert!((v[i] - t.powi(3)).abs() < 1e-9);
            assert!((d[i] - 3.0 * t * t).abs() < 1e-8);
            assert!((dd[i] - 6.0 * t).abs() < 1e-6);
        }
    }
}
