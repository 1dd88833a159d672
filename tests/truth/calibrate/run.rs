//! Runs a binary on clean rides of every class.

use super::class::CLASSES;
use super::outcome::{LENIENT, Outcome};
use super::table;
use crate::chance::Chance;
use crate::trial::bench::{Bench, Order, TrialError, progress};
use crate::trial::plan::Scene;

/// Stream of random numbers of the first ride of the first class.
const STREAM: u64 = 1 << 43;

/// The tables of the rides that are in.
///
/// # Errors
/// Files that cannot be written, a binary that does not run, a folder with outcomes of another one.
pub fn run(order: Order) -> Result<String, TrialError> {
    let bench = Bench::open(order, "calibrate")?;
    let (mut rates, mut coverage, mut done) = (String::new(), String::new(), 0);
    for (c, class) in CLASSES.iter().enumerate() {
        let stream = STREAM + ((c as u64) << 20);
        let outcomes = bench.all(class.id, 0..bench.count(), |name, number| {
            let chance = &mut Chance::new(bench.seed(), stream + number);
            let scene = Scene::draw(class.plan(number, chance), chance);
            ride(&bench, &scene, name, chance)
        })?;
        done += outcomes.len();
        rates += &table::rates(class.name, &outcomes);
        coverage += &table::coverage(class.name, &outcomes);
    }
    Ok(format!(
        "{}{}{rates}\n{}{coverage}",
        progress(done, bench.count() * CLASSES.len() as u64),
        table::RATES_HEAD,
        table::COVERAGE_HEAD
    ))
}

fn ride(
    bench: &Bench,
    scene: &Scene,
    name: &str,
    chance: &mut Chance,
) -> Result<Outcome, TrialError> {
    let log = scene.ride(Vec::new(), chance).log.to_csv();
    let log = bench.write(&format!("{name}.csv"), &log)?;
    let bike = bench.write(&format!("{name}.json"), &scene.bike_file.to_string())?;
    let usual = bench.identify(&log.0, &bike.0, &[])?;
    let lenient = bench.identify(&log.0, &bike.0, &["--alpha", &LENIENT.to_string()])?;
    Ok(Outcome::read(&usual, &lenient, &scene.plan.bike))
}
