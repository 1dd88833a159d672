//! Records that hold nothing outside a band.

use super::*;
use std::collections::BTreeMap;

use veloid_methods::simulate::road::Roughness;
use veloid_ride::{Content, ReadOptions, RideFile};

/// A ride of the rear axle alone, every 1/600 s.
fn fine(excitation: Excitation, speed_m_s: f64) -> SimulatedRide {
    SimulatedRide {
        rate_hz: 600.0,
        front: None,
        excitation,
        speed_m_s,
        ..SimulatedRide::default()
    }
}

fn road(class: Roughness) -> Excitation {
    Excitation::Road {
        roughness: Some(class),
        bumps: Vec::new(),
    }
}

/// As a laser at 30 Hz and an accelerometer at 100 Hz log a road, a motion and its acceleration, with their noise.
fn laser_and_accelerometer(
    [road, motion, acceleration]: [&[f64]; 3],
    laser_m: f64,
    accelerometer_m_s2: f64,
) -> Ride {
    let mut noise = Normal::new(2);
    let mut text = "t,d_r,a_r\n".to_owned();
    for i in 0..road.len() {
        let d = road[i] - motion[i] + 0.35 + laser_m * noise.draw();
        let a = acceleration[i] + accelerometer_m_s2 * noise.draw();
        let t = i as f64 / 600.0;
        match (i % 20, i % 6) {
            (0, 0) => text += &format!("{t:.6},{d:.9},{a:.9}\n"),
            (0, _) => text += &format!("{t:.6},{d:.9},\n"),
            (_, 0) => text += &format!("{t:.6},,{a:.9}\n"),
            _ => {}
        }
    }
    let file = RideFile {
        name: "bench.csv",
        content: Content::Bytes(text.as_bytes()),
    };
    // By the pipeline, which finds out how much noise the laser has.
    veloid_engine::read(&[file], &bike(), &ReadOptions::default()).unwrap()
}

fn bike() -> Bike {
    Bike {
        mass_rear_kg: Some(63.0),
        ..Bike::default()
    }
}

fn identified(ride: &Ride) -> Report {
    let settings = Settings {
        trials: 1,
        iterations: 2,
        ..Settings::default()
    };
    veloid_engine::identify(ride, &bike(), &settings, &Silent).unwrap()
}

/// Nothing is known outside the band, so nothing there may draw the estimates to itself.
#[test]
fn val_a_bench_with_laser_and_accelerometer_is_measured_as_by_output_error() {
    let simulated_ride = fine(road(Roughness::C), 3.0);
    let motion = simulated_ride.motion().rear.unwrap();
    let channels = [&motion.road[..], &motion.displacement, &motion.acceleration];
    for (laser, accelerometer) in [(1e-5, 0.003), (1e-4, 0.05)] {
        let report = identified(&laser_and_accelerometer(channels, laser, accelerometer));
        let d = report.diagnosis.unwrap();
        assert_eq!(
            d.verdict,
            Verdict::NothingMissing,
            "{laser}: {}",
            d.sentence
        );
        let (plain, extended) = (report.output_error.rear.unwrap(), d.extended.rear.unwrap());
        let near = |a: f64, b: f64, share: f64| (a / b - 1.0).abs() < share;
        let reported = format!("{laser}: {plain:?} {extended:?}");
        assert!(near(extended.k_n_m, plain.k_n_m, 0.01), "{reported}");
        assert!(near(extended.b_n_s_m, plain.b_n_s_m, 0.03), "{reported}");
        assert!(near(extended.k_n_m, 110e3, 0.02), "{reported}");
        assert!(extended.k_std_n_m.unwrap() < 0.02 * 110e3, "{reported}");
        let c = d.consequences.rear.unwrap();
        let loads = [c.peak_load_plain_n, c.peak_load_extended_n].map(Option::unwrap);
        assert!(near(loads[0], loads[1], 0.05), "{laser}: {loads:?}");
        assert!(loads[1] < 20e3, "{laser}: {loads:?}");
        assert_eq!(d.held_out.rear.unwrap().noise_floor_m, None);
    }
}

/// What an effect makes beyond the band is not held against it.
#[test]
fn val_friction_and_a_quadratic_damper_on_such_a_bench_have_names() {
    for (id, parameter, value) in [
        ("coulomb_friction", "friction", 60.0),
        ("quadratic_damping", "c2", 1500.0),
    ] {
        let effect = impose::Imposed {
            id: id.to_owned(),
            axle: Place::Rear,
            parameters: BTreeMap::from([(parameter.to_owned(), value)]),
        };
        let ride = impose::ride(&fine(road(Roughness::D), 3.0), &bike(), &[effect]).unwrap();
        let record = ride.axles.rear.unwrap();
        let z = &record.displacement;
        let mut acceleration = vec![0.0; z.len()];
        for i in 1..z.len() - 1 {
            acceleration[i] = (z[i + 1] - 2.0 * z[i] + z[i - 1]) * 600.0 * 600.0;
        }
        let channels = [&record.road[..], z, &acceleration];
        let report = identified(&laser_and_accelerometer(channels, 2e-4, 0.03));
        let d = report.diagnosis.unwrap();
        let [found] = &d.effects[..] else {
            panic!("{id}: {}", d.sentence);
        };
        assert_eq!(
            (found.id.as_str(), d.verdict),
            (id, Verdict::Named),
            "{}",
            d.sentence
        );
        let found = found.parameters[parameter].value;
        assert!((found / value - 1.0).abs() < 0.15, "{id}: {found}");
    }
}
