//! Whole identifications of rides whose clocks and values no logger writes: each ends with a report or a reason, and
//! what it computes is bounded by its samples.
#![allow(clippy::unwrap_used)]

use std::fmt::Write as _;
use std::sync::atomic::{AtomicUsize, Ordering};

use proptest::prelude::*;
use proptest::sample::select;

use crate::pipeline::identify::identify;
use veloid_core::Progress;
use veloid_core::bicycle::Bike;
use veloid_core::settings::Settings;
use veloid_methods::simulate::simulated_ride::SimulatedRide;
use veloid_ride::{RATES_HZ, ReadOptions, Ride, read};

fn settings(diagnosis: bool) -> Settings {
    Settings {
        trials: 2,
        particles: 4,
        iterations: 3,
        diagnosis,
        ..Settings::default()
    }
}

/// Counts what the swarm is asked for.
#[derive(Default)]
struct Counted(AtomicUsize);

impl Progress for Counted {
    fn iteration(&self, _: usize, _: usize, _: f64) {
        self.0.fetch_add(1, Ordering::Relaxed);
    }
}

/// A report, or a reason that fits on a screen.
fn ends(ride: &Ride, bike: &Bike, diagnosis: bool) {
    let counted = Counted::default();
    let settings = settings(diagnosis);
    match identify(ride, bike, &settings, &counted) {
        Ok(report) => assert_eq!(report.ride, ride.summary),
        Err(error) => assert!((1..1000).contains(&error.to_string().len()), "{error}"),
    }
    assert!(counted.0.into_inner() <= settings.trials * settings.iterations);
}

/// How a table of so many rows is filled.
#[derive(Clone, Debug)]
struct Table {
    rows: usize,
    unit: &'static str,
    start: f64,
    step: f64,
    /// Every so many rows a step is multiplied by this.
    every: usize,
    pause: f64,
    /// Every so many rows a cell is blank; and a column begins at this row.
    blank: usize,
    late: usize,
    columns: &'static [&'static str],
    sizes: Vec<f64>,
    shapes: Vec<u8>,
}

impl Table {
    fn text(&self) -> String {
        let mut text = format!("t [{}],{}\n", self.unit, self.columns.join(","));
        let mut t = self.start;
        for i in 0..self.rows {
            let _ = write!(text, "{t:e}");
            t += self.step * if i % self.every == 1 { self.pause } else { 1.0 };
            for (c, name) in self.columns.iter().enumerate() {
                let blank =
                    i % self.blank == c + 1 || *name == "v" && i < self.late.min(self.rows - 2);
                let cell = (!blank).then(|| format!("{:e}", self.value(c, i)));
                let _ = write!(text, ",{}", cell.unwrap_or_default());
            }
            text.push('\n');
        }
        text
    }

    fn value(&self, column: usize, i: usize) -> f64 {
        let x = i as f64;
        let shape = match self.shapes[column % self.shapes.len()] {
            0 => (0.3 * x + column as f64).sin() + 0.5 * (0.71 * x).sin(),
            1 => (0.9 * x).sin() * (-0.05 * x).exp(),
            2 => f64::from(i == self.rows / 2),
            3 => {
                if i.is_multiple_of(2) {
                    1.0
                } else {
                    -1.0
                }
            }
            4 => x * x,
            _ => 1.0 + ((i * 7919 + column * 104_729) % 1013) as f64 / 1013.0,
        };
        self.sizes[column % self.sizes.len()] * shape
    }
}

/// One of the usual values, and now and then a strange one.
fn mostly<T: Clone + std::fmt::Debug + 'static>(
    usual: &[T],
    strange: &[T],
) -> impl Strategy<Value = T> {
    prop_oneof![4 => select(usual.to_vec()), 1 => select(strange.to_vec())]
}

fn tables() -> impl Strategy<Value = Table> {
    let clock = (
        mostly(&["s"], &["ms", "us", "ns", "min"]),
        mostly(&[0.0, 12.5], &[-1e9, 1.7e9, 1e15]),
        mostly(
            &[0.01, 0.01, 0.2, 1e-4],
            &[
                1e-323, 1e-300, 1e-20, 1e-13, 1e-11, 1e-7, 1e-6, 10.0, 1000.0, 1001.0, 3.2e7, 1e12,
                1e300,
            ],
        ),
        mostly(&[1000_usize], &[50, 9, 2]),
        mostly(&[1.4, 3.0], &[1e-9, 1e-3, 1e5, 3.2e9]),
    );
    let cells = (
        mostly(&[1000_usize], &[7, 3]),
        mostly(&[0_usize], &[40, 1000]),
        select(vec![
            &["u_f", "z_f"][..],
            &["u_f", "z_f", "v", "z_r"],
            &["force_f", "z_f", "v"],
            &["z_f"],
            &["d_f", "a_f", "v"],
            &[
                "u_f", "z_f", "u_r", "z_r", "v", "cadence", "yaw_rate", "steer",
            ],
        ]),
        prop::collection::vec(
            mostly(
                &[1e-3, 0.01, 1.0],
                &[1e-323, 1e-300, 1e-150, 1e-12, 1e6, 1e14, 1e300],
            ),
            1..4,
        ),
        prop::collection::vec(0u8..6, 1..5),
    );
    (60usize..160, clock, cells).prop_map(
        |(rows, (unit, start, step, every, pause), (blank, late, columns, sizes, shapes))| Table {
            rows,
            unit,
            start,
            step,
            every,
            pause,
            blank,
            late,
            columns,
            sizes,
            shapes,
        },
    )
}

fn bikes() -> impl Strategy<Value = Bike> {
    let mass = || mostly(&[Some(23.0)], &[Some(0.1), Some(1000.0), None]);
    let length = || mostly(&[Some(0.5)], &[Some(0.01), Some(5.0), None]);
    (
        mass(),
        mass(),
        length(),
        select(vec![0.02, 0.34, 2.0]),
        any::<bool>(),
    )
        .prop_map(|(front, rear, length, radius, equal_axles)| Bike {
            mass_front_kg: front,
            mass_rear_kg: rear,
            l_front_m: length,
            l_rear_m: length,
            wheel_radius_front_m: Some(radius),
            wheel_radius_rear_m: Some(radius),
            equal_axles,
            ..Bike::default()
        })
}

fn options() -> impl Strategy<Value = ReadOptions> {
    let band = select(vec![None, None, Some((0.01, 1e6)), Some((0.5, 0.6))]);
    let rows = select(vec![None, None, Some((5, 1_000_000)), Some((0, 70))]);
    (band, rows, any::<bool>()).prop_map(|(band_hz, rows, back)| ReadOptions {
        band_hz,
        rows,
        deflection_sign: if back { -1.0 } else { 1.0 },
        ..ReadOptions::default()
    })
}

/// Reads and identifies, whatever comes of it; what is read lies on a clock in range and is no longer than its file.
fn whole(table: &Table, bike: &Bike, options: &ReadOptions, diagnosis: bool) {
    match read(table.text().as_bytes(), "ride.csv", bike, options) {
        Ok(ride) => {
            assert!(RATES_HZ.contains(&(1.0 / ride.step_s)), "{} s", ride.step_s);
            assert!(ride.samples <= 2 * table.rows, "{} samples", ride.samples);
            ends(&ride, bike, diagnosis);
        }
        Err(error) => assert!((1..1000).contains(&error.to_string().len()), "{error}"),
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn hostile_clocks_and_values_end(table in tables(), bike in bikes(), options in options()) {
        whole(&table, &bike, &options, false);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn hostile_clocks_and_values_are_diagnosed_or_refused(table in tables(), bike in bikes(), options in options()) {
        let table = Table { step: 0.01, unit: "s", start: 0.0, ..table };
        whole(&table, &bike, &options, true);
    }
}

/// What no reader lets through any more, straight into the engine.
#[test]
fn no_step_asks_for_more_than_the_samples_hold() {
    let ride = SimulatedRide {
        duration_s: 2.0,
        ..SimulatedRide::default()
    }
    .ride();
    let bike = Bike {
        mass_front_kg: Some(23.0),
        mass_rear_kg: Some(63.0),
        ..Bike::default()
    };
    for step_s in [1e-20, 1e-13, 1e-11, 1e-6, 1e3, 3.2e7, 1e12] {
        let ride = Ride {
            step_s,
            ..ride.clone()
        };
        ends(&ride, &bike, false);
    }
}

/// Each is refused where it stands, with its step and the range.
#[test]
fn clocks_beyond_the_range_are_refused() {
    let table = |columns: &str, time: &dyn Fn(usize) -> String| {
        let row = |i: usize| format!("{},{}\n", time(i), (0.3 * i as f64).sin());
        format!("{columns}\n{}", (0..100).map(row).collect::<String>())
    };
    let refused = |text: String, options: &ReadOptions| {
        let e = read(text.as_bytes(), "ride.csv", &Bike::default(), options).unwrap_err();
        (e.kind(), e.to_string())
    };
    let plain = ReadOptions::default();
    for (header, scale, shown) in [
        ("t", 1e-13, "1e-13 s"),
        ("t", 1e-11, "1e-11 s"),
        ("t", 1e-20, "1e-20 s"),
        ("t [ns]", 1.0, "1e-9 s"),
        ("t [us]", 0.5, "5e-7 s"),
        ("t", 1001.0, "1.001e3 s"),
        ("t [min]", 525_600.0, "3.1536e7 s"),
    ] {
        let text = table(&format!("{header},z_f"), &|i| {
            format!("{:e}", i as f64 * scale)
        });
        let (kind, said) = refused(text, &plain);
        assert_eq!(kind, "rate-out-of-range", "{said}");
        assert!(said.contains(&format!("column 1 ({header})")), "{said}");
        assert!(said.contains("0.001 Hz to 1000000 Hz"), "{said}");
        let step: f64 = shown.trim_end_matches(" s").parse().unwrap();
        let found = said
            .split("every ")
            .nth(1)
            .unwrap()
            .split(' ')
            .next()
            .unwrap();
        assert!(
            (found.parse::<f64>().unwrap() / step - 1.0).abs() < 1e-6,
            "{said}"
        );
    }
    for rate in [1e-10, 9.9e-4, 1.1e6, f64::INFINITY, f64::NAN] {
        let options = ReadOptions {
            rate_hz: Some(rate),
            ..ReadOptions::default()
        };
        let (kind, said) = refused(table("x,z_f", &|i| i.to_string()), &options);
        assert!(
            kind == "bad-option" && said.contains("0.001 Hz to 1000000 Hz"),
            "{said}"
        );
    }
    // A channel that is there once a month has a clock of its own.
    let month = |i: usize| {
        let v = if i.is_multiple_of(50) { "1" } else { "" };
        format!("{},{},{v}\n", i as f64 * 900.0, (0.3 * i as f64).sin())
    };
    let text = format!("t,z_f,v\n{}", (0..120).map(month).collect::<String>());
    let (kind, said) = refused(text, &plain);
    assert!(
        kind == "rate-out-of-range" && said.contains("column 3 (v)"),
        "{said}"
    );
}

/// Inside the range and no rate of a ride: reported with the header's unit and the rate.
#[test]
fn rates_that_no_ride_has_are_doubted() {
    let warned = |header: &str, step: f64, rate_hz: Option<f64>| {
        let row = |i: usize| {
            format!(
                "{},{}\n",
                i as f64 * step,
                (0.3 * i as f64).sin() * (-0.02 * i as f64).exp()
            )
        };
        let text = format!("{header},z_f\n{}", (0..200).map(row).collect::<String>());
        let options = ReadOptions {
            rate_hz,
            ..ReadOptions::default()
        };
        let ride = read(text.as_bytes(), "ride.csv", &Bike::default(), &options).unwrap();
        let doubts = ride
            .summary
            .warnings
            .into_iter()
            .filter(|w| w.contains("is its unit right?"));
        doubts.collect::<Vec<_>>()
    };
    let said = warned("t [us]", 4.0, None);
    assert!(
        said[0].contains("t [us], read in us, gives 250000 samples a second"),
        "{said:?}"
    );
    let said = warned("t", 10.0, None);
    assert!(
        said[0].contains("t, read in s, gives 0.1 samples a second"),
        "{said:?}"
    );
    assert!(warned("x", 1.0, Some(1e5))[0].contains("rate_hz gives 100000 samples"));
    for (header, step) in [("t", 0.2), ("t", 0.01), ("t [us]", 20.0), ("t [ms]", 10.0)] {
        assert!(warned(header, step, None).is_empty(), "{header} {step}");
    }
}

/// A speed logged a million times faster than the displacement: brought to its clock in as many steps as it has
/// samples, not in those times the ratio of the rates (10^12 here, which nobody waits for).
#[test]
fn a_channel_far_faster_than_the_others_costs_its_samples() {
    let fast = (0..1000).map(|i| format!("{:e},,,{}\n", i as f64 * 1e-6, 5.0 + 1e-3 * i as f64));
    let slow = (0..20_000).map(|i| {
        let x = 0.3 * i as f64;
        format!("{},{},{},\n", 1.0 + i as f64, x.sin(), (x - 0.1).sin())
    });
    let text = format!(
        "t,u_f,z_f,v\n{}{}",
        fast.collect::<String>(),
        slow.collect::<String>()
    );
    let options = ReadOptions::default();
    let ride = read(text.as_bytes(), "ride.csv", &Bike::default(), &options).unwrap();
    assert!(ride.speed.unwrap().iter().all(|v| v.is_finite()));
}
