//! Records that hold nothing outside a band.

use super::*;
use crate::ride::{ReadOptions, read};

/// As a laser at 30 Hz and an accelerometer at 100 Hz log the default simulated ride's rear axle, with their noise.
fn laser_and_accelerometer(laser_m: f64, accelerometer_m_s2: f64) -> Vec<u8> {
    let simulated_ride = SimulatedRide {
        rate_hz: 600.0,
        front: None,
        ..SimulatedRide::default()
    };
    let motion = simulated_ride.motion().rear.unwrap();
    let mut noise = Normal::new(2);
    let mut text = "t,d_r,a_r\n".to_owned();
    for i in 0..motion.road.len() {
        let d = motion.road[i] - motion.displacement[i] + 0.35 + laser_m * noise.draw();
        let a = motion.acceleration[i] + accelerometer_m_s2 * noise.draw();
        let t = i as f64 / 600.0;
        match (i % 20, i % 6) {
            (0, 0) => text += &format!("{t:.6},{d:.9},{a:.9}\n"),
            (0, _) => text += &format!("{t:.6},{d:.9},\n"),
            (_, 0) => text += &format!("{t:.6},,{a:.9}\n"),
            _ => {}
        }
    }
    text.into_bytes()
}

/// Nothing is known outside the band, so nothing there may draw the estimates to itself.
#[test]
fn val_a_bench_with_laser_and_accelerometer_is_measured_as_by_output_error() {
    let bike = Bike {
        mass_rear_kg: Some(63.0),
        ..Bike::default()
    };
    for (laser, accelerometer) in [(0.0, 0.0), (1e-4, 0.05), (3e-4, 0.3)] {
        let file = laser_and_accelerometer(laser, accelerometer);
        let ride = read(&file, "bench.csv", &bike, &ReadOptions::default()).unwrap();
        let settings = Settings {
            trials: 1,
            iterations: 2,
            ..Settings::default()
        };
        let report = crate::identify(&ride, &bike, &settings, &Silent).unwrap();
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
