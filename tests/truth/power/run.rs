//! Runs a binary on clean rides, and on the same rides with effects of the sizes that it calls detectable.

use super::outcome::{Detectable, EFFECTS, HEAD, Outcome, row};
use crate::chance::Chance;
use crate::simulate::effect::{Axle, Effect, Kind};
use crate::trial::bench::{Bench, Order, Reported, TrialError, progress};
use crate::trial::plan::{self, Plan, Scene};

/// Streams of random numbers: of the rides, of the noise of the first time they are ridden, and of further times.
const RIDES: u64 = 1 << 44;
const NOISE: u64 = RIDES + (1 << 20);

/// Times the detectable size, and of how many rides one is ridden with it.
const TIMES: [(f64, u64); 3] = [(0.7, 3), (1.0, 1), (1.4, 3)];

/// The table of the rides that are in.
///
/// # Errors
/// Files that cannot be written, a binary that does not run, a folder with outcomes of another one.
pub fn run(order: Order) -> Result<String, TrialError> {
    let bench = Bench::open(order, "power")?;
    let (mut rows, mut done, mut all) = (String::new(), 0, 0);
    for kind in EFFECTS {
        for (turn, (times, one_in)) in TIMES.into_iter().enumerate() {
            let count = bench.count().div_ceil(one_in);
            let class = format!("{}_{turn}", kind.id());
            let outcomes = bench.all(&class, 0..count, |name, number| {
                ride(&bench, name, number, kind, times)
            })?;
            done += outcomes.len();
            all += count;
            rows += &row(kind, times, &outcomes);
        }
    }
    Ok(format!("{}{HEAD}{rows}", progress(done, all)))
}

/// Nothing where the clean ride promises no size.
fn ride(
    bench: &Bench,
    name: &str,
    number: u64,
    kind: Kind,
    times: f64,
) -> Result<Option<Outcome>, TrialError> {
    let scene = scene(bench, number);
    let clean = format!("clean_{number:03}");
    let promised: Detectable = bench.once(&clean, || {
        let report = identify(bench, &scene, &clean, Vec::new())?;
        Ok(Detectable::read(&report))
    })?;
    let axle = Axle::ONE[number as usize % 2];
    let Some(effect) = promised.effect(kind, axle, times) else {
        return Ok(None);
    };
    let report = identify(bench, &scene, name, vec![effect.clone()])?;
    Ok(Some(Outcome::read(&report, &effect)))
}

fn scene(bench: &Bench, number: u64) -> Scene {
    let chance = &mut Chance::new(bench.seed(), RIDES + number);
    let bike = plan::bike([60e3, 150e3], [200.0, 1200.0], chance);
    Scene::draw(Plan::usual(bike, chance), chance)
}

/// Each time with noise of its own: what a ride shows must not depend on the noise that set the size.
fn identify(
    bench: &Bench,
    scene: &Scene,
    name: &str,
    effects: Vec<Effect>,
) -> Result<Reported, TrialError> {
    let chance = &mut Chance::new(bench.seed(), NOISE + stream(name));
    let log = bench.write(
        &format!("{name}.csv"),
        &scene.ride(effects, chance).log.to_csv(),
    )?;
    let bike = bench.write(&format!("{name}.json"), &scene.bike_file.to_string())?;
    bench.identify(&log.0, &bike.0, &[])
}

/// A number of the name's own (FNV-1a, 40 bits).
fn stream(name: &str) -> u64 {
    let hash = |hash: u64, byte: u8| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
    name.bytes().fold(0xcbf2_9ce4_8422_2325, hash) >> 24
}
