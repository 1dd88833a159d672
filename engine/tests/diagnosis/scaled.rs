//! The same record in other units of time and length has the same verdict: a pendulum that swings once in ten seconds and a
//! beam that rings at 60 Hz are as good a bench as a bicycle.

use super::*;
use veloid_ride::{ReadOptions, read};

/// Samples of a swing, and swings.
const SAMPLES: usize = 60;
const SWINGS: usize = 100;

/// A free decay with dry friction: k/m = (2 pi)^2 in units of its period, damping ratio 0.002.
fn decay() -> Vec<f64> {
    const FINE: usize = 20;
    let mut noise = Normal::new(15);
    let h = 1.0 / (SAMPLES * FINE) as f64;
    let (mut z, mut v) = (1.0, 0.0);
    (0..SAMPLES * SWINGS)
        .map(|_| {
            let read = z + 2e-3 * noise.draw();
            for _ in 0..FINE {
                let friction = 0.06 * (v / 0.02_f64).tanh();
                v -= h * (TAU * TAU * z + 2.0 * 0.002 * TAU * v + friction);
                z += h * v;
            }
            read
        })
        .collect()
}

#[test]
#[ignore = "slow"]
fn units_change_no_verdict() {
    let decay = decay();
    for (period, size) in [(0.15, 1e-3), (10.0, 1.0), (0.016, 1.0), (0.15, 1e3)] {
        let step = period / SAMPLES as f64;
        let row = |(i, z): (usize, &f64)| format!("{:e},{:e}\n", step * i as f64, size * z);
        let rows: String = decay.iter().enumerate().map(row).collect();
        let text = format!("t,z_f\n{rows}");
        let bike = Bike {
            mass_front_kg: Some(1.0),
            ..Bike::default()
        };
        let ride = read(text.as_bytes(), "decay.csv", &bike, &ReadOptions::default()).unwrap();
        let d = diagnosed_on(&ride, &bike);
        let found: Vec<&str> = d.effects.iter().map(|e| e.id.as_str()).collect();
        let verdict = (d.verdict, found);
        assert_eq!(
            verdict,
            (Verdict::Named, vec!["coulomb_friction"]),
            "{period} s, {size}: {}",
            d.sentence
        );
        let friction = &d.effects[0].parameters["friction"];
        let of_one = period * period / size;
        let error = (friction.value * of_one - 0.06).abs();
        assert!(
            error < 4.0 * of_one * friction.std_error.unwrap(),
            "{friction:?}"
        );
    }
}
