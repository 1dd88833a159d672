//! Ways in which sensors may be meant other than they were declared: the ride so read, and how to mend it.

use crate::course::too_late;
use veloid_core::bicycle::{Axle, Bike};
use veloid_core::document::format_number::significant;
use veloid_latent_road::Reading;
use veloid_report::{Mistake, MistakeKind};
use veloid_ride::{Ride, SensorKind, channel_name};

/// How near (ratio) to a unit's factor it must come.
pub const NEAR: f64 = 1.4;
/// Units of an acceleration and of a length, and how many of them are 1 in SI.
pub const ACCELERATIONS: [(f64, &str); 4] = [
    (1.0 / 9.806_65, "g"),
    (1e3, "mm/s^2"),
    (1e2, "cm/s^2"),
    (3.280_84, "ft/s^2"),
];
pub const LENGTHS: [(f64, &str); 4] = [(1e3, "mm"), (1e2, "cm"), (39.37, "in"), (1e6, "um")];

/// One way in which the sensors may be meant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Meant {
    /// One accelerometer counts downwards.
    Turned,
    /// The rear accelerometer, this many times larger than it is written.
    Rear {
        times: f64,
    },
    /// The rear accelerometer, so much later than it should be (s).
    RearLate {
        by_s: f64,
    },
    /// Front and rear accelerometer in each other's place, or all sensors.
    SwappedAccelerometers,
    SwappedAxles,
    /// A speed in another unit.
    Speed {
        factor: f64,
        unit: &'static str,
    },
    /// An axle's laser, this many times larger than it is written.
    Laser {
        axle: Axle,
        times: f64,
    },
}

impl Meant {
    /// The ride under another reading.
    pub fn reading(self, ride: &Ride, bike: &Bike) -> Option<Reading> {
        let mut other = ride.clone();
        let step_s = ride.step_s;
        for sensor in &mut other.sensors {
            let rear = is_accelerometer(sensor.kind) && sensor.axle == Axle::Rear;
            match self {
                // A laser's sign was already chosen to be that of the accelerometer beside it.
                Meant::Turned if sensor.axle == Axle::Rear => scale(&mut sensor.values, -1.0),
                Meant::Rear { times } if rear => scale(&mut sensor.values, times),
                Meant::RearLate { by_s } if rear => {
                    shift(&mut sensor.values, &mut sensor.valid, by_s / step_s)
                }
                Meant::SwappedAccelerometers if is_accelerometer(sensor.kind) => {
                    sensor.axle = other_axle(sensor.axle);
                }
                Meant::SwappedAxles => sensor.axle = other_axle(sensor.axle),
                Meant::Laser { axle, times }
                    if !is_accelerometer(sensor.kind) && sensor.axle == axle =>
                {
                    scale(&mut sensor.values, times);
                }
                _ => {}
            }
        }
        if let Meant::Speed { factor, .. } = self {
            scale(other.speed.as_mut()?, 1.0 / factor);
        }
        Reading::of(&other, bike)
    }

    /// The mistake of having read it otherwise.
    pub fn mistake(self, ride: &Ride) -> Mistake {
        Mistake {
            kind: self.kind(),
            sentence: self.cure(ride),
            takes_the_verdict: true,
        }
    }

    fn kind(self) -> MistakeKind {
        match self {
            Meant::Turned => MistakeKind::TurnedChannel,
            Meant::Rear { .. } | Meant::Laser { .. } => MistakeKind::WrongUnit,
            Meant::RearLate { .. } => MistakeKind::LateChannel,
            Meant::SwappedAccelerometers => MistakeKind::SwappedAccelerometers,
            Meant::SwappedAxles => MistakeKind::SwappedAxles,
            Meant::Speed { .. } => MistakeKind::SpeedUnit,
        }
    }

    /// What is wrong, and what to do.
    pub fn cure(self, ride: &Ride) -> String {
        let sensors = "a_f and a_r";
        match self {
            Meant::Turned => format!(
                "{sensors} have opposite signs, though both axles ride over the same road: invert the one that is positive downwards."
            ),
            Meant::Rear { times } => in_unit(times, &ACCELERATIONS, ["a_r", "a_f"]),
            Meant::RearLate { by_s } => {
                let (late, early) = if by_s > 0.0 {
                    ("a_r", "a_f")
                } else {
                    ("a_f", "a_r")
                };
                format!(
                    "{late} is {} ms late relative to {early}: record both on one logger with the same filter, or check the wheelbase \
                     and the speed, by which the rear wheel meets the front wheel's road.",
                    significant(1e3 * by_s.abs(), 2)
                )
            }
            Meant::SwappedAccelerometers | Meant::SwappedAxles => {
                let lasers = ride.sensors.iter().any(|s| !is_accelerometer(s.kind));
                let all = match (self, lasers) {
                    (Meant::SwappedAxles, _) => "front and rear channels are all swapped",
                    (_, true) => "a_f and a_r are swapped (the laser is on its axle)",
                    _ => "a_f and a_r are swapped",
                };
                format!(
                    "The rear wheel meets the road before the front wheel: {all}. Swap them back."
                )
            }
            Meant::Speed { unit, .. } => too_late(unit),
            Meant::Laser { axle, times } => {
                let laser = channel_name(SensorKind::Deflection, axle);
                match LENGTHS.iter().find(|(n, _)| is_near(times * n)) {
                    Some((_, unit)) => format!(
                        "{laser} is about {} times too large relative to the accelerometers: its unit seems to be {unit}. Name the \
                         column \"{laser} [{unit}]\".",
                        significant(1.0 / times, 3)
                    ),
                    None => {
                        let (_, unit) = nearest(times, &ACCELERATIONS);
                        format!(
                            "{laser} does not fit the accelerometers, unless both of these are in {unit}: name the columns \
                             \"a_f [{unit}]\" and \"a_r [{unit}]\"."
                        )
                    }
                }
            }
        }
    }
}

/// That the first of two channels, or the other one, is in another unit, where the first is `times` larger than it is written.
pub fn in_unit(times: f64, units: &[(f64, &'static str)], [one, other]: [&str; 2]) -> String {
    let (channel, beside, unit) = match units.iter().find(|(n, _)| is_near(times * n)) {
        Some((_, unit)) => (one, other, *unit),
        None => (other, one, nearest(times, units).1),
    };
    let factor = if channel == one { 1.0 / times } else { times };
    format!(
        "{channel} is about {} times as large as it should be relative to {beside}, though both axles ride over the same road: its \
         unit seems to be {unit}. Name the column \"{channel} [{unit}]\".",
        significant(factor, 3)
    )
}

/// The unit of which `factor` are 1 in SI.
fn nearest(factor: f64, units: &[(f64, &'static str)]) -> (f64, &'static str) {
    let off = |n: f64| (factor / n).ln().abs();
    let nearest = units
        .iter()
        .copied()
        .min_by(|a, b| off(a.0).total_cmp(&off(b.0)));
    nearest.unwrap_or((1.0, "SI"))
}

pub fn is_near(ratio: f64) -> bool {
    (NEAR.recip()..NEAR).contains(&ratio)
}

/// Times by which an accelerometer is larger than it is written if it, or the other one, is in a unit, where one reads `gain` times as much.
pub fn units_near(gain: f64) -> impl Iterator<Item = f64> {
    let times = ACCELERATIONS.iter().flat_map(|(n, _)| [1.0 / n, *n]);
    times.filter(move |times| is_near(gain * times))
}

pub fn is_accelerometer(kind: SensorKind) -> bool {
    kind == SensorKind::Acceleration
}

pub fn other_axle(axle: Axle) -> Axle {
    match axle {
        Axle::Front => Axle::Rear,
        Axle::Rear => Axle::Front,
    }
}

pub fn scale(values: &mut [f64], by: f64) {
    values.iter_mut().for_each(|x| *x *= by);
}

/// Brings a sensor forward by so many samples, rounded; what comes from beyond the end is not trusted.
pub fn shift(values: &mut [f64], valid: &mut [bool], late: f64) {
    let late = (late.round() as isize).clamp(-(values.len() as isize), values.len() as isize);
    let by = late.unsigned_abs();
    let ends = if late >= 0 {
        values.rotate_left(by);
        valid.rotate_left(by);
        valid.len() - by..valid.len()
    } else {
        values.rotate_right(by);
        valid.rotate_right(by);
        0..by
    };
    valid[ends].fill(false);
}
