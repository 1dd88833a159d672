//! How often, and how late, changes are reported: `cargo run --release -p veloid-courses --example alarms [BICYCLES]` prints the tables of
//! docs/fleet.md. Bicycles have four parameters, ridden four times a week; rides scatter by 0.8 % beyond errors of 0.3 to 0.9 %, 1 % in
//! all.
#![allow(clippy::print_stdout)]

use std::collections::BTreeMap;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, Exp1, StandardNormal, StudentT};
use rayon::prelude::*;
use veloid_courses::{Development, Ride, Rides};

/// Rides of a bicycle that nothing happens to.
const RIDES: usize = 200;
/// Rides after a change.
const AFTER: usize = 40;
/// Never.
const NEVER: usize = usize::MAX;

/// How rides scatter beyond their errors.
#[derive(Clone, Copy)]
enum Scatter {
    Normal,
    /// Student's t with three degrees of freedom.
    Heavy,
    /// One ride of fifty scatters eight times as much.
    Wrong,
    /// An exponential distribution.
    Skewed,
}

impl Scatter {
    fn draw(self, random: &mut ChaCha8Rng) -> f64 {
        let normal: f64 = StandardNormal.sample(random);
        match self {
            Self::Normal => normal,
            Self::Heavy => StudentT::new(3.0).map_or(0.0, |t| t.sample(random)) / 3_f64.sqrt(),
            Self::Wrong if random.random::<f64>() < 0.02 => 8.0 * normal,
            Self::Wrong => normal,
            Self::Skewed => {
                let from_zero: f64 = Exp1.sample(random);
                from_zero - 1.0
            }
        }
    }
}

/// A season of so many rides, of which `change` says what happens (%), by ride and days.
fn season(
    seed: u64,
    rides: usize,
    scatter: Scatter,
    change: impl Fn(usize, &[f64]) -> f64,
) -> Vec<Ride> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let long = rides as f64 * 7.0 / 4.0;
    let mut days: Vec<f64> = (0..rides).map(|_| long * random.random::<f64>()).collect();
    days.sort_by(f64::total_cmp);
    let ride = |i: usize| {
        let std_error = 0.3 + 0.6 * random.random::<f64>();
        let error: f64 = StandardNormal.sample(&mut random);
        let value = 0.8 * scatter.draw(&mut random) + std_error * error;
        Ride {
            day: days[i],
            value: 100.0 + value + change(i, &days),
            std_error,
        }
    };
    (0..rides).map(ride).collect()
}

fn followed(rides: &[Ride]) -> Option<Development> {
    Development::of(Rides { rides, facts: &[] })
}

/// Bicycles of which anything is reported within 200 rides.
fn alarms(bicycles: u64, scatter: Scatter) -> usize {
    let is_reported = |bicycle: &u64| {
        (0..4).any(|parameter| {
            let rides = season(4 * bicycle + parameter, RIDES, scatter, |_, _| 0.0);
            followed(&rides).is_some_and(|found| !found.reported.is_empty())
        })
    };
    (0..bicycles).into_par_iter().filter(is_reported).count()
}

/// Rides until a change is reported, and as what it is reported at the end.
fn delays(
    count: u64,
    at: usize,
    change: impl Fn(usize, &[f64]) -> f64 + Sync,
) -> (Vec<usize>, BTreeMap<String, usize>) {
    let one = |seed: u64| {
        let rides = season(1_000_000 + seed, at + AFTER, Scatter::Normal, &change);
        let found = followed(&rides);
        let reported = found.iter().flat_map(|found| &found.reported);
        let first = reported.copied().find(|ride| *ride >= at);
        let said = found.map_or(String::new(), |found| {
            format!("{} steps, {} drifts", found.steps.len(), found.drifts.len())
        });
        (first.map_or(NEVER, |ride| ride + 1 - at), said)
    };
    let (mut delays, said): (Vec<usize>, Vec<String>) = (0..count).into_par_iter().map(one).unzip();
    delays.sort_unstable();
    let mut counts = BTreeMap::new();
    said.into_iter()
        .for_each(|said| *counts.entry(said).or_insert(0) += 1);
    (delays, counts)
}

fn main() {
    let bicycles = std::env::args().nth(1).and_then(|n| n.parse().ok());
    let bicycles: u64 = bicycles.unwrap_or(2000);
    println!("| rides scatter | unchanged bicycles with an alarm in {RIDES} rides |\n|---|---|");
    for (name, scatter) in [
        ("normally", Scatter::Normal),
        ("as Student's t, 3 degrees of freedom", Scatter::Heavy),
        ("normally, one in 50 eight times as much", Scatter::Wrong),
        ("exponentially", Scatter::Skewed),
    ] {
        println!("| {name} | {} of {bicycles} |", alarms(bicycles, scatter));
    }
    println!(
        "\n| change | after | rides until reported, median | 90 % | reported as |\n|---|---|---|---|---|"
    );
    for at in [10, 20, 40, 100] {
        let step = delays(bicycles, at, |i, _| if i < at { 0.0 } else { 3.0 });
        let leak = delays(bicycles, at, |i, days| -(days[i] - days[at]).max(0.0) / 7.0);
        for (name, (delays, said)) in [("step of 3 %", step), ("leak of 1 % a week", leak)] {
            let quantile = |q: f64| delays[(q * (delays.len() - 1) as f64) as usize];
            let (half, most) = (quantile(0.5), quantile(0.9));
            println!("| {name} | {at} rides | {half} | {most} | {said:?} |");
        }
    }
}
