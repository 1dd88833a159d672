//! What a ride holds of sensors, made ready for the method.

use super::align::interpolate;
use super::bins::MOST_SENSORS;
use super::record::{Lateness, Record, Sensor, since_middle_s};
use super::rough::rough_lateness;
use super::windows::SLOWEST;
use veloid_core::bicycle::{Axle, Bike};
use veloid_ride::{Placed, Ride, SensorKind, SensorRecord, channel_name, lacking};

/// Part of a sensor's own rate up to which it is believed: beyond, what folds over and the logger's filter are near.
const REACH: f64 = 0.4;
/// Standard deviation (s) of the delay between accelerometers on one logger: filters and multiplexers.
const ONE_LOGGER_S: f64 = 0.01;
/// The same between an accelerometer and a laser with a logger of its own, once roughly aligned.
const OTHER_LOGGER_S: f64 = 0.02;
/// Standard deviation of the share by which one logger's clock runs fast beside another's: quartzes are good to some 50 ppm each,
/// cheap ones and cold ones to 100 or 200.
const OTHER_DRIFT: f64 = 200e-6;
/// Speed (m/s) that a bicycle is taken to ride at where only one axle's sensors are compared and no speed was recorded, or none that any
/// window could use: a dead wheel sensor, a bench that stands.
const USUAL_SPEED: f64 = 5.0;

/// The ride's sensors, the first one an accelerometer.
///
/// # Errors
/// What is lacking.
pub fn gather(ride: &Ride, bike: &Bike) -> Result<Record, String> {
    let Some(speed) = ride.speed.clone() else {
        return Err("there is no speed (a column v)".to_owned());
    };
    let mut sensors: Vec<&SensorRecord> = ride.sensors.iter().collect();
    sensors.sort_by(|a, b| {
        let first = is_laser(a).cmp(&is_laser(b));
        b.rate_hz.total_cmp(&a.rate_hz).then(first)
    });
    let wheelbase_m = bike.wheelbase();
    let placed: Vec<Placed<'_>> = (sensors.iter())
        .map(|s| Placed {
            axle: s.axle,
            kind: s.kind,
            file: ride.summary.file_of(channel_name(s.kind, s.axle)),
        })
        .collect();
    if let Some(lack) = lacking(&placed, wheelbase_m.is_some()) {
        return Err(lack);
    }
    Ok(Record {
        wheelbase_m,
        ..record(ride, &sensors, speed)
    })
}

/// An axle's accelerometer and laser alone: these share the axle's motion, whatever the other axle, the speed and the wheelbase
/// are. Nothing where one of them is missing.
pub fn beside(ride: &Ride, axle: Axle) -> Option<Record> {
    let of = |laser: bool| {
        let mut on = ride.sensors.iter().filter(|s| s.axle == axle);
        on.find(|s| is_laser(s) == laser)
    };
    let rides = |speed: &&Vec<f64>| speed.iter().any(|v| *v >= SLOWEST);
    let speed = ride.speed.as_ref().filter(rides).cloned();
    let speed = speed.unwrap_or_else(|| vec![USUAL_SPEED; ride.samples]);
    Some(record(ride, &[of(false)?, of(true)?], speed))
}

fn is_laser(sensor: &SensorRecord) -> bool {
    sensor.kind == SensorKind::Deflection
}

fn record(ride: &Ride, sensors: &[&SensorRecord], speed: Vec<f64>) -> Record {
    let mut valid = vec![true; ride.samples];
    let mut made = Vec::new();
    for sensor in sensors.iter().take(MOST_SENSORS) {
        let on = |s: &&SensorRecord| s.axle == sensor.axle && !is_laser(s);
        let place = sensors.iter().position(on).filter(|_| is_laser(sensor));
        let late =
            place.and_then(|at| rough_lateness(&sensors[at].values, &sensor.values, ride.step_s));
        let late = late.unwrap_or_default();
        let (values, trusted) = moved(sensor, late, ride.step_s);
        for (all, own) in valid.iter_mut().zip(trusted) {
            *all = *all && own;
        }
        made.push(Sensor {
            axle: sensor.axle,
            kind: sensor.kind,
            values,
            known: late.plus(set_right(ride, sensor)),
            highest_hz: REACH * sensor.rate_hz,
            beside: place,
            clock_s: if is_laser(sensor) {
                OTHER_LOGGER_S
            } else {
                ONE_LOGGER_S
            },
            drift: place.map_or(0.0, |_| OTHER_DRIFT),
        });
    }
    Record {
        step_s: ride.step_s,
        speed,
        valid,
        wheelbase_m: None,
        sensors: made,
    }
}

/// How late the reader found a sensor's clock, and set it right.
fn set_right(ride: &Ride, sensor: &SensorRecord) -> Lateness {
    let name = channel_name(sensor.kind, sensor.axle);
    let clock = ride.summary.clocks.iter().find(|c| c.channel == name);
    let found = clock.and_then(|c| c.correction());
    found.map_or_else(Lateness::default, |found| Lateness {
        offset_s: found.middle_offset_s,
        drift: 1e-6 * found.drift_ppm,
    })
}

/// A sensor's values at the times at which they were taken, its clock being late, and where they may be trusted.
fn moved(sensor: &SensorRecord, late: Lateness, step_s: f64) -> (Vec<f64>, Vec<bool>) {
    if late == Lateness::default() {
        return (sensor.values.clone(), sensor.valid.clone());
    }
    let samples = sensor.values.len();
    let place = |i: usize| i as f64 + late.at(since_middle_s(i as f64, samples, step_s)) / step_s;
    let trusted = |i: usize| {
        let at = place(i);
        let ends = [at.floor(), at.ceil()];
        (ends.into_iter()).all(|i| i >= 0.0 && sensor.valid.get(i as usize) == Some(&true))
    };
    (0..samples)
        .map(|i| (interpolate(&sensor.values, place(i)), trusted(i)))
        .unzip()
}
