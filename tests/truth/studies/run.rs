//! Runs `study` on sets of rides.

use serde_json::Value;

use super::outcome::{Outcome, Truth};
use super::set::Kind;
use super::table;
use crate::chance::Chance;
use crate::power::outcome::{Detectable, EFFECTS};
use crate::simulate::effect::{Axle, Effect};
use crate::trial::bench::{Bench, Order, Scratch, TrialError, progress};
use crate::trial::plan::Scene;

/// Stream of random numbers of the first set of the first kind.
const STREAM: u64 = 1 << 45;
/// Standard deviation of an accelerometer's noise (m/s^2).
const ACCELEROMETER: [f64; 2] = [0.02, 0.1];

/// The tables of the sets that are in.
///
/// # Errors
/// Files that cannot be written, a binary that does not run, a folder with outcomes of another one.
pub fn run(order: Order) -> Result<String, TrialError> {
    let bench = Bench::open(order, "studies")?;
    let (mut verdicts, mut coverage, mut done) = (String::new(), String::new(), 0);
    for (k, kind) in Kind::ALL.into_iter().enumerate() {
        let [id, words] = kind.names();
        let stream = STREAM + ((k as u64) << 20);
        let outcomes = bench.all(id, 0..bench.count(), |name, number| {
            let chance = &mut Chance::new(bench.seed(), stream + number);
            set(&bench, kind, name, number, chance)
        })?;
        done += outcomes.len();
        verdicts += &table::verdicts(words, &outcomes);
        coverage += &table::coverage(words, &outcomes);
    }
    Ok(format!(
        "{}{}{verdicts}\n{}{coverage}",
        progress(done, bench.count() * Kind::ALL.len() as u64),
        table::VERDICTS_HEAD,
        table::COVERAGE_HEAD
    ))
}

fn set(
    bench: &Bench,
    kind: Kind,
    name: &str,
    number: u64,
    chance: &mut Chance,
) -> Result<Outcome, TrialError> {
    let (plans, changed) = kind.plans(chance);
    let scenes: Vec<Scene> = (plans.into_iter())
        .map(|plan| Scene::draw(plan, chance))
        .collect();
    let bike = bench.write(&format!("{name}.json"), &bike_file(&scenes[0]).to_string())?;
    let effect = match kind.times() {
        Some(times) => effect(bench, &scenes[0], name, (number, times), chance)?,
        None => None,
    };
    if kind.times().is_some() && effect.is_none() {
        return Ok(Outcome {
            verdict: "the first ride promises no size".to_owned(),
            ..Outcome::default()
        });
    }
    let files = ridden(bench, kind, name, (&scenes, effect.as_ref()), chance)?;
    let names = files.iter().map(|file| file.0.file_name());
    let names = names.map(|name| name.unwrap_or_default().to_string_lossy().into_owned());
    let truth = Truth {
        bikes: names
            .zip(scenes.iter().map(|scene| scene.plan.bike.clone()))
            .collect(),
        effect: effect.map(|e| (e.kind.id().to_owned(), e.axle.name().to_owned())),
        changed,
    };
    Ok(Outcome::read(&bench.study(&files, &bike.0)?, &truth))
}

/// The files of a set's rides, all with the same effect.
fn ridden(
    bench: &Bench,
    kind: Kind,
    name: &str,
    (scenes, effect): (&[Scene], Option<&Effect>),
    chance: &mut Chance,
) -> Result<Vec<Scratch>, TrialError> {
    let one = |(i, scene): (usize, &Scene)| {
        let take = scene.ride(effect.into_iter().cloned().collect(), chance);
        let noise = chance.log_uniform(ACCELEROMETER[0], ACCELEROMETER[1]);
        let text = match kind {
            Kind::Accelerometers => take.accelerometers(noise, chance),
            _ => take.log.to_csv(),
        };
        Ok(bench.write(&format!("{name}_{i}.csv"), &text)?)
    };
    scenes.iter().enumerate().map(one).collect()
}

/// One for all rides, whose noise differs.
fn bike_file(scene: &Scene) -> Value {
    let mut file = scene.bike_file.clone();
    for noise in ["noise_displacement_m", "noise_road_m"] {
        file[noise] = Value::Null;
    }
    file
}

/// The effect of a set, by what its first ride, clean, says that it would have shown.
fn effect(
    bench: &Bench,
    scene: &Scene,
    name: &str,
    (number, times): (u64, f64),
    chance: &mut Chance,
) -> Result<Option<Effect>, TrialError> {
    let log = scene.ride(Vec::new(), chance).log.to_csv();
    let log = bench.write(&format!("{name}_first.csv"), &log)?;
    let bike = bench.write(&format!("{name}_first.json"), &bike_file(scene).to_string())?;
    let promised = Detectable::read(&bench.identify(&log.0, &bike.0, &[])?);
    let kind = EFFECTS[number as usize % EFFECTS.len()];
    Ok(promised.effect(kind, chance.pick(&Axle::ONE), times))
}
