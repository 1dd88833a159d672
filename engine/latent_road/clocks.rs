//! How the clocks of lasers go beside those of the accelerometers on their axles, and how much noise they hold.
//!
//! Both see the same motion: m z'' = k d + B d' whatever the road is. So an axle's accelerometer and laser alone determine the laser's
//! clock, by the likelihood that k and B of a ride without a road come from. An accelerometer on the other axle and the speed determine k
//! and B by themselves, and the clock some four times better.

use std::f64::consts::TAU;

use super::found::Ended;
use super::record::{Record, Sensor};
use super::{band, gather, solved, windows};
use veloid_core::bicycle::{Axle, Bike};
use veloid_report::Correction;
use veloid_ride::{ClockOffset, Ride, SensorClock, SensorKind, SensorRecord, channel_name};

/// Standard errors that an offset or a drift must be, for time stamps to be changed by it, and the least share of B that it must pass
/// for: a delay t of the deflection acts as a damping k t, and below the share no method is better.
const SURE: f64 = 5.0;
const MATTERS: f64 = 0.01;

/// What is found out about a laser by the accelerometer on its axle.
pub struct Compared {
    pub axle: Axle,
    pub clock: SensorClock,
    /// Its noise: frequencies (Hz) and the one-sided density there (m^2/Hz); nothing where it is not known.
    pub noise: Vec<[f64; 2]>,
}

/// A laser as a record shows it.
struct Comparison {
    axle: Axle,
    clock: ClockOffset,
    is_worth_it: bool,
    noise: Vec<[f64; 2]>,
}

/// All lasers that have an accelerometer beside them; none of a ride that is too short to compare them, or whose road is known.
pub fn compare(ride: &Ride, bike: &Bike) -> Vec<Compared> {
    let pairs: Vec<(Axle, Record)> = (Axle::BOTH.into_iter())
        .filter_map(|axle| Some((axle, gather::beside(ride, axle)?)))
        .collect();
    if pairs.is_empty() {
        return Vec::new();
    }
    let mut together = by_both_axles(ride, bike).unwrap_or_default();
    let compared = |(axle, record): (Axle, Record)| {
        let at = together
            .iter()
            .position(|compared_clocks| compared_clocks.axle == axle);
        let compared_clocks =
            compared_clocks(ride, &record, at.map(|at| together.swap_remove(at)))?;
        let [channel, beside] = [SensorKind::Deflection, SensorKind::Acceleration]
            .map(|kind| channel_name(kind, axle).to_owned());
        let files = [&channel, &beside].map(|c| ride.summary.file_of(c).map(str::to_owned));
        let [file, beside_file] = match files[0] == files[1] {
            true => [None, None],
            false => files,
        };
        Some(Compared {
            axle,
            clock: SensorClock {
                channel,
                beside,
                file,
                beside_file,
                applied: compared_clocks
                    .as_ref()
                    .is_ok_and(|compared_clocks| compared_clocks.is_worth_it),
                reason: compared_clocks.as_ref().err().cloned(),
                found: compared_clocks
                    .as_ref()
                    .ok()
                    .map(|compared_clocks| compared_clocks.clock),
            },
            noise: compared_clocks
                .map_or_else(|_| Vec::new(), |compared_clocks| compared_clocks.noise),
        })
    };
    pairs.into_iter().filter_map(compared).collect()
}

/// What is reported of an axle's laser: by all sensors together, or by its pair alone; but nothing where the pair has nothing in common,
/// whatever fits best. Nothing at all where it is too short.
fn compared_clocks(
    ride: &Ride,
    pair: &Record,
    together: Option<Comparison>,
) -> Option<Result<Comparison, String>> {
    let windows = windows(pair).ok()?;
    let band = match band::band(&windows, &pair.sensors) {
        Ok(band) => band,
        Err(reason) => return Some(Err(reason)),
    };
    let alone = || {
        let mut all = solved(pair, &windows, band, |ended| lasers(ride, &ended))?;
        let nothing = || "the sensors have too little motion in common".to_owned();
        all.pop().ok_or_else(nothing)
    };
    Some(together.map_or_else(alone, Ok))
}

/// The lasers that the sensors of both axles and the speed determine together.
fn by_both_axles(ride: &Ride, bike: &Bike) -> Option<Vec<Comparison>> {
    let record = gather::gather(ride, bike).ok()?;
    let others = record.sensors.len() > 2;
    let windows = windows(&record).ok().filter(|_| others)?;
    let band = band::band(&windows, &record.sensors).ok()?;
    solved(&record, &windows, band, |ended| lasers(ride, &ended)).ok()
}

/// The lasers that a fit shows.
fn lasers(ride: &Ride, ended: &Ended) -> Vec<Comparison> {
    let sensors = ended.record.sensors.iter().enumerate();
    let lasers = sensors.filter(|(_, s)| s.kind == SensorKind::Deflection);
    let compared_clocks = |(i, s): (usize, &Sensor)| {
        let clock = offset(ride, ended, i)?;
        Some(Comparison {
            axle: s.axle,
            is_worth_it: is_worth_it(&clock, ended.stiffness_per_damping(s.axle)?),
            clock,
            noise: noise(ended, i),
        })
    };
    lasers.filter_map(compared_clocks).collect()
}

/// Nothing where the ride does not determine it.
fn offset(ride: &Ride, ended: &Ended, laser: usize) -> Option<ClockOffset> {
    let sensor = &ended.record.sensors[laser];
    let late = ended.delay(laser)?;
    // A short ride shows no more of it than was known.
    let drift = ended.drift(laser).unwrap_or(Correction {
        value: sensor.known.drift,
        std_error: sensor.drift,
    });
    let beside = |s: &&SensorRecord| s.axle == sensor.axle && s.kind == SensorKind::Acceleration;
    let accelerometer = ride.sensors.iter().find(beside)?;
    Some(ClockOffset::about_the_middle(
        accelerometer.first_s,
        ride.start_s + 0.5 * ride.duration_s(),
        [late.value, late.std_error],
        [drift.value, drift.std_error],
    ))
}

/// A laser's noise at every frequency that it was compared at.
fn noise(ended: &Ended, laser: usize) -> Vec<[f64; 2]> {
    let spacing = ended.bins.spacing / TAU;
    let last = (ended.record.sensors[laser].highest_hz / spacing) as usize;
    let first = (ended.band.low_hz / spacing).ceil() as usize;
    let at = |k: usize| k as f64 * spacing;
    (first..=last)
        .map(|k| [at(k), ended.noise_density(laser, at(k))])
        .collect()
}

/// Whether time stamps are better changed: `per_delay_s` is the share of B that a delay of a second passes for.
fn is_worth_it(found: &ClockOffset, per_delay_s: f64) -> bool {
    let half = found.middle_s - found.at_s;
    let drifted = 1e-6 * found.drift_ppm.abs();
    let matters = |delay_s: f64| delay_s * per_delay_s > MATTERS;
    let offset = found.middle_offset_s.abs();
    offset > SURE * found.middle_offset_std_s && matters(offset)
        || drifted > SURE * 1e-6 * found.drift_std_ppm && matters(drifted * half)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stamps_are_changed_by_what_is_sure_and_matters() {
        // k/B is 100 1/s: 0.1 ms pass for 1 % of B.
        let worth = |offset_s: f64, std_s: f64, drift: f64, drift_std: f64| {
            let found =
                ClockOffset::about_the_middle(0.0, 30.0, [offset_s, std_s], [drift, drift_std]);
            is_worth_it(&found, 100.0)
        };
        let (least, sure) = (MATTERS / 100.0, 1.01 * SURE);
        assert!(worth(1.01 * least, least / sure, 0.0, 1e-6));
        assert!(worth(-1.01 * least, least / sure, 0.0, 1e-6));
        assert!(!worth(0.99 * least, 1e-9, 0.0, 1e-6));
        assert!(!worth(1.01 * least, least / (0.95 * SURE), 0.0, 1e-6));
        let fast = least / 30.0;
        assert!(worth(0.0, 1e-4, -1.01 * fast, fast / sure));
        assert!(!worth(0.0, 1e-4, 0.99 * fast, 1e-9));
        assert!(!worth(0.0, 1e-4, 1.01 * fast, fast / (0.95 * SURE)));
    }
}
