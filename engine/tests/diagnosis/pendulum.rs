//! A pendulum with drag: its sine is no law of the library, and what stands in for the last of it is a tie.

use super::*;
use veloid_ride::{ReadOptions, read};

const RATE: f64 = 100.0;
const SECONDS: f64 = 60.0;
const FINE: usize = 50;
const DRAG: f64 = 0.06;

/// A swing of 2 s from 0.8 rad, read with 1.6 mrad of noise.
fn swing(seed: u64) -> String {
    let mut noise = Normal::new(seed);
    let (mut z, mut v) = (0.8_f64, 0.0_f64);
    let h = 1.0 / (RATE * FINE as f64);
    let square = (TAU / 2.0).powi(2);
    let row = |i: usize| {
        let row = format!("{},{:.7}\n", i as f64 / RATE, z + 1.6e-3 * noise.draw());
        for _ in 0..FINE {
            v -= h * (square * z.sin() + 0.004 * v + DRAG * v * v.abs());
            z += h * v;
        }
        row
    };
    let rows: String = (0..(SECONDS * RATE) as usize).map(row).collect();
    format!("t,z_f\n{rows}")
}

#[test]
#[ignore = "slow"]
fn softening_and_drag_are_reported_whatever_else_ties() {
    let bike = Bike {
        mass_front_kg: Some(1.0),
        ..Bike::default()
    };
    for seed in 12..=15 {
        let ride = read(
            swing(seed).as_bytes(),
            "swing.csv",
            &bike,
            &ReadOptions::default(),
        );
        let d = diagnosed_on(&ride.unwrap(), &bike);
        let reported = |id: &str| {
            let effect = d.effects.iter().find(|e| e.id == id && e.affirmed);
            effect.unwrap_or_else(|| panic!("{seed}, {id}: {}", d.sentence))
        };
        let drag = reported("quadratic_damping").parameters["c2"].value;
        assert!((drag / DRAG - 1.0).abs() < 0.03, "{seed}: {drag}");
        // The sine's own cube, and a little for its fifth power.
        let cube = reported("cubic_stiffness").parameters["k3"].value;
        let sine = -(TAU / 2.0).powi(2) / 6.0;
        assert!((cube / sine - 1.0).abs() < 0.06, "{seed}: {cube}");
        let affirmed = d.effects.iter().filter(|e| e.affirmed).count();
        assert_eq!(affirmed, 2, "{seed}: {}", d.sentence);
    }
}
