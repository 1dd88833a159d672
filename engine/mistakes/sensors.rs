//! Accelerometers and lasers that are read wrongly: each reading that people get wrong is tried by the likelihood of the unknown
//! road ([`veloid_latent_road`]) on all sensors of the ride.

mod meant;

use crate::course::SPEEDS;
use meant::{ACCELERATIONS, LENGTHS, Meant, is_accelerometer, is_near, scale, units_near};
use veloid_core::bicycle::{Axle, Bike};
use veloid_latent_road::{Band, Evidence, Reading, beside};
use veloid_report::Mistake;
use veloid_ride::Ride;

/// Log likelihood (nats) by which another reading must explain the sensors better: odds of 1 to 5e8 against chance, far beyond
/// what readings differ by that are both right (Kass and Raftery 1995 call 5 very strong).
const SURE: f64 = 20.0;
/// Coherence that another alignment of the axles must gain to be tried.
const GAINS: f64 = 0.05;
/// Least coherence of a laser with the accelerometer beside it, once its sign is right: it follows that below the resonance.
const FOLLOWS: f64 = 0.3;
/// Ratio of two accelerometers below their resonances, where both show the road, beyond which a unit is suspected; the same of
/// a laser beside its accelerometer.
const UNEQUAL: f64 = 1.7;
/// Delays (s) between accelerometers of one logger from which one is late, and up to which they are looked for; a wrong speed
/// makes larger ones.
const LATE_S: [f64; 2] = [0.012, 0.06];
/// The reading of its sensors that explains a ride much better than the one that was declared.
pub fn mistake(ride: &Ride, bike: &Bike) -> Option<Mistake> {
    if ride.sensors.is_empty() || ride.speed.is_none() {
        return None;
    }
    let declared = Reading::of(ride, bike)?;
    let has = |axle| {
        ride.sensors
            .iter()
            .any(|s| is_accelerometer(s.kind) && s.axle == axle)
    };
    if !Axle::BOTH.into_iter().all(has) {
        return None;
    }
    let tried = suspected(ride, bike, &declared);
    likelier(ride, bike, &declared, &tried).or_else(|| {
        let alone = alone(ride, bike)?;
        fitted(ride, &alone).or_else(|| laser(ride, bike, &declared, &alone))
    })
}

/// What the accelerometers say of themselves.
fn alone(ride: &Ride, bike: &Bike) -> Option<Evidence> {
    let mut alone = ride.clone();
    alone.sensors.retain(|s| is_accelerometer(s.kind));
    let reading = Reading::of(&alone, bike)?;
    reading.evidence(reading.band()?)
}

/// A gain in a unit, or a delay that no logger makes, between accelerometers that the fit bears with and so explains the ride.
fn fitted(ride: &Ride, alone: &Evidence) -> Option<Mistake> {
    let is_equal = (UNEQUAL.recip()..UNEQUAL).contains(&alone.gain);
    let unit = units_near(alone.gain).next().filter(|_| !is_equal);
    let unit = unit.map(|times| Meant::Rear { times });
    let late = Meant::RearLate { by_s: alone.late_s };
    let meant = unit.or((alone.late_s.abs() > LATE_S[0]).then_some(late))?;
    Some(meant.mistake(ride))
}

/// Readings that what both axles share at low frequencies speaks for.
fn suspected(ride: &Ride, bike: &Bike, declared: &Reading) -> Vec<Meant> {
    let Some(shared) = declared.shared(LATE_S[1]) else {
        return Vec::new();
    };
    let mut tried = Vec::new();
    if shared.coherence.re < 0.0 {
        tried.push(Meant::Turned);
    }
    if !(UNEQUAL.recip()..UNEQUAL).contains(&shared.ratio) {
        tried.extend(units_near(shared.ratio).map(|times| Meant::Rear { times }));
    }
    if shared.late_s.abs() > LATE_S[0] {
        tried.push(Meant::RearLate {
            by_s: shared.late_s,
        });
    }
    let speeds = SPEEDS.map(|(factor, unit)| Meant::Speed { factor, unit });
    for other in speeds.into_iter().chain([Meant::SwappedAccelerometers]) {
        let aligned = other.reading(ride, bike).and_then(|r| r.shared(0.0));
        let gains = |found: f64| found > shared.coherence.norm() + GAINS;
        if aligned.is_some_and(|found| gains(found.coherence.norm())) {
            tried.push(other);
            if other == Meant::SwappedAccelerometers && declared.lasers().next().is_some() {
                tried.push(Meant::SwappedAxles);
            }
        }
    }
    tried
}

/// The likeliest of the suspected readings, where it is surely likelier than the declared one.
fn likelier(ride: &Ride, bike: &Bike, declared: &Reading, tried: &[Meant]) -> Option<Mistake> {
    let tried: Vec<(Meant, Reading)> = (tried.iter())
        .filter_map(|meant| Some((*meant, meant.reading(ride, bike)?)))
        .collect();
    let bands = tried.iter().filter_map(|(_, reading)| reading.band());
    let width = |band: &Band| band.high_hz / band.low_hz;
    let band = bands.max_by(|a, b| width(a).total_cmp(&width(b)))?;
    let as_declared = declared.evidence(band)?;
    let beyond = |(meant, reading): &(Meant, Reading)| {
        let by = reading.evidence(band)?.beyond(&as_declared);
        (by > SURE).then_some((*meant, by))
    };
    let mut found: Vec<(Meant, f64)> = tried.iter().filter_map(beyond).collect();
    found.sort_by(|(_, a), (_, b)| b.total_cmp(a));
    let (meant, best) = found.first()?;
    let as_good = found.iter().skip(1).take_while(|(_, by)| best - by < SURE);
    let others: Vec<String> = as_good.map(|(other, _)| other.cure(ride)).collect();
    let tie = match others.is_empty() {
        true => String::new(),
        false => format!(" The ride fits as well if: {}", others.join(" Or: ")),
    };
    let mistake = meant.mistake(ride);
    Some(Mistake {
        sentence: format!("{}{tie}", mistake.sentence),
        ..mistake
    })
}

/// A laser beside accelerometers that determine their axle without it.
fn laser(ride: &Ride, bike: &Bike, declared: &Reading, alone: &Evidence) -> Option<Mistake> {
    let axles: Vec<Axle> = declared.lasers().collect();
    for axle in axles {
        let Some(gain) = alone.rates(axle).and_then(|r| declared.laser_gain(axle, r)) else {
            continue;
        };
        if (UNEQUAL.recip()..UNEQUAL).contains(&gain) {
            continue;
        }
        let lengths = LENGTHS.iter().map(|(n, _)| 1.0 / n);
        let accelerations = ACCELERATIONS.iter().map(|(n, _)| *n);
        let times = lengths
            .chain(accelerations)
            .filter(|times| is_near(gain * times));
        let tried: Vec<Meant> = times.map(|times| Meant::Laser { axle, times }).collect();
        if let Some(mistake) = likelier(ride, bike, declared, &tried) {
            return Some(mistake);
        }
    }
    None
}

/// Whether the ride's lasers report the distance to the road, -(u - z), where the other sign was declared: an accelerometer on the
/// same axle follows its spring and damper, m z'' = k d + B d', whatever the road is.
pub fn lasers_are_turned(ride: &Ride) -> bool {
    let more_likely = |axle: Axle| {
        let declared = beside(ride, axle)?;
        let mut other = declared.clone();
        let laser = other.sensors.iter_mut().find(|s| s.beside.is_some())?;
        scale(&mut laser.values, -1.0);
        let [declared, other] = [declared, other].map(Reading::of_record);
        let (declared, other) = (declared?, other?);
        let band = other.band().or_else(|| declared.band())?;
        let follows = other
            .shared(0.0)
            .is_some_and(|shared| shared.coherence.re > FOLLOWS);
        let (as_declared, turned) = (declared.evidence(band)?, other.evidence(band)?);
        follows.then(|| turned.beyond(&as_declared))
    };
    let found: Vec<f64> = Axle::BOTH.into_iter().filter_map(more_likely).collect();
    found.iter().sum::<f64>() > SURE
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::meant::{NEAR, in_unit, other_axle, shift};
    use super::*;
    use veloid_methods::simulate::road::Roughness;
    use veloid_methods::simulate::simulated_ride::{Excitation, SimulatedRide, SpeedChange};
    use veloid_report::MistakeKind;

    fn bike() -> Bike {
        Bike {
            mass_front_kg: Some(23.0),
            mass_rear_kg: Some(63.0),
            l_front_m: Some(0.808),
            l_rear_m: Some(0.293),
            ..Bike::default()
        }
    }

    fn simulated(seed: u64) -> Ride {
        let simulated = SimulatedRide {
            excitation: Excitation::Road {
                roughness: Some(Roughness::C),
                bumps: Vec::new(),
            },
            speed_change: Some(SpeedChange {
                share: 0.2,
                period_s: 20.0,
            }),
            seed,
            ..SimulatedRide::default()
        };
        simulated.sensed(0.03).unwrap()
    }

    fn found(change: impl Fn(&mut Ride)) -> Option<MistakeKind> {
        let mut ride = simulated(3);
        change(&mut ride);
        mistake(&ride, &bike()).map(|m| m.kind)
    }

    fn by(ride: &mut Ride, axle: Axle, times: f64) {
        let sensors = ride.sensors.iter_mut().filter(|s| s.axle == axle);
        sensors.for_each(|s| scale(&mut s.values, times));
    }

    #[test]
    fn each_reading_is_known_and_a_right_one_is_left_alone() {
        assert_eq!(found(|_| ()), None);
        for axle in Axle::BOTH {
            assert_eq!(
                found(|ride| by(ride, axle, -1.0)),
                Some(MistakeKind::TurnedChannel)
            );
            let in_g = |ride: &mut Ride| by(ride, axle, 1.0 / 9.806_65);
            assert_eq!(found(in_g), Some(MistakeKind::WrongUnit));
        }
        for (factor, _) in SPEEDS {
            let faster = |ride: &mut Ride| scale(ride.speed.as_mut().unwrap(), factor);
            assert_eq!(found(faster), Some(MistakeKind::SpeedUnit));
        }
        let swapped = |ride: &mut Ride| {
            let sensors = ride.sensors.iter_mut();
            sensors.for_each(|s| s.axle = other_axle(s.axle));
        };
        assert_eq!(found(swapped), Some(MistakeKind::SwappedAccelerometers));
    }

    #[test]
    fn a_sensor_is_late_from_the_delay_on_that_no_logger_has() {
        let late = |samples: f64| {
            found(|ride| {
                let rear = ride
                    .sensors
                    .iter_mut()
                    .find(|s| s.axle == Axle::Rear)
                    .unwrap();
                shift(&mut rear.values, &mut rear.valid, samples);
            })
        };
        let samples = LATE_S[0] / 0.01;
        assert_eq!(
            late(-(samples + 1.0).floor()),
            Some(MistakeKind::LateChannel)
        );
        assert_eq!(
            late((samples + 1.0).floor()),
            Some(MistakeKind::LateChannel)
        );
        assert_eq!(late(-samples.floor()), None);
    }

    /// What is named is the unit whose factor is near, and the other channel where the factor is its reverse.
    #[test]
    fn units_are_named_by_their_factor() {
        let g = in_unit(9.8, &ACCELERATIONS, ["a_r", "a_f"]);
        assert!(
            g.starts_with("a_r is about 0.102 times") && g.contains("a_r [g]"),
            "{g}"
        );
        let g = in_unit(1.0 / 9.8, &ACCELERATIONS, ["a_r", "a_f"]);
        assert!(
            g.starts_with("a_f is about 0.102 times") && g.contains("a_f [g]"),
            "{g}"
        );
        let mm = in_unit(1e-3, &ACCELERATIONS, ["a_r", "a_f"]);
        assert!(mm.contains("a_r [mm/s^2]"), "{mm}");
        assert!(is_near(0.99 * NEAR) && !is_near(1.01 * NEAR));
    }
}
