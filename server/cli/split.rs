//! A simulated ride as several loggers write it, each into a file of its own with time stamps that begin when it was started.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use veloid_engine::ride::{Ride, channel_name};
use veloid_engine::simulate::laser::{Laser, Logged};

/// Rate of the speed's file (Hz).
const SPEED_HZ: f64 = 1.0;

/// What each file holds, by what its name ends with: `accelerometers`, `laser-rear`, `speed`.
pub fn files(ride: &Ride, lasers: &[Laser], logged: &[Logged]) -> Vec<(String, String)> {
    // A logger whose clock reads more was started earlier; the ride begins for the first of them.
    let started_s = lasers
        .iter()
        .map(|laser| laser.offset_s)
        .fold(0.0, f64::max);
    let mut files = vec![("accelerometers".to_owned(), accelerometers(ride, started_s))];
    for (laser, logged) in lasers.iter().zip(logged) {
        let name = format!("laser-{}", laser.axle.name());
        files.push((name, of_laser(laser, logged, started_s - laser.offset_s)));
    }
    if let Some(speed) = &ride.speed {
        files.push(("speed".to_owned(), of_speed(ride, speed, started_s)));
    }
    files
}

/// `ride.csv` and `speed` as `ride-speed.csv`.
pub fn beside(path: &Path, name: &str) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let ending = path.extension().unwrap_or_default().to_string_lossy();
    path.with_file_name(match ending.is_empty() {
        true => format!("{stem}-{name}"),
        false => format!("{stem}-{name}.{ending}"),
    })
}

fn accelerometers(ride: &Ride, from_s: f64) -> String {
    let names: Vec<&str> = (ride.sensors.iter())
        .map(|s| channel_name(s.kind, s.axle))
        .collect();
    let mut csv = format!("t,{}\n", names.join(","));
    for i in (0..ride.samples).filter(|i| ride.time_s(*i) >= from_s) {
        let _ = write!(csv, "{:.6}", ride.time_s(i) - from_s);
        for sensor in &ride.sensors {
            let _ = write!(csv, ",{:?}", sensor.values[i]);
        }
        csv.push('\n');
    }
    csv
}

/// From a time of the ride on.
fn of_laser(laser: &Laser, logged: &Logged, from_s: f64) -> String {
    let mut csv = format!("t,{}\n", logged.channel);
    let started_s = laser.offset_s + from_s * (1.0 + 1e-6 * laser.drift_ppm);
    for (stamp, value) in logged.stamps_s.iter().zip(&logged.values) {
        if *stamp >= started_s {
            let _ = writeln!(csv, "{:.6},{value:?}", stamp - started_s);
        }
    }
    csv
}

fn of_speed(ride: &Ride, speed: &[f64], from_s: f64) -> String {
    let mut csv = "t,v\n".to_owned();
    let every = (1.0 / (SPEED_HZ * ride.step_s)).round().max(1.0) as usize;
    let first = (from_s / ride.step_s).ceil() as usize;
    for i in (first..ride.samples).step_by(every) {
        let _ = writeln!(csv, "{:.6},{:?}", ride.time_s(i) - from_s, speed[i]);
    }
    csv
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use veloid_engine::bicycle::Axle;
    use veloid_engine::simulate::simulated_ride::SimulatedRide;

    use super::*;

    #[test]
    fn every_logger_begins_at_its_own_zero() {
        let simulated_ride = SimulatedRide {
            duration_s: 10.0,
            ..SimulatedRide::default()
        };
        let laser = |axle, offset_s| Laser {
            axle,
            noise_m: 0.0,
            offset_s,
            drift_ppm: 200.0,
            rate_hz: 30.0,
        };
        let lasers = [laser(Axle::Front, 1.5), laser(Axle::Rear, -0.5)];
        let logged: Vec<Logged> = lasers
            .iter()
            .map(|l| l.logged(&simulated_ride).unwrap())
            .collect();
        let ride = simulated_ride.sensed(0.03).unwrap();
        let files = files(&ride, &lasers, &logged);
        let first = |i: usize| -> f64 {
            let row = files[i].1.lines().nth(1).unwrap();
            row.split(',').next().unwrap().parse().unwrap()
        };
        let names: Vec<&str> = files.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(
            names,
            ["accelerometers", "laser-front", "laser-rear", "speed"]
        );
        assert!((0..4).all(|i| (0.0..0.04).contains(&first(i))));
        // The front laser was on from the beginning, the rear one 2 s later, the accelerometers 1.5 s.
        let rows = |i: usize| files[i].1.lines().count() - 1;
        assert_eq!([rows(0), rows(1), rows(2), rows(3)], [851, 301, 240, 9]);
    }

    #[test]
    fn files_stand_beside_the_ride() {
        let path = |text: &str| beside(Path::new(text), "speed");
        assert_eq!(path("a/ride.csv"), Path::new("a/ride-speed.csv"));
        assert_eq!(path("ride"), Path::new("ride-speed"));
    }
}
