//! Which wheel comes first, and how fast. The rear wheel meets the front wheel's road one wheelbase later; where it meets it
//! earlier front and rear are swapped, and where it meets it after another distance by the speed channel that is in another unit.

use veloid_core::bicycle::Bike;
use veloid_core::document::format_number::significant;
use veloid_report::{Mistake, MistakeKind};
use veloid_ride::{Ride, distance};

/// Speeds that are reported in another unit, times what they are in m/s.
pub const SPEEDS: [(f64, &str); 2] = [(3.6, "km/h"), (2.236_94, "mph")];
/// How far beside the delay of a unit both roads must be less alike.
const BESIDE: [f64; 2] = [0.9, 1.1];
/// Correlation of both roads from which one reading is right, and up to which another is wrong.
const RIGHT: f64 = 0.7;
const WRONG: f64 = 0.4;
/// Most samples that are looked at, evenly spread; where many delays are tried, in a first pass.
const LOOKED_AT: usize = 20_000;
const GLANCED_AT: usize = 300;

/// Times by which a ride's times may be too long or too short, and the steps in which they are tried.
const SCALES: std::ops::Range<f64> = 1e-3..1e3;
const SCALE_STEP: f64 = 1.02;
/// Steps to both sides of the best one of the first pass that are looked at again.
const AROUND: i32 = 3;
/// How near to a known unit a scale must be to be called by it.
const NEAR: f64 = 0.05;

/// A mistake that the delay between both roads shows.
pub fn mistake(ride: &Ride, bike: &Bike) -> Option<Mistake> {
    let ridden = distance(ride.speed.as_ref()?, ride.step_s);
    let (roads, wheelbase) = Roads::of(ride, bike, &ridden)?;
    if roads.alike(wheelbase) > WRONG {
        return None;
    }
    if roads.alike(-wheelbase) > RIGHT {
        return Some(Mistake {
            kind: MistakeKind::SwappedAxles,
            sentence: "The rear wheel meets the road before the front wheel: front and rear channels are swapped. Swap them back, or \
                       swap front and rear in the bike file. (On a rig that moves the rear wheel first, omit the speed.)"
                .to_owned(),
            takes_the_verdict: true,
        });
    }
    let is_it = |factor: f64| {
        let alike = roads.alike(factor * wheelbase);
        let beside = BESIDE.map(|off| roads.alike(off * factor * wheelbase));
        alike > RIGHT && beside.iter().all(|beside| *beside < alike)
    };
    let (_, unit) = SPEEDS.iter().find(|(factor, _)| is_it(*factor))?;
    Some(Mistake {
        kind: MistakeKind::SpeedUnit,
        sentence: too_late(unit),
        takes_the_verdict: true,
    })
}

/// That the rear wheel meets the front wheel's road after a time that speed and wheelbase contradict, by a factor that is no unit of
/// speed.
pub fn time_scale(ride: &Ride, bike: &Bike) -> Option<Mistake> {
    let ridden = distance(ride.speed.as_ref()?, ride.step_s);
    let (roads, wheelbase) = Roads::of(ride, bike, &ridden)?;
    if roads.alike(wheelbase) > WRONG || roads.alike(-wheelbase) > RIGHT {
        return None;
    }
    let steps = (SCALES.end / SCALES.start).ln() / SCALE_STEP.ln();
    let scale = |i: i32| SCALES.start * SCALE_STEP.powi(i);
    let glances = (0..=steps as i32).map(|i| (i, roads.alike_at(scale(i) * wheelbase, GLANCED_AT)));
    let (near, _) = glances.max_by(|a, b| a.1.total_cmp(&b.1))?;
    let tried =
        (near - AROUND..=near + AROUND).map(|i| (scale(i), roads.alike(scale(i) * wheelbase)));
    let (scale, alike) = tried.max_by(|a, b| a.1.total_cmp(&b.1))?;
    let is_speed = SPEEDS
        .iter()
        .any(|(unit, _)| (scale / unit - 1.0).abs() < NEAR);
    if alike < RIGHT || is_speed {
        return None;
    }
    let rate = significant(scale / ride.step_s, 2);
    let is = |unit: f64| (scale * unit - 1.0).abs() < NEAR;
    let cure = match [60.0, 1e-3, 1e3].map(is) {
        [true, ..] => "the stamps are in minutes: name the column \"t [min]\"".to_owned(),
        [_, true, _] => "the stamps are in ms: name the column \"t [ms]\"".to_owned(),
        [.., true] => {
            "their unit is 1000 times larger: seconds under \"t [ms]\", or ms under \"t [us]\""
                .to_owned()
        }
        _ => format!(
            "if the stamps count samples, give their rate, near {rate} Hz, with rate_hz (--rate HZ)"
        ),
    };
    let times = significant(scale.max(1.0 / scale), 2);
    let which = if scale > 1.0 { "long" } else { "short" };
    Some(Mistake {
        kind: MistakeKind::WrongUnit,
        sentence: format!(
            "By speed and wheelbase the times of this ride are about {times} times too {which}: the rear wheel meets the front wheel's road \
             at another time. Where neither speed nor wheelbase is wrong, {cure}."
        ),
        takes_the_verdict: true,
    })
}

/// What is wrong with a speed in another unit, and how to mend it.
pub fn too_late(unit: &str) -> String {
    format!(
        "By the speed channel the rear wheel meets the front wheel's road too late: the unit of v seems to be {unit}. \
         Name the column \"v [{unit}]\"."
    )
}

/// The roads under both wheels, over the distance ridden.
struct Roads<'a> {
    front: &'a [f64],
    rear: &'a [f64],
    ridden: &'a [f64],
}

impl<'a> Roads<'a> {
    /// The roads of a ride on which both were measured, and the wheelbase.
    fn of(ride: &'a Ride, bike: &Bike, ridden: &'a [f64]) -> Option<(Self, f64)> {
        let (front, rear) = (ride.axles.front.as_ref()?, ride.axles.rear.as_ref()?);
        let are_measured = front.has_road() && rear.has_road();
        let roads = Self {
            front: &front.road,
            rear: &rear.road,
            ridden,
        };
        are_measured.then_some((roads, bike.wheelbase()?))
    }

    /// Correlation of the rear road with the front one so far (m) behind. Each is looked at as it departs from the mean of what
    /// is that far ahead and behind, since the long waves of a road are alike anywhere near.
    fn alike(&self, lag: f64) -> f64 {
        self.alike_at(lag, LOOKED_AT)
    }

    fn alike_at(&self, lag: f64, samples: usize) -> f64 {
        let reach = lag.abs();
        let every = (self.ridden.len() / samples).max(1);
        let pairs = (0..self.ridden.len()).step_by(every).filter_map(|i| {
            let here = self.ridden[i];
            Some([
                self.departs(self.rear, here, reach)?,
                self.departs(self.front, here - lag, reach)?,
            ])
        });
        let mut sums = [0.0; 3];
        for [rear, front] in pairs {
            sums[0] += rear * rear;
            sums[1] += rear * front;
            sums[2] += front * front;
        }
        let alike = sums[1] / (sums[0] * sums[2]).sqrt();
        if alike.is_finite() { alike } else { 0.0 }
    }

    fn departs(&self, road: &[f64], x: f64, reach: f64) -> Option<f64> {
        let ahead = self.at(road, x + reach)?;
        let behind = self.at(road, x - reach)?;
        Some(self.at(road, x)? - 0.5 * (ahead + behind))
    }

    /// The road at a distance (m), between the samples on a straight line; nothing beyond the ride.
    fn at(&self, road: &[f64], x: f64) -> Option<f64> {
        let after = self.ridden.partition_point(|ridden| *ridden <= x);
        let before = after.checked_sub(1)?;
        let (from, to) = (self.ridden[before], *self.ridden.get(after)?);
        let part = (x - from) / (to - from);
        Some(road[before] + part * (road[after] - road[before]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use veloid_core::bicycle::Axle;
    use veloid_methods::simulate::simulated_ride::SimulatedRide;

    fn bike() -> Bike {
        Bike {
            l_front_m: Some(0.808),
            l_rear_m: Some(0.293),
            ..Bike::default()
        }
    }

    #[test]
    fn times_that_speed_and_wheelbase_contradict_are_reported() {
        let found = |times: f64| {
            let mut ride = ride(false);
            ride.step_s *= times;
            time_scale(&ride, &bike()).map(|m| m.sentence)
        };
        assert_eq!(found(1.0), None);
        let counted = found(1.0 / ride(false).step_s).unwrap_or_default();
        let is_near = ["near 99 Hz", "near 100 Hz"]
            .iter()
            .any(|rate| counted.contains(rate));
        assert!(is_near && counted.contains("too long"), "{counted}");
        let minutes = found(1.0 / 60.0).unwrap_or_default();
        assert!(
            minutes.contains("60 times too short") && minutes.contains("t [min]"),
            "{minutes}"
        );
        assert_eq!(found(3.6), None);
    }

    /// What is found on a ride at a speed that is logged `factor` times too large, forwards or with the axles swapped.
    fn found(factor: f64, swapped: bool) -> Option<MistakeKind> {
        let mut ride = ride(swapped);
        ride.speed = ride
            .speed
            .map(|speed| speed.iter().map(|v| factor * v).collect());
        mistake(&ride, &bike()).map(|m| m.kind)
    }

    /// A ride at 5 m/s whose rear wheel meets the front wheel's road, forwards or with the axles swapped.
    fn ride(swapped: bool) -> Ride {
        let mut ride = SimulatedRide::default().ride();
        let speed: Vec<f64> = vec![5.0; ride.samples];
        let ridden = distance(&speed, ride.step_s);
        let (Some(front), Some(rear)) = (&mut ride.axles.front, &mut ride.axles.rear) else {
            unreachable!("both axles ride")
        };
        let roads = Roads {
            front: &front.road,
            rear: &rear.road,
            ridden: &ridden,
        };
        let later = |x: &f64| roads.at(roads.front, x - 1.101).unwrap_or_default();
        rear.road = ridden.iter().map(later).collect();
        if swapped {
            std::mem::swap(&mut front.road, &mut rear.road);
        }
        ride.speed = Some(speed);
        ride
    }

    #[test]
    fn axles_and_speeds_are_reported_by_the_delay_between_the_wheels() {
        assert_eq!(found(1.0, false), None);
        assert_eq!(found(1.0, true), Some(MistakeKind::SwappedAxles));
        for (factor, _) in SPEEDS {
            assert_eq!(found(factor, false), Some(MistakeKind::SpeedUnit));
        }
        assert_eq!(
            found(1.05, false),
            None,
            "a wheelbase a little off is the diagnosis's"
        );
    }

    #[test]
    fn independent_roads_show_nothing() {
        let mut ride = SimulatedRide::default().ride();
        ride.speed = Some(vec![5.0; ride.samples]);
        let other = SimulatedRide {
            seed: 77,
            ..SimulatedRide::default()
        }
        .ride();
        ride.axles.set(
            Axle::Rear,
            other.axles.rear.unwrap_or_else(|| unreachable!()),
        );
        assert_eq!(mistake(&ride, &bike()), None);
    }
}
