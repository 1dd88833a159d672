//! Errors and coverage over many rides, for docs/latent-road.md:
//!
//!     SEEDS=200 cargo test --workspace --lib latent_road::measured -- --ignored --nocapture
//!
//! The roads are Gaussian (integrated white noise, seen through a contact patch) and reach beyond the band; the speed is reported
//! once a second.
#![allow(clippy::unwrap_used)]

use std::f64::consts::{PI, TAU};
use std::time::Instant;

use super::latent_road;
use veloid_core::bicycle::{Axle, Bike};
use veloid_core::numerics::random::Normal;
use veloid_core::numerics::spline::{cubic, slopes};
use veloid_methods::simulate::linear::{Input, simulate};
use veloid_methods::simulate::road::Roughness;
use veloid_report::Estimate;
use veloid_ride::{Ride, SensorKind, SensorRecord};

/// How a ride goes and what its sensors do.
#[derive(Clone, Copy)]
struct Case {
    name: &'static str,
    class: Roughness,
    speed: f64,
    /// Share by which the speed swings, over 20 s.
    swing: f64,
    /// Accelerometers' noise (m/s^2).
    noise: f64,
    /// Largest share by which the speed is off, and deviation of each second's (m/s).
    off: f64,
    jitter: f64,
    gain: f64,
    late_s: f64,
    bumps: bool,
}

const PLAIN: Case = Case {
    name: "class C, 5 m/s",
    class: Roughness::C,
    speed: 5.0,
    swing: 0.0,
    noise: 0.03,
    off: 0.0,
    jitter: 0.0,
    gain: 1.0,
    late_s: 0.0,
    bumps: false,
};

#[rustfmt::skip]
const CASES: [Case; 10] = [
    PLAIN,
    Case { name: "class A, 4 m/s +-20 %, 0.1 m/s^2", class: Roughness::A, speed: 4.0, swing: 0.2, noise: 0.1, ..PLAIN },
    Case { name: "class B, 5 m/s +-20 %, 0.1 m/s^2", class: Roughness::B, swing: 0.2, noise: 0.1, ..PLAIN },
    Case { name: "class C, 6 m/s +-20 %, 0.1 m/s^2", speed: 6.0, swing: 0.2, noise: 0.1, ..PLAIN },
    Case { name: "class C, 3 m/s +-20 %", speed: 3.0, swing: 0.2, ..PLAIN },
    Case { name: "class D, 8 m/s +-20 %, 0.1 m/s^2", class: Roughness::D, speed: 8.0, swing: 0.2, noise: 0.1, ..PLAIN },
    Case { name: "speed up to 2 % off, +-0.05 m/s", swing: 0.1, off: 0.02, jitter: 0.05, ..PLAIN },
    Case { name: "speed +-0.1 m/s each second", swing: 0.1, jitter: 0.1, ..PLAIN },
    Case { name: "rear 3 % loud and 2 ms late", swing: 0.1, gain: 1.03, late_s: 0.002, ..PLAIN },
    Case { name: "bumps of some 1 cm every 10 m", swing: 0.1, bumps: true, ..PLAIN },
];

const WHEELBASE: f64 = 1.101;
const DURATION_S: f64 = 60.0;
/// The simulation's rate beside the logger's 100 Hz.
const FINE: usize = 8;
/// Spacing of the road's heights (m), and width of the contact patch (m, Gaussian).
const SPACING: f64 = 0.005;
const PATCH: f64 = 0.03;
/// k/m (1/s^2), B/m (1/s), m (kg).
const TRUE: [[f64; 3]; 2] = [[110e3, 1150.0, 23.0], [95e3, 900.0, 63.0]];

impl Case {
    fn speed_at(&self, t: f64) -> f64 {
        self.speed * (1.0 + self.swing * (TAU * t / 20.0).sin())
    }

    fn ridden(&self, t: f64) -> f64 {
        let swung = self.swing * 20.0 / TAU * (1.0 - (TAU * t / 20.0).cos());
        self.speed * (t + swung)
    }

    /// Heights every [`SPACING`].
    fn road(&self, random: &mut Normal) -> Vec<f64> {
        let length = self.ridden(DURATION_S) + 3.0 * WHEELBASE + 4.0;
        let step = self.class.psd_m3() * 0.01 * 2.0 * PI * PI * SPACING;
        let mut height = 0.0;
        let mut raw: Vec<f64> = (0..(length / SPACING) as usize)
            .map(|_| {
                height = height * (1.0 - SPACING / 50.0) + step.sqrt() * random.draw();
                height
            })
            .collect();
        if self.bumps {
            let mut at = 0.0;
            while at < length - 1.0 {
                let tall = 0.01 * random.draw();
                for i in 0..40 {
                    raw[(at / SPACING) as usize + i] += tall * (PI * i as f64 / 40.0).sin();
                }
                at += 10.0 * (0.5 + random.draw().abs());
            }
        }
        let weights: Vec<f64> = (-24..=24)
            .map(|k| (-0.5 * (f64::from(k) * SPACING / PATCH).powi(2)).exp())
            .collect();
        filtered(&raw, &weights, 1)
    }

    fn ride(&self, seed: u64) -> Ride {
        let mut random = Normal::new(1000 + seed);
        let road = self.road(&mut random);
        let slope = slopes(&road, SPACING);
        let height = |x: f64| {
            let place = x / SPACING;
            let i = place as usize;
            let c = cubic(road[i], road[i + 1], slope[i], slope[i + 1], SPACING);
            let s = place - i as f64;
            c[0] + s * (c[1] + s * (c[2] + s * c[3]))
        };
        let fine_step = 0.01 / FINE as f64;
        let count = (DURATION_S / fine_step) as usize + 1;
        let mut sensors = Vec::new();
        for (axle, [k, b, m]) in Axle::BOTH.into_iter().zip(TRUE) {
            let (behind, late, gain) = match axle {
                Axle::Front => (0.0, 0.0, 1.0),
                Axle::Rear => (WHEELBASE, self.late_s, self.gain),
            };
            let u: Vec<f64> = (0..count)
                .map(|i| {
                    height(self.ridden(i as f64 * fine_step - late) + 1.5 * WHEELBASE - behind)
                })
                .collect();
            let input = Input::new(&u, None, fine_step);
            let (kappa, beta) = (k / m, b / m);
            let (z, v) = simulate(&input, kappa, beta, 1.0, 0.0, [u[0], 0.0]);
            let a: Vec<f64> = (0..count)
                .map(|i| kappa * (u[i] - z[i]) + beta * (input.road_slope[i] - v[i]))
                .collect();
            let values = filtered(&a, &anti_alias(), FINE);
            sensors.push(SensorRecord {
                axle,
                kind: SensorKind::Acceleration,
                valid: vec![true; values.len()],
                values: (values.iter())
                    .map(|a| gain * a + self.noise * random.draw())
                    .collect(),
                rate_hz: 100.0,
                first_s: 0.0,
            });
        }
        let samples = sensors[0].values.len();
        // From -1 to 1 over the seeds.
        let off = 1.0 + self.off * (seed as f64 * 0.618).fract().mul_add(2.0, -1.0);
        Ride {
            step_s: 0.01,
            samples,
            sensors,
            speed: Some(self.recorded_speed(off, samples, &mut random)),
            ..Ride::default()
        }
    }

    /// The speed once a second, with a spline through it.
    fn recorded_speed(&self, off: f64, samples: usize, random: &mut Normal) -> Vec<f64> {
        let reported: Vec<f64> = (0..=DURATION_S as usize + 1)
            .map(|s| off * self.speed_at(s as f64) + self.jitter * random.draw())
            .collect();
        let slope = slopes(&reported, 1.0);
        (0..samples)
            .map(|i| {
                let (s, part) = (i / 100, (i % 100) as f64 * 0.01);
                let c = cubic(reported[s], reported[s + 1], slope[s], slope[s + 1], 1.0);
                c[0] + part * (c[1] + part * (c[2] + part * c[3]))
            })
            .collect()
    }
}

/// Low-pass at 42 Hz of what comes at [`FINE`] times 100 Hz.
fn anti_alias() -> Vec<f64> {
    let share = 42.0 * 0.01 / FINE as f64;
    (-160..=160)
        .map(|k| {
            let x = f64::from(k);
            let sinc = if k == 0 {
                2.0 * share
            } else {
                (TAU * share * x).sin() / (PI * x)
            };
            sinc * (0.5 * PI * x / 161.0).cos().powi(2)
        })
        .collect()
}

/// Every `thin`th weighted mean of `values`.
fn filtered(values: &[f64], weights: &[f64], thin: usize) -> Vec<f64> {
    let (reach, last) = (weights.len() as isize / 2, values.len() as isize - 1);
    let sum: f64 = weights.iter().sum();
    (0..values.len())
        .step_by(thin)
        .map(|i| {
            let at = |k: usize| values[(i as isize + k as isize - reach).clamp(0, last) as usize];
            let mean: f64 = weights.iter().enumerate().map(|(k, w)| w * at(k)).sum();
            mean / sum
        })
        .collect()
}

/// Errors (%) of k and B of both axles, and whether the 95 % intervals hold the truth.
fn score(found: [&Estimate; 2]) -> [(f64, bool); 4] {
    let mut out = [(f64::NAN, false); 4];
    for (axle, (e, [k, b, _])) in found.into_iter().zip(TRUE).enumerate() {
        for (q, (value, std, truth)) in [(e.k_n_m, e.k_std_n_m, k), (e.b_n_s_m, e.b_std_n_s_m, b)]
            .into_iter()
            .enumerate()
        {
            let inside = std.is_some_and(|s| (value - truth).abs() < 1.96 * s);
            out[2 * axle + q] = (100.0 * (value / truth - 1.0), inside);
        }
    }
    out
}

#[test]
#[ignore = "takes minutes; prints the table of docs/latent-road.md"]
fn errors_and_coverage() {
    let seeds: u64 = std::env::var("SEEDS")
        .ok()
        .and_then(|s| s.parse().ok())
        .unwrap_or(20);
    let bike = Bike {
        mass_front_kg: Some(TRUE[0][2]),
        mass_rear_kg: Some(TRUE[1][2]),
        l_front_m: Some(0.808),
        l_rear_m: Some(0.293),
        ..Bike::default()
    };
    println!(
        "| {seeds} rides of 60 s each | median error k_F, B_F, k_R, B_R (%) | 90 % within | intervals hold | class right | no interval | time (s) |\n|---|---|---|---|---|---|---|"
    );
    for case in CASES {
        let (mut scores, mut right, mut without, mut seconds) = (Vec::new(), 0, 0, 0.0);
        for seed in 0..seeds {
            let ride = case.ride(seed);
            let begin = Instant::now();
            let found = latent_road(&ride, &bike).unwrap();
            seconds += begin.elapsed().as_secs_f64() / seeds as f64;
            right += usize::from(found.road.is_some_and(|r| r.class == case.class.name()));
            match (&found.front, &found.rear) {
                (Some(front), Some(rear)) if front.k_std_n_m.is_some() => {
                    scores.push(score([front, rear]))
                }
                _ => without += 1,
            }
        }
        let share =
            |count: usize, of: usize| format!("{:.1}", 100.0 * count as f64 / of.max(1) as f64);
        let sorted = |q: usize| {
            let mut errors: Vec<f64> = scores.iter().map(|s| s[q].0.abs()).collect();
            errors.sort_by(f64::total_cmp);
            errors
        };
        let at = |part: f64| {
            [0, 1, 2, 3]
                .map(|q| {
                    let errors = sorted(q);
                    errors
                        .get((part * errors.len() as f64) as usize)
                        .map_or("-".to_owned(), |e| format!("{e:.2}"))
                })
                .join(", ")
        };
        let hold = [0, 1, 2, 3]
            .map(|q| share(scores.iter().filter(|s| s[q].1).count(), scores.len()))
            .join(", ");
        println!(
            "| {} | {} | {} | {hold} | {} | {without} | {seconds:.2} |",
            case.name,
            at(0.5),
            at(0.9),
            share(right, seeds as usize)
        );
    }
}
