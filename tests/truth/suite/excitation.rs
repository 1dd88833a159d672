//! Roads, speeds and shaker signals of one ride, and their size.

use super::case::{Case, Setting};
use super::circumstance::Circumstance;
use crate::chance::Chance;
use crate::simulate::drive::{Drive, STEP_S, Travel, Wave};
use crate::simulate::effect::{Effect, Kind};
use crate::simulate::road::{Obstacle, Road, Spectrum};
use crate::simulate::speed::Profile;
use crate::simulate::vehicle::{Bike, STATES, State};

/// Time simulated before the log starts and after it ends, s.
const LEAD_S: f64 = 2.0;
const TAIL_S: f64 = 0.1;

pub enum Excitation {
    Road { road: Road, behind_m: f64 },
    Plate([Wave; 2]),
    Shaker([Wave; 2]),
    Decay([f64; 2]),
}

pub struct Ridden {
    pub excitation: Excitation,
    pub speed: Profile,
    pub cadence: Profile,
    start_s: f64,
    steps: usize,
    travel: Travel,
}

impl Ridden {
    pub fn draw(case: &Case, bike: &Bike, chance: &mut Chance) -> Self {
        let start_s = if case.setting == Setting::Decay {
            0.0
        } else {
            -LEAD_S
        };
        let steps = ((case.duration_s + TAIL_S - start_s) / STEP_S).ceil() as usize;
        let cadence = Profile::wobble(chance.uniform(62.0, 92.0), 4.0, chance);
        let speed = speed(case, chance);
        let mut travel = Travel::default();
        let excitation = match case.setting {
            Setting::Road => {
                travel = Travel::new(&speed, &cadence, start_s, STEP_S / 2.0, 2 * steps + 1);
                let road = road(case, bike, &travel, chance);
                Excitation::Road {
                    road,
                    behind_m: bike.wheelbase_m(),
                }
            }
            Setting::Plate => Excitation::Plate([0, 1].map(|_| wave(2.0, chance))),
            Setting::Shaker => Excitation::Shaker([0, 1].map(|_| wave(0.0, chance))),
            Setting::Decay => {
                Excitation::Decay([0, 1].map(|_| chance.sign() * chance.uniform(6e-3, 12e-3)))
            }
        };
        Self {
            excitation,
            speed,
            cadence,
            start_s,
            steps,
            travel,
        }
    }

    /// A ride at `speed` over a road without obstacles, of `density_m3` at 0.1 cycles/m (ISO 8608) up to `highest_per_m` (cycles/m),
    /// as far as the log carries it.
    pub fn on_road(
        case: &Case,
        bike: &Bike,
        speed: Profile,
        (density_m3, highest_per_m): (f64, f64),
        chance: &mut Chance,
    ) -> Self {
        let cadence = Profile::wobble(chance.uniform(62.0, 92.0), 4.0, chance);
        let steps = ((case.duration_s + TAIL_S + LEAD_S) / STEP_S).ceil() as usize;
        let travel = Travel::new(&speed, &cadence, -LEAD_S, STEP_S / 2.0, 2 * steps + 1);
        let fastest = travel.speed.iter().fold(0.0_f64, |a, &b| a.max(b));
        let spectrum = Spectrum {
            density_m3,
            lowest_per_m: 0.05,
            highest_per_m: highest_per_m.min(case.fastest_hz() / fastest),
        };
        let (from, to) = (travel.distance[0], travel.distance[2 * steps]);
        let behind_m = bike.wheelbase_m();
        let road = Road::new(from - behind_m - 2.0, to + 2.0, spectrum, &[], chance);
        Self {
            excitation: Excitation::Road { road, behind_m },
            speed,
            cadence,
            start_s: -LEAD_S,
            steps,
            travel,
        }
    }

    pub fn drive(&self, effects: &[Effect]) -> Drive {
        let mut drive = Drive::empty(self.start_s, STEP_S, self.steps);
        match &self.excitation {
            Excitation::Road { road, behind_m } => {
                drive.travel = self.travel.clone();
                drive.ride([road, road], [0.0, *behind_m], effects);
            }
            Excitation::Plate(waves) => waves
                .iter()
                .enumerate()
                .for_each(|(axle, w)| drive.shake_ground(axle, w)),
            Excitation::Shaker(waves) => waves
                .iter()
                .enumerate()
                .for_each(|(axle, w)| drive.push(axle, w)),
            Excitation::Decay(_) => {}
        }
        drive
    }

    /// State at the start of the drive.
    pub fn release(&self) -> State {
        let mut state = [[0.0; STATES]; 2];
        if let Excitation::Decay(from) = self.excitation {
            state[0][0] = from[0];
            state[1][0] = from[1];
        }
        state
    }

    /// Distance ridden at `t`, m.
    pub fn distance(&self, t: f64) -> f64 {
        let at = ((t - self.start_s) / (STEP_S / 2.0)).max(0.0);
        let i = (at as usize).min(self.travel.distance.len() - 2);
        let (a, b) = (self.travel.distance[i], self.travel.distance[i + 1]);
        a + (b - a) * (at - i as f64)
    }

    pub fn scale(&mut self, axle_factor: [f64; 2]) {
        match &mut self.excitation {
            Excitation::Road { road, .. } => *road = road.scaled(axle_factor[0]),
            Excitation::Plate(waves) | Excitation::Shaker(waves) => {
                waves
                    .iter_mut()
                    .zip(axle_factor)
                    .for_each(|(w, f)| w.scale(f));
            }
            Excitation::Decay(_) => {}
        }
    }
}

fn speed(case: &Case, chance: &mut Chance) -> Profile {
    let until = case.duration_s;
    if case.circumstance == Some(Circumstance::Walking) {
        return Profile::wobble(chance.uniform(1.05, 1.45), 0.05, chance);
    }
    let needs = |kinds: &[Kind]| case.effects.iter().any(|(k, _)| kinds.contains(k));
    if needs(&[Kind::LoadTransfer]) {
        let acceleration = [0.6, 1.2, 2.2][case.size] * chance.uniform(0.9, 1.1);
        return Profile::wobble(5.0, 0.1, chance).with_steps(until, acceleration, 3.0, 7.5, chance);
    }
    let varied = needs(&[
        Kind::SpeedDependentDamping,
        Kind::SpeedDependentStiffness,
        Kind::WheelbaseDelay,
    ]);
    if varied || chance.happens(0.4) {
        let low = if needs(&[Kind::SpeedDependentDamping]) {
            2.2
        } else {
            3.0
        };
        let acceleration = chance.uniform(0.5, 1.2);
        return Profile::wobble(5.0, 0.1, chance).with_steps(until, acceleration, low, 8.0, chance);
    }
    let (base, size) = (chance.uniform(3.5, 7.5), chance.uniform(0.1, 0.4));
    Profile::wobble(base, size, chance)
}

/// An ISO 8608 road of class A to C with bumps and kerbs, free of content that 100 Hz cannot carry.
fn road(case: &Case, bike: &Bike, travel: &Travel, chance: &mut Chance) -> Road {
    let fastest = travel.speed.iter().fold(0.0_f64, |a, &b| a.max(b));
    let ends = |v: &[f64]| {
        (
            v.first().copied().unwrap_or(0.0),
            v.last().copied().unwrap_or(0.0),
        )
    };
    let (from, to) = ends(&travel.distance);
    let spectrum = Spectrum {
        density_m3: chance.log_uniform(8e-6, 400e-6),
        lowest_per_m: 0.05,
        highest_per_m: case.fastest_hz() / fastest,
    };
    let lifts = case.effects.iter().any(|(k, _)| *k == Kind::WheelLift);
    let mut obstacles = Vec::new();
    let carried = case.circumstance != Some(Circumstance::Slow);
    if lifts || chance.happens(0.35) && carried {
        let mut at = from + chance.uniform(5.0, 30.0);
        while at < to - 5.0 {
            let height_m = chance.uniform(0.004, 0.015);
            if chance.happens(0.6) {
                obstacles.push(Obstacle::Bump {
                    at_m: at,
                    length_m: 0.11 * fastest * chance.uniform(1.0, 1.6),
                    height_m,
                });
            } else {
                let length_m = 0.09 * fastest * chance.uniform(1.0, 1.5);
                obstacles.push(Obstacle::Ramp {
                    at_m: at,
                    length_m,
                    height_m,
                });
                let down = at + chance.uniform(4.0, 9.0);
                obstacles.push(Obstacle::Ramp {
                    at_m: down,
                    length_m,
                    height_m: -height_m,
                });
            }
            at += chance.uniform(10.0, if lifts { 25.0 } else { 60.0 });
        }
    }
    Road::new(
        from - bike.wheelbase_m() - 2.0,
        to + 2.0,
        spectrum,
        &obstacles,
        chance,
    )
}

/// A shaker signal between 0.7 and 22 Hz; its amplitude is set by [`Ridden::scale`]. Amplitudes fall as f^-`fall`/2.
fn wave(fall: f64, chance: &mut Chance) -> Wave {
    if chance.happens(0.3) {
        return Wave::Sweep {
            amplitude: 1.0,
            middle_hz: 9.5,
            swing_hz: 8.5,
            period_s: chance.uniform(8.0, 15.0),
        };
    }
    let lines = 60;
    let ratio = (22.0_f64 / 0.7).powf(1.0 / lines as f64);
    Wave::Multisine(
        (0..lines)
            .map(|i| {
                let f = 0.7 * ratio.powf(i as f64 + chance.uniform(0.0, 1.0));
                (
                    f.powf(-fall / 2.0),
                    std::f64::consts::TAU * f,
                    chance.phase(),
                )
            })
            .collect(),
    )
}
