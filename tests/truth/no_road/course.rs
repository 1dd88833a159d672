//! A ride before anything is concealed in it: bicycle, conditions, tracks; and how it is ridden and logged.

use super::conditions::{Conditions, bike};
use super::plan::Planned;
use crate::chance::Chance;
use crate::simulate::drive::{Drive, STEP_S, Travel};
use crate::simulate::effect::{Effect, Kind};
use crate::simulate::integrate::{Motion, integrate};
use crate::simulate::road::Road;
use crate::simulate::sensors::Log;
use crate::simulate::vehicle::{Bike, STATES, Vehicle};
use crate::suite::sizes::Scale;

/// Time simulated before the log starts, in which a lightly damped axle comes to its motion, and after it ends, s.
const LEAD_S: f64 = 4.0;
const TAIL_S: f64 = 0.1;

pub struct Course {
    pub bike: Bike,
    pub conditions: Conditions,
    travel: Travel,
    tracks: [Road; 2],
    steps: usize,
}

impl Course {
    pub fn draw(planned: &Planned, chance: &mut Chance) -> Self {
        let bike = bike(planned.class, chance);
        let conditions = Conditions::draw(planned.class, chance);
        let steps = ((conditions.duration_s + TAIL_S + LEAD_S) / STEP_S).ceil() as usize;
        let (speed, cadence) = (&conditions.speed, &conditions.cadence);
        let travel = Travel::new(speed, cadence, -LEAD_S, STEP_S / 2.0, 2 * steps + 1);
        let (from, to) = (travel.distance[0], travel.distance[2 * steps]);
        let tracks =
            (conditions.ground).tracks([from - bike.wheelbase_m() - 1.0, to + 1.0], chance);
        Self {
            bike,
            conditions,
            travel,
            tracks,
            steps,
        }
    }

    /// What moves the axles. Each wheel starts at the height 0, where its axle rests.
    fn drive(&self, effects: &[Effect]) -> Drive {
        let mut drive = Drive::empty(-LEAD_S, STEP_S, self.steps);
        drive.travel = self.travel.clone();
        let behind_m = [0.0, self.bike.wheelbase_m()];
        drive.ride(self.tracks.each_ref(), behind_m, effects);
        for road in &mut drive.road {
            let start = road[0];
            road.iter_mut().for_each(|height| *height -= start);
        }
        drive
    }

    pub fn scale(&self) -> Scale {
        let drive = self.drive(&[]);
        let motion = moved(&Vehicle::plain(self.bike.clone()), &drive);
        let speed = &self.travel.speed;
        let mean = speed.iter().sum::<f64>() / speed.len() as f64;
        Scale::measure(&motion, &drive, self.conditions.duration_s, mean, 0.0)
    }

    pub fn motion(&self, vehicle: &Vehicle) -> Motion {
        moved(vehicle, &self.drive(&vehicle.effects))
    }

    pub fn log(&self, vehicle: &Vehicle, motion: &Motion, chance: &mut Chance) -> Log {
        let Conditions {
            logger, duration_s, ..
        } = &self.conditions;
        let samples = (duration_s * logger.rate_hz) as usize;
        let t: Vec<f64> = (0..samples).map(|i| i as f64 / logger.rate_hz).collect();
        let late = |axle| vehicle.find(Kind::SensorDelay, axle).map_or(0.0, |p| p[0]);
        let a = [0, 1].map(|axle| logger.acceleration(motion, axle, late(axle), &t, chance));
        let v = logger.speed(&self.conditions.speed, &t, chance);
        let pedals = vehicle.find(Kind::PedallingForce, 0).is_some()
            || vehicle.find(Kind::PedallingForce, 1).is_some();
        let mut cadence = Vec::new();
        if pedals || chance.happens(0.9) {
            let rpm = |t: &f64| self.conditions.cadence.value(*t) + 0.2 * chance.normal();
            cadence = t.iter().map(rpm).collect();
        }
        Log {
            t,
            a,
            v,
            cadence,
            ..Log::default()
        }
    }
}

fn moved(vehicle: &Vehicle, drive: &Drive) -> Motion {
    let rest = [[0.0; STATES]; 2];
    integrate(vehicle, drive, rest, [true, true], f64::INFINITY)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::no_road::class::Class;
    use crate::no_road::plan;

    #[test]
    fn the_rear_wheel_meets_the_road_of_the_front_one_a_wheelbase_later() {
        let plan = plan::plan(&mut Chance::new(1, 0));
        let clean = plan.iter().find(|p| p.class == Class::Clean);
        let clean = clean.expect("the plan has it");
        let course = Course::draw(clean, &mut Chance::new(5, 3));
        let drive = course.drive(&[]);
        let (mut both, mut powers) = (0.0, [0.0; 2]);
        for i in (0..drive.len()).step_by(7) {
            let behind = course.travel.distance[i] - course.bike.wheelbase_m();
            let front = course.tracks[0].slope(behind);
            let rear = drive.road_rate[1][i] / course.travel.speed[i];
            both += front * rear;
            powers[0] += front * front;
            powers[1] += rear * rear;
        }
        let correlation = both / (powers[0] * powers[1]).sqrt();
        assert!((0.8..1.0).contains(&correlation), "{correlation}");
    }
}
