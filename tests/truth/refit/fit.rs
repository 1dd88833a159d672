//! Output-error refit of a known structure on the first 60 % of a ride, judged on the rest: the plain model, and the oracle.

use super::levenberg::minimise;
use super::replay::Replay;
use crate::simulate::effect::Effect;
use crate::simulate::outside::Outside;
use crate::simulate::vehicle::{Bike, STATES, State, Vehicle};

/// Share of the ride that is fitted, the gap after it and what is left out at the start while the ride settles, s.
pub const FITTED: f64 = 0.6;
pub const GAP_S: f64 = 2.0;
const SETTLE_S: f64 = 1.0;
/// Weight of the prior that holds the initial state near the first samples (per mm and per 0.1 m/s): on a well damped ride the
/// fitted part has forgotten it, and without a prior it would wander off.
const PRIOR: f64 = 0.05;

/// A fitted (or known) vehicle and how well it predicts.
#[derive(Clone, Debug)]
pub struct Fit {
    pub vehicle: Vehicle,
    /// Root mean square error over the held-out part, m; zero on an axle that was not simulated.
    pub held_out_m: [f64; 2],
}

/// Samples of the fitted and of the held-out part.
pub struct Split {
    pub fitted: std::ops::Range<usize>,
    pub held_out: std::ops::Range<usize>,
}

impl Split {
    pub fn of(replay: &Replay) -> Self {
        let t = &replay.log.t;
        let end = replay.duration_s();
        let settled = if replay.rests() && replay.log.force[0].is_empty() {
            0.0
        } else {
            SETTLE_S
        };
        let index = |at: f64| t.partition_point(|&x| x < at);
        Self {
            fitted: index(settled)..index(FITTED * end),
            held_out: index(FITTED * end + GAP_S)..t.len(),
        }
    }
}

/// Which unknowns a fit may move beside the initial state and the rest point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Free {
    /// k, B and every parameter of the effects.
    All,
    /// Nothing: the vehicle is the truth.
    Nothing,
}

/// Refits `effects` (their values are the start) with k and B of the axles in `active`, from `start`.
/// `None` when the model cannot be simulated there.
pub fn refit(
    replay: &Replay,
    start: &Bike,
    effects: &[Effect],
    outside: Option<&Outside>,
    active: [bool; 2],
    free: Free,
) -> Option<Fit> {
    let split = Split::of(replay);
    let unknowns = Unknowns {
        replay,
        start,
        effects,
        outside,
        active,
        free,
    };
    let predict = |x: &[f64], range: &std::ops::Range<usize>| {
        let (vehicle, from) = unknowns.vehicle(x);
        let until = replay.log.t[range.end - 1] + 0.05;
        let simulated = if outside.is_some() {
            [true, true]
        } else {
            active
        };
        let motion = replay.simulate(&vehicle, from, simulated, until);
        let errors = |axle: usize| -> Vec<f64> {
            let model = replay.logged(&motion, &vehicle.effects, axle, range);
            model
                .iter()
                .zip(&replay.log.z[axle][range.clone()])
                .map(|(m, z)| 1e3 * (m - z))
                .collect()
        };
        [0, 1].map(|axle| {
            if active[axle] {
                errors(axle)
            } else {
                Vec::new()
            }
        })
    };
    let mut x = unknowns.start();
    // The first moment of a driven ride is forgotten long before the held-out part; that of a release is not.
    if free == Free::All || split.fitted.start == 0 {
        let begin = x.clone();
        let moments = unknowns.moments();
        let residual = |x: &[f64]| {
            let mut errors = predict(x, &split.fitted).concat();
            errors.extend(moments.iter().map(|&i| PRIOR * (x[i] - begin[i])));
            Some(errors)
        };
        (x, _) = minimise(&x, residual)?;
    }
    let held_out_m = predict(&x, &split.held_out)
        .map(|e| 1e-3 * (e.iter().map(|v| v * v).sum::<f64>() / e.len().max(1) as f64).sqrt());
    Some(Fit {
        vehicle: unknowns.vehicle(&x).0,
        held_out_m,
    })
}

/// The plain model at its best, each axle that the log has by itself, from the k and B of `start`.
pub fn plain(replay: &Replay, start: &Bike) -> Option<Fit> {
    let has = replay.log.has();
    let alone = |axle: usize| {
        let active = [axle == 0, axle == 1];
        has[axle].then(|| refit(replay, start, &[], None, active, Free::All))
    };
    match (alone(0), alone(1)) {
        (Some(front), Some(rear)) => Some(joined(front?, rear?)),
        (front, rear) => front.or(rear)?,
    }
}

fn joined(mut both: Fit, rear: Fit) -> Fit {
    both.vehicle.bike.stiffness_n_m[1] = rear.vehicle.bike.stiffness_n_m[1];
    both.vehicle.bike.damping_n_s_m[1] = rear.vehicle.bike.damping_n_s_m[1];
    both.held_out_m[1] = rear.held_out_m[1];
    both
}

/// The axles that effects touch.
pub fn touched(effects: &[Effect], outside: Option<&Outside>) -> [bool; 2] {
    [0, 1].map(|axle| {
        effects.iter().any(|e| e.axle.covers(axle)) || outside.is_some_and(|o| o.axle == axle)
    })
}

struct Unknowns<'a> {
    replay: &'a Replay,
    start: &'a Bike,
    effects: &'a [Effect],
    outside: Option<&'a Outside>,
    active: [bool; 2],
    free: Free,
}

impl Unknowns<'_> {
    /// Order per active axle: z0 (mm), z'0 (m/s / 10), rest force (of k x 1 mm) if the ground rests, ln k, ln B; then the effects' parameters.
    fn start(&self) -> Vec<f64> {
        let log = &self.replay.log;
        let mut x = Vec::new();
        for axle in self.axles() {
            let z = &log.z[axle];
            x.extend([
                1e3 * z[0],
                10.0 * (z[2.min(z.len() - 1)] - z[0]) / (log.t[2.min(z.len() - 1)] - log.t[0]),
            ]);
            if self.replay.rests() {
                x.push(0.0);
            }
            if self.free == Free::All {
                x.extend([0.0, 0.0]);
            }
        }
        if self.free == Free::All {
            x.extend(self.effects.iter().flat_map(free_parameters).map(|_| 0.0));
        }
        x
    }

    /// Places of the initial state among the unknowns.
    fn moments(&self) -> Vec<usize> {
        let per_axle =
            2 + usize::from(self.replay.rests()) + if self.free == Free::All { 2 } else { 0 };
        (0..self.axles().count())
            .flat_map(|n| [n * per_axle, n * per_axle + 1])
            .collect()
    }

    fn axles(&self) -> impl Iterator<Item = usize> + '_ {
        (0..2).filter(|&a| self.active[a])
    }

    fn vehicle(&self, x: &[f64]) -> (Vehicle, State) {
        let mut vehicle = Vehicle {
            effects: self.effects.to_vec(),
            outside: self.outside.cloned(),
            mean_speed_m_s: self.replay.mean_speed_m_s,
            ..Vehicle::plain(self.start.clone())
        };
        let mut state = [[0.0; STATES]; 2];
        let mut values = x.iter().copied();
        let mut next = || values.next().unwrap_or(0.0);
        for axle in self.axles() {
            let (z, rate) = (1e-3 * next(), 0.1 * next());
            state[axle][0] = z;
            state[axle][1] = rate;
            if self.replay.rests() {
                vehicle.rest_n[axle] = 1e-3 * self.start.stiffness_n_m[axle] * next();
            }
            if self.free == Free::All {
                vehicle.bike.stiffness_n_m[axle] *= next().clamp(-4.0, 4.0).exp();
                vehicle.bike.damping_n_s_m[axle] *= next().clamp(-6.0, 6.0).exp();
            }
            self.start_modes(&mut state[axle], axle);
        }
        if self.free == Free::All {
            for effect in &mut vehicle.effects {
                for (i, scale) in free_parameters(effect) {
                    effect.values[i] += scale * next();
                }
            }
        }
        (vehicle, state)
    }

    /// Second masses start with the first.
    fn start_modes(&self, state: &mut [f64; STATES], axle: usize) {
        let mut slot = 2;
        for e in self.effects.iter().filter(|e| e.axle.covers(axle)) {
            if e.kind.states() == 2 {
                state[slot] = state[0];
                state[slot + 1] = state[1];
            }
            slot += e.kind.states();
        }
    }
}

/// Index and scale of the parameters that a refit may move; windows and sides are known.
fn free_parameters(effect: &Effect) -> Vec<(usize, f64)> {
    let names = effect.kind.names().1;
    names
        .iter()
        .zip(&effect.values)
        .enumerate()
        .filter(|(_, (name, _))| !matches!(**name, "side" | "from" | "to"))
        .map(|(i, (name, value))| {
            let scale = match *name {
                "phase" => 1.0,
                "gain" => (value - 1.0).abs().max(0.01),
                "rolling_radius" => 0.01 * value.abs(),
                _ => value.abs().max(1e-12),
            };
            (i, scale)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::chance::Chance;
    use crate::simulate::drive::{Drive, STEP_S, Wave};
    use crate::simulate::effect::{Axle, Kind};
    use crate::simulate::integrate::integrate;
    use crate::simulate::sensors::{Log, Sensors};

    const DAMPING: f64 = 4000.0;

    /// Twenty seconds on a shaker plate with quadratic damping in front, white noise of 20 um.
    fn replay() -> Replay {
        let bike = Bike {
            mass_kg: [25.0, 60.0],
            arm_m: [0.75, 0.31],
            wheel_radius_m: [0.34; 2],
            stiffness_n_m: [8e4, 1e5],
            damping_n_s_m: [500.0, 700.0],
        };
        let chance = &mut Chance::new(9, 0);
        let lines = (0..40)
            .map(|i| {
                (
                    3e-3 / (1.0 + i as f64),
                    5.0 + 2.9 * i as f64,
                    chance.phase(),
                )
            })
            .collect();
        let wave = Wave::Multisine(lines);
        let mut drive = Drive::empty(0.0, STEP_S, (20.0 / STEP_S) as usize);
        (0..2).for_each(|axle| drive.shake_ground(axle, &wave));
        let effects = vec![Effect::new(Kind::QuadraticDamping, Axle::Front, &[DAMPING])];
        let vehicle = Vehicle {
            effects,
            ..Vehicle::plain(bike.clone())
        };
        let motion = integrate(
            &vehicle,
            &drive,
            [[0.0; STATES]; 2],
            [true; 2],
            f64::INFINITY,
        );
        let t: Vec<f64> = (0..2000).map(|i| 0.01 * i as f64).collect();
        let sensors = Sensors {
            white_m: 2e-5,
            ..Sensors::default()
        };
        let z = [0, 1].map(|axle| sensors.displacement(&motion, axle, &[], &t, &t, chance));
        let u = [0, 1].map(|_| t.iter().map(|&t| wave.at(t).0).collect());
        Replay::new(
            Log {
                t,
                u,
                z,
                ..Log::default()
            },
            bike,
            1e-3,
        )
    }

    #[test]
    fn a_refit_finds_the_truth_from_afar_and_the_plain_model_cannot() {
        let replay = replay();
        let start = Bike {
            stiffness_n_m: [1e5; 2],
            damping_n_s_m: [900.0; 2],
            ..replay.bike.clone()
        };
        let guess = [Effect::new(
            Kind::QuadraticDamping,
            Axle::Front,
            &[0.4 * DAMPING],
        )];
        let fit = refit(&replay, &start, &guess, None, [true, false], Free::All).unwrap();
        let found = [
            fit.vehicle.effects[0].values[0] / DAMPING,
            fit.vehicle.bike.stiffness_n_m[0] / 8e4,
        ];
        assert!(found.iter().all(|r| (r - 1.0).abs() < 0.02), "{found:?}");
        assert!(
            (fit.held_out_m[0] / 2e-5 - 1.0).abs() < 0.05,
            "{:?}",
            fit.held_out_m
        );
        let plain = plain(&replay, &start).unwrap();
        assert!(
            plain.held_out_m[0] > 1.5 * fit.held_out_m[0],
            "{:?}",
            plain.held_out_m
        );
        assert!(
            (plain.held_out_m[1] / 2e-5 - 1.0).abs() < 0.05,
            "{:?}",
            plain.held_out_m
        );
    }
}
