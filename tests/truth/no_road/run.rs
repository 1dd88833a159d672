//! Runs a binary on rides without a road.

use serde_json::json;

use super::class::Class;
use super::mark::Mark;
use super::plan::{self, Planned};
use super::ride;
use super::score::Outcome;
use super::table::table;
use crate::chance::Chance;
use crate::files;
use crate::suite::folder;
use crate::trial::bench::{Bench, Order, TrialError, progress};

/// Streams of random numbers: of the plan, and of the first ride.
const PLAN: u64 = 1 << 46;
const RIDES: u64 = PLAN + (1 << 20);
/// The folder of the rides, in the work folder; their key is beside it.
const FOLDER: &str = "rides";

/// The table of the rides that are in, of every `one_in`-th ride.
///
/// # Errors
/// Files that cannot be written, a binary that does not run, a folder with outcomes of another one.
pub fn run(order: Order, one_in: usize) -> Result<String, TrialError> {
    let rides = order.work.join(FOLDER);
    files::create_folder(&rides)?;
    let bench = Bench::open(order, "no_road")?;
    let plan = plan::plan(&mut Chance::new(bench.seed(), PLAN));
    let numbers = plan::sample(&plan, one_in, bench.count());
    let all = numbers.len() as u64;
    let outcomes = bench.all("ride", numbers, |name, number| {
        let chance = &mut Chance::new(bench.seed(), RIDES + number);
        let planned = &plan[number as usize];
        Ok((number, ride(&bench, planned, name, chance)?))
    })?;
    let outcomes: Vec<(Class, Outcome)> = (outcomes.into_iter())
        .map(|(number, outcome): (u64, Outcome)| (plan[number as usize].class, outcome))
        .collect();
    let keys: Vec<_> = outcomes.iter().map(|(_, o)| &o.key).collect();
    let key = format!("{:#}\n", json!({"seed": bench.seed(), "rides": keys}));
    files::write_whole(&folder::key_path(&rides)?, &key)?;
    Ok(progress(outcomes.len(), all) + &table(&outcomes))
}

/// Files of a ride that is judged wrongly stay.
fn ride(
    bench: &Bench,
    planned: &Planned,
    name: &str,
    chance: &mut Chance,
) -> Result<Outcome, TrialError> {
    let made = ride::make(planned, name, chance);
    let log = bench.write(&format!("{FOLDER}/{name}.csv"), &made.log.to_csv())?;
    let bike = format!("{FOLDER}/{name}.json");
    let bike = bench.write(&bike, &made.bike_file.to_string())?;
    let report = bench.identify(&log.0, &bike.0, &[])?;
    let outcome = Outcome::read(&report, planned.class, &made);
    if outcome.mark == Mark::Wrong {
        log.keep();
        bike.keep();
    }
    Ok(outcome)
}
