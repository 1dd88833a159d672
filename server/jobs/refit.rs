//! Effects over a bicycle's rides: what several rides name is fitted to all of them, so that its size has a course, and stiffness and
//! damping are those beside it on every ride.

use std::collections::{BTreeMap, BTreeSet};

use tokio::sync::Mutex;
use tracing::{debug, warn};
use uuid::Uuid;
use veloid_engine::bicycle::Axle;
use veloid_engine::report::diagnosis::{EffectName, EffectReport};
use veloid_engine::report::{IdentifiedModel, ModelOnRide};

use super::fault::Fault;
use super::seats::Purpose;
use super::work::Work;
use crate::fleet;
use crate::store::job::{self, JobRow};
use crate::store::parameter::{self, COURSE, NamedRow, Parameter};
use crate::store::result::{self, DocumentError};

/// Rides that have to name an effect: an unchanged plain bicycle names one in one of some hundred rides (docs/proof.md).
const LEAST: usize = 2;
/// Jobs whose reports are looked through for an effect that could be fitted.
const DONORS: usize = 8;

/// One bicycle after the other, or two ends of its jobs would fit the same rides.
static ONE: Mutex<()> = Mutex::const_new(());

/// An effect as parameters name it: axle and id.
type Effect = (String, String);

/// A job of the bicycle, what it names, and what its ride was fitted again with.
struct Named {
    job: Uuid,
    refitted: Option<String>,
    effects: BTreeSet<Effect>,
}

impl Work {
    /// Fits the rides of a bicycle again that lack an effect which others name.
    pub(super) async fn refit(&self, group: &str, bike: &str) -> Result<(), Fault> {
        if self.to_do(group, bike).await?.1.is_empty() {
            return Ok(());
        }
        let _alone = ONE.lock().await;
        let (jobs, to_do) = self.to_do(group, bike).await?;
        let effects = common(&jobs);
        let text = text(&effects);
        let model = self.model(&jobs, &effects).await?;
        debug!(
            bike,
            rides = to_do.len(),
            effects = text,
            "fits rides again"
        );
        for id in to_do {
            let Some(job) = job::load(&self.db, id).await? else {
                continue;
            };
            let named = jobs.iter().find(|named| named.job == id);
            let named = named
                .map(|named| &named.effects)
                .filter(|n| !effects.is_subset(n));
            let (with, found) = match (&model, named) {
                (Some(model), Some(named)) => {
                    (Some(text.as_str()), self.on_ride(&job, model, named).await?)
                }
                (None, Some(_)) => (Some(text.as_str()), Vec::new()),
                // It names them all by itself.
                (_, None) => (None, Vec::new()),
            };
            let mut tx = self.db.begin_lax().await?;
            let whose = (id, group, bike);
            parameter::put_refitted(&mut tx, whose, job.verdict.as_deref(), with, &found).await?;
            tx.commit().await?;
        }
        Ok(())
    }

    /// The bicycle's jobs, newest first, and those that are to be fitted again.
    async fn to_do(&self, group: &str, bike: &str) -> Result<(Vec<Named>, Vec<Uuid>), Fault> {
        let rows = parameter::named_on_bike(&self.db, group, bike, fleet::RIDES).await?;
        let jobs = jobs(rows);
        let to_do = due(&jobs);
        Ok((jobs, to_do))
    }

    /// A model of the bicycle with these effects, those that the latest reports hold.
    async fn model(
        &self,
        jobs: &[Named],
        effects: &BTreeSet<Effect>,
    ) -> Result<Option<IdentifiedModel>, Fault> {
        let mut found: Option<IdentifiedModel> = None;
        let donors = jobs.iter().filter(|job| !job.effects.is_disjoint(effects));
        for named in donors.take(DONORS) {
            let report = match result::report(&self.db, named.job).await {
                Ok(Some(report)) => report,
                Err(DocumentError::Database(error)) => return Err(error.into()),
                // A damaged report must not keep the bicycle's messages from being sent.
                Ok(None) | Err(_) => continue,
            };
            let other = IdentifiedModel::of(report);
            let can_be_fitted =
                |e: &&EffectReport| e.adequate && effects.contains(&effect(&e.name()));
            let names: Vec<EffectName> = other
                .effects
                .iter()
                .filter(can_be_fitted)
                .map(EffectReport::name)
                .collect();
            match &mut found {
                None if names.is_empty() => {}
                None => {
                    let mut first = other;
                    first.keep_effects(&names);
                    found = Some(first);
                }
                Some(model) => {
                    let has = |name: &EffectName| model.effects.iter().any(|e| e.name() == *name);
                    let lacking: Vec<EffectName> =
                        names.into_iter().filter(|name| !has(name)).collect();
                    lacking
                        .iter()
                        .for_each(|name| model.add_effect(name, &other));
                }
            }
            if found
                .as_ref()
                .is_some_and(|model| model.effects.len() == effects.len())
            {
                break;
            }
        }
        Ok(found)
    }

    /// The model's numbers on a ride, without those of effects that the ride names itself; none where they cannot be fitted.
    async fn on_ride(
        &self,
        job: &JobRow,
        model: &IdentifiedModel,
        named: &BTreeSet<Effect>,
    ) -> Result<Vec<Parameter>, Fault> {
        let compared = async {
            let (reader, files) = self.rides.open(job, Purpose::Job).await?;
            let sources = files.iter().map(|(source, _)| source.clone()).collect();
            reader
                .comparison(sources, job.request.0.clone(), model.clone())
                .await
        };
        match compared.await {
            Ok(found) => Ok(parameters(found, named)),
            Err(fault)
                if fault.is_outage() || matches!(fault, Fault::Stopped | Fault::Interrupted) =>
            {
                Err(fault)
            }
            Err(fault) => {
                warn!(job = %job.id, %fault, "a ride is not fitted again with its bicycle's effects");
                Ok(Vec::new())
            }
        }
    }
}

fn jobs(rows: Vec<NamedRow>) -> Vec<Named> {
    let mut found: Vec<Named> = Vec::new();
    for row in rows {
        if found.last().is_none_or(|last| last.job != row.job_id) {
            found.push(Named {
                job: row.job_id,
                refitted: row.refitted,
                effects: BTreeSet::new(),
            });
        }
        let id = row.name.as_deref().and_then(|name| name.split('.').next());
        if let (Some(last), Some(axle), Some(id)) = (found.last_mut(), row.axle, id) {
            last.effects.insert((axle, id.to_owned()));
        }
    }
    found
}

/// Effects that enough rides name.
fn common(jobs: &[Named]) -> BTreeSet<Effect> {
    let mut rides: BTreeMap<&Effect, usize> = BTreeMap::new();
    for effect in jobs.iter().flat_map(|job| &job.effects) {
        *rides.entry(effect).or_default() += 1;
    }
    let common = rides.into_iter().filter(|(_, rides)| *rides >= LEAST);
    common.map(|(effect, _)| effect.clone()).collect()
}

/// Jobs that lack one of the common effects and were not fitted with just these, and those that were and lack none.
fn due(jobs: &[Named]) -> Vec<Uuid> {
    let effects = common(jobs);
    let text = text(&effects);
    let is_due = |job: &&Named| match effects.is_subset(&job.effects) {
        true => job.refitted.is_some(),
        false => job.refitted.as_ref() != Some(&text),
    };
    jobs.iter().filter(is_due).map(|job| job.job).collect()
}

fn text(effects: &BTreeSet<Effect>) -> String {
    let names: Vec<String> = effects
        .iter()
        .map(|(axle, id)| format!("{axle}.{id}"))
        .collect();
    names.join(",")
}

fn effect(name: &EffectName) -> Effect {
    (name.axle.name().to_owned(), name.id.clone())
}

fn parameters(found: ModelOnRide, named: &BTreeSet<Effect>) -> Vec<Parameter> {
    let mut parameters: Vec<Parameter> = Vec::new();
    for (axle, on_axle) in found.axles.iter() {
        let effects: BTreeMap<&str, &'static str> = (on_axle.effects.iter())
            .map(|effect| (effect.id.as_str(), effect.axle.name()))
            .collect();
        for parameter in &on_axle.parameters {
            let Some((place, name)) = placed(axle, &parameter.name, &effects, named) else {
                continue;
            };
            // Of an effect on both axles each axle says the same.
            if parameters.iter().any(|p| p.axle == place && p.name == name) {
                continue;
            }
            parameters.extend(parameter.ride_std_error.map(|error| Parameter {
                method: COURSE,
                axle: place,
                name,
                value: parameter.ride,
                std_error: Some(error),
                unit: parameter.unit.clone(),
            }));
        }
    }
    parameters
}

/// The axle and the name under which a number is stored, unless the ride names its effect itself.
fn placed(
    axle: Axle,
    name: &str,
    effects: &BTreeMap<&str, &'static str>,
    named: &BTreeSet<Effect>,
) -> Option<(&'static str, String)> {
    match name {
        "k" => Some((axle.name(), "k_n_m".to_owned())),
        "B" => Some((axle.name(), "b_n_s_m".to_owned())),
        name => {
            let id = name.split('.').next()?;
            let place = effects.get(id).copied()?;
            let is_own = named.contains(&(place.to_owned(), id.to_owned()));
            (!is_own).then(|| (place, name.to_owned()))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(job: u128, refitted: Option<&str>, effects: &[&str]) -> Named {
        let effect = |id: &&str| ("front".to_owned(), (*id).to_owned());
        Named {
            job: Uuid::from_u128(job),
            refitted: refitted.map(str::to_owned),
            effects: effects.iter().map(effect).collect(),
        }
    }

    fn due_of(jobs: &[Named]) -> Vec<u128> {
        due(jobs).into_iter().map(|job| job.as_u128()).collect()
    }

    #[test]
    fn rides_are_fitted_again_once_enough_others_name_an_effect() {
        let mut jobs = vec![named(0, None, &[])];
        for job in 1..=LEAST {
            assert_eq!(due_of(&jobs), Vec::<u128>::new());
            jobs.push(named(job as u128, None, &["friction"]));
        }
        assert_eq!(due_of(&jobs), [0]);
        jobs[0].refitted = Some("front.friction".to_owned());
        assert_eq!(due_of(&jobs), Vec::<u128>::new());
        jobs.push(named(8, None, &["play"]));
        jobs.push(named(9, None, &["friction", "play"]));
        assert_eq!(due_of(&jobs), [0, 1, 2, 8]);
    }

    #[test]
    fn what_was_fitted_again_is_dropped_when_the_effect_is_named_no_longer() {
        let jobs = [
            named(0, Some("front.friction"), &[]),
            named(1, None, &["friction"]),
        ];
        assert_eq!(due_of(&jobs), [0]);
    }

    #[test]
    fn an_effect_that_the_ride_names_keeps_its_own_size() {
        let effects = BTreeMap::from([("friction", "front"), ("play", "both")]);
        let own = BTreeSet::from([("front".to_owned(), "friction".to_owned())]);
        let place = |name| placed(Axle::Front, name, &effects, &own);
        assert_eq!(place("k"), Some(("front", "k_n_m".to_owned())));
        assert_eq!(place("friction.force"), None);
        assert_eq!(place("play.width"), Some(("both", "play.width".to_owned())));
    }
}
