//! What drives the vehicle, tabulated every half step: road under each wheel, forces, speed, cranks.

use super::effect::{Effect, Kind};
use super::road::Road;
use super::speed::Profile;

/// Integration step, s (4 kHz).
pub const STEP_S: f64 = 1.0 / 4000.0;

/// A smooth wave of time: sines, or one sine whose frequency swings.
#[derive(Clone, Debug)]
pub enum Wave {
    /// (amplitude, angular frequency rad/s, phase rad)
    Multisine(Vec<(f64, f64, f64)>),
    /// Frequency swings as middle + swing sin(2 pi t / period), Hz.
    Sweep {
        amplitude: f64,
        middle_hz: f64,
        swing_hz: f64,
        period_s: f64,
    },
}

impl Wave {
    /// Value and rate at `t`.
    pub fn at(&self, t: f64) -> (f64, f64) {
        match self {
            Wave::Multisine(lines) => lines.iter().fold((0.0, 0.0), |(v, r), &(a, w, p)| {
                let (s, c) = (w * t + p).sin_cos();
                (v + a * s, r + a * w * c)
            }),
            Wave::Sweep {
                amplitude,
                middle_hz,
                swing_hz,
                period_s,
            } => {
                let tau = std::f64::consts::TAU;
                let turn = tau * t / period_s;
                let phase = tau * middle_hz * t - swing_hz * period_s * turn.cos();
                (
                    amplitude * phase.sin(),
                    amplitude * phase.cos() * tau * (middle_hz + swing_hz * turn.sin()),
                )
            }
        }
    }

    /// Values and rates every `step_s` from `start_s`; the phasors of a multisine are turned from point to point.
    fn table(&self, start_s: f64, step_s: f64, len: usize) -> (Vec<f64>, Vec<f64>) {
        let Wave::Multisine(lines) = self else {
            return (0..len)
                .map(|i| self.at(start_s + i as f64 * step_s))
                .unzip();
        };
        let (mut value, mut rate) = (vec![0.0; len], vec![0.0; len]);
        for &(amplitude, omega, phase) in lines {
            let (turn_s, turn_c) = (omega * step_s).sin_cos();
            let (mut s, mut c) = (omega * start_s + phase).sin_cos();
            for (v, r) in value.iter_mut().zip(&mut rate) {
                *v += amplitude * s;
                *r += amplitude * omega * c;
                (s, c) = (s * turn_c + c * turn_s, c * turn_c - s * turn_s);
            }
        }
        (value, rate)
    }

    pub fn scale(&mut self, factor: f64) {
        match self {
            Wave::Multisine(lines) => lines.iter_mut().for_each(|l| l.0 *= factor),
            Wave::Sweep { amplitude, .. } => *amplitude *= factor,
        }
    }
}

/// Values at one half-step.
#[derive(Clone, Copy, Debug, Default)]
pub struct Moment {
    pub t: f64,
    pub road: [f64; 2],
    pub road_rate: [f64; 2],
    pub force: [f64; 2],
    pub speed: f64,
    pub acceleration: f64,
    pub distance: f64,
    pub crank: f64,
}

/// Speed, acceleration, distance (0 at t = 0) and crank angle (0 at t = 0) every half step.
#[derive(Clone, Debug, Default)]
pub struct Travel {
    pub speed: Vec<f64>,
    pub acceleration: Vec<f64>,
    pub distance: Vec<f64>,
    pub crank: Vec<f64>,
}

impl Travel {
    pub fn new(
        speed: &Profile,
        cadence_rpm: &Profile,
        start_s: f64,
        half_s: f64,
        len: usize,
    ) -> Self {
        let table = |f: &dyn Fn(f64) -> f64| -> Vec<f64> {
            (0..len).map(|i| f(start_s + i as f64 * half_s)).collect()
        };
        let per_rpm = std::f64::consts::TAU / 60.0;
        let acceleration = table(&|t| speed.rate(t));
        let speed = table(&|t| speed.value(t));
        let crank_rate = table(&|t| per_rpm * cadence_rpm.value(t));
        let crank_change = table(&|t| per_rpm * cadence_rpm.rate(t));
        let zero = ((-start_s / half_s).round().max(0.0) as usize).min(len - 1);
        Self {
            distance: cumulative(&speed, &acceleration, half_s, zero),
            crank: cumulative(&crank_rate, &crank_change, half_s, zero),
            speed,
            acceleration,
        }
    }
}

/// Integral, 0 at the index `zero`, by the trapezium with end correction (fourth order).
pub fn cumulative(value: &[f64], rate: &[f64], h: f64, zero: usize) -> Vec<f64> {
    let mut sum = vec![0.0; value.len()];
    for i in 1..value.len() {
        sum[i] = sum[i - 1]
            + h / 2.0 * (value[i - 1] + value[i])
            + h * h / 12.0 * (rate[i - 1] - rate[i]);
    }
    let origin = sum[zero];
    sum.iter_mut().for_each(|x| *x -= origin);
    sum
}

/// Inputs on the half-step grid; an empty table is zero everywhere.
#[derive(Clone, Debug, Default)]
pub struct Drive {
    pub start_s: f64,
    pub half_s: f64,
    pub road: [Vec<f64>; 2],
    pub road_rate: [Vec<f64>; 2],
    pub force: [Vec<f64>; 2],
    pub travel: Travel,
    len: usize,
}

impl Drive {
    /// A grid of `2 steps + 1` half steps from `start_s`, with nothing on it.
    pub fn empty(start_s: f64, step_s: f64, steps: usize) -> Self {
        Self {
            start_s,
            half_s: step_s / 2.0,
            len: 2 * steps + 1,
            ..Self::default()
        }
    }

    /// Lets each wheel ride its road, `behind_m` behind the distance ridden, as the effects of the input change it.
    pub fn ride(&mut self, roads: [&Road; 2], behind_m: [f64; 2], effects: &[Effect]) {
        for axle in 0..2 {
            let input = WheelInput::new(axle, effects);
            let (mut u, mut rate) = (Vec::with_capacity(self.len), Vec::with_capacity(self.len));
            for i in 0..self.len {
                let (h, s) = input.at(roads[axle], self.travel.distance[i], behind_m[axle]);
                u.push(h);
                rate.push(s * self.travel.speed[i]);
            }
            self.road[axle] = u;
            self.road_rate[axle] = rate;
        }
    }

    /// Moves the ground under a wheel by a wave.
    pub fn shake_ground(&mut self, axle: usize, wave: &Wave) {
        (self.road[axle], self.road_rate[axle]) = wave.table(self.start_s, self.half_s, self.len);
    }

    /// Pushes an axle mass with a wave of force.
    pub fn push(&mut self, axle: usize, wave: &Wave) {
        self.force[axle] = wave.table(self.start_s, self.half_s, self.len).0;
    }

    pub fn time(&self, i: usize) -> f64 {
        self.start_s + i as f64 * self.half_s
    }

    /// Number of half-step points.
    pub fn len(&self) -> usize {
        self.len
    }

    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    pub fn at(&self, i: usize) -> Moment {
        let get = |v: &Vec<f64>| v.get(i).copied().unwrap_or(0.0);
        Moment {
            t: self.time(i),
            road: [get(&self.road[0]), get(&self.road[1])],
            road_rate: [get(&self.road_rate[0]), get(&self.road_rate[1])],
            force: [get(&self.force[0]), get(&self.force[1])],
            speed: get(&self.travel.speed),
            acceleration: get(&self.travel.acceleration),
            distance: get(&self.travel.distance),
            crank: get(&self.travel.crank),
        }
    }
}

/// How effects change what one wheel meets.
#[derive(Clone, Copy, Default)]
struct WheelInput {
    patch_m: f64,
    shift_m: f64,
    /// amplitude, phase, rolling radius
    run_out: Option<[f64; 3]>,
}

impl WheelInput {
    fn new(axle: usize, effects: &[Effect]) -> Self {
        let mut input = Self::default();
        for e in effects.iter().filter(|e| e.axle.covers(axle)) {
            match e.kind {
                Kind::TyreEnveloping => input.patch_m = e.values[0],
                Kind::WheelbaseDelay => input.shift_m = e.values[0],
                Kind::WheelOutOfRound => {
                    input.run_out = Some([e.values[0], e.values[1], e.values[2]])
                }
                _ => {}
            }
        }
        input
    }

    /// Height and its change per metre ridden.
    fn at(&self, road: &Road, distance: f64, behind: f64) -> (f64, f64) {
        let x = distance - behind - self.shift_m;
        let (mut height, mut slope) = if self.patch_m > 0.0 {
            let (a, b) = (x - self.patch_m / 2.0, x + self.patch_m / 2.0);
            (
                (road.integral(b) - road.integral(a)) / self.patch_m,
                (road.height(b) - road.height(a)) / self.patch_m,
            )
        } else {
            (road.height(x), road.slope(x))
        };
        if let Some([amplitude, phase, radius]) = self.run_out {
            let (s, c) = (distance / radius + phase).sin_cos();
            height += amplitude * s;
            slope += amplitude * c / radius;
        }
        (height, slope)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_the_wave() {
        let wave = Wave::Multisine(vec![(1.0, 30.0, 0.4), (0.5, 90.0, 2.0)]);
        let (value, rate) = wave.table(-2.0, 1.25e-4, 500_000);
        for i in (0..500_000).step_by(4999) {
            let (v, r) = wave.at(-2.0 + i as f64 * 1.25e-4);
            assert!(
                (value[i] - v).abs() < 1e-8 && (rate[i] - r).abs() < 1e-6,
                "point {i}"
            );
        }
    }
}
