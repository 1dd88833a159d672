//! The diagnosis from start to finish.

use super::decide::{Decision, decide};
use super::prepare::Prepared;
use super::search::Search;
use super::search::extend::candidates;
use crate::assemble::assemble;
use crate::judge::{numbers::Numbers, scores::Scores, table};
use crate::policy;
use veloid_core::bicycle::{Bike, PerAxle};
use veloid_core::plant::Of;
use veloid_core::settings::Settings;
use veloid_core::{EngineError, Progress};
use veloid_methods::output_error::spread_valid;
use veloid_model::dataset::Budget;
use veloid_report::diagnosis::{Base, Diagnosis, SearchCost, SwitchedOff, Verdict};
use veloid_report::stages::Conclusion;
use veloid_ride::Ride;

/// Says what physics the plain model leaves out of a ride.
pub fn diagnose(
    ride: &Ride,
    bike: &Bike,
    settings: &Settings,
    conclusion: &Conclusion,
    progress: &dyn Progress,
) -> Result<Diagnosis, EngineError> {
    let asked = Query {
        ride,
        bike,
        settings,
        conclusion,
        progress,
    };
    let bases = asked.bases()?;
    let (prepared, decided) = asked.chosen(&bases)?;
    Ok(asked.report(prepared, decided))
}

/// The held-out scores of every set of effects that was tried on each axle: what the table of `judge` decides by.
///
/// # Errors
/// What cannot be diagnosed, and cancellation.
pub fn scores(
    ride: &Ride,
    bike: &Bike,
    settings: &Settings,
    conclusion: &Conclusion,
    progress: &dyn Progress,
) -> Result<PerAxle<Scores>, EngineError> {
    let asked = Query {
        ride,
        bike,
        settings,
        conclusion,
        progress,
    };
    let bases = asked.bases()?;
    let (prepared, decided) = asked.chosen(&bases)?;
    let mut scores = PerAxle::default();
    let tracks = prepared.dataset.tracks.iter();
    for (track, read) in tracks.zip(decided.decision.read) {
        if let Some(read) = read {
            scores.set(track.axle, read.evidence.scores);
        }
    }
    Ok(scores)
}

/// The plain models to which effects may be added: springs and dampers, and dampers alone where these follow the motion too.
struct Bases {
    sprung: Prepared,
    bare: Option<Prepared>,
}

/// What a diagnosis is made from.
struct Query<'a> {
    ride: &'a Ride,
    bike: &'a Bike,
    settings: &'a Settings,
    conclusion: &'a Conclusion,
    progress: &'a dyn Progress,
}

impl Query<'_> {
    fn prepared(&self, base: Base) -> Result<Prepared, EngineError> {
        Prepared::new(self.ride, self.bike, self.settings, self.conclusion, base)
    }

    fn bases(&self) -> Result<Bases, EngineError> {
        let bare = self.without_springs()?;
        let mut sprung = self.prepared(Base::SpringAndDamper)?;
        sprung.dataset.is_held = bare.is_none();
        Ok(Bases { sprung, bare })
    }

    /// The base that the record supports, with what is decided from it.
    fn chosen<'p>(&'p self, bases: &'p Bases) -> Result<(&'p Prepared, Decided<'p>), EngineError> {
        let mut sprung = self.decided(&bases.sprung, 1.0)?;
        let spring_is_enough = sprung.decision.verdict == Verdict::NothingMissing;
        let Some(prepared) = bases.bare.as_ref().filter(|_| !spring_is_enough) else {
            return Ok((&bases.sprung, sprung));
        };
        let mut bare = self.decided(prepared, share_left(&sprung.decision.cost))?;
        let [first, second] = [&mut sprung.decision, &mut bare.decision];
        first.cost.steps += second.cost.steps;
        first.cost.budget += second.cost.budget;
        (second.cost.steps, second.cost.budget) = (first.cost.steps, first.cost.budget);
        Ok(match needs_spring(first, second) {
            true => (&bases.sprung, sprung),
            false => (prepared, bare),
        })
    }

    /// The masses without springs, where that follows what forces alone bring about.
    fn without_springs(&self) -> Result<Option<Prepared>, EngineError> {
        // What has a given spring has one.
        let mut limited = self.ride.axles.iter();
        let has_spring = limited.any(|(axle, _)| self.bike.limit(axle, Of::Stiffness).is_some());
        if has_spring || !only_pushed(self.ride) {
            return Ok(None);
        }
        match self.prepared(Base::Damper) {
            Ok(mut prepared) if follows(&prepared) => {
                prepared.dataset.is_held = false;
                Ok(Some(prepared))
            }
            Ok(_) | Err(EngineError::Diverged { .. }) => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// The search for effects beside a base, with a share of the budget, and what the ride cannot show.
    fn search<'p>(&'p self, prepared: &'p Prepared, share: f64) -> (Search<'p>, Vec<SwitchedOff>) {
        let settings = self.settings;
        let (candidates, switched_off) = candidates(&prepared.dataset);
        let samples = prepared.dataset.samples * prepared.dataset.tracks.len();
        let budget = Budget::new(share * settings.search_budget, samples);
        let search = Search {
            fitter: prepared.fitter(),
            plain: prepared.plain.clone(),
            held: prepared.split.held.clone(),
            candidates,
            alpha: settings.alpha,
            seed: settings.seed,
            until: budget.first,
            budget,
            progress: self.progress,
        };
        (search, switched_off)
    }

    /// What is decided from one base, with a share of the budget.
    fn decided<'p>(
        &'p self,
        prepared: &'p Prepared,
        share: f64,
    ) -> Result<Decided<'p>, EngineError> {
        let (search, switched_off) = self.search(prepared, share);
        let decision = decide(prepared, &search, self.settings)?;
        Ok(Decided {
            search,
            switched_off,
            decision,
        })
    }

    fn report(&self, prepared: &Prepared, decided: Decided) -> Diagnosis {
        let Decided {
            search,
            switched_off,
            decision,
        } = decided;
        let (bike, settings) = (self.bike, self.settings);
        assemble(prepared, &search, &decision, switched_off, bike, settings)
    }
}

/// A decision with the search that led to it.
struct Decided<'p> {
    search: Search<'p>,
    switched_off: Vec<SwitchedOff>,
    decision: Decision,
}

/// Whether a spring holds the mass of any axle, by what models with and without one leave.
fn needs_spring(sprung: &Decision, bare: &Decision) -> bool {
    let mut axles = sprung.read.iter().zip(&bare.read);
    axles.any(|both| match both {
        (Some(sprung), Some(bare)) => {
            let [sprung, bare] = [sprung, bare].map(|read| &read.evidence.scores);
            table::needs_spring(sprung, bare, &Numbers::default())
        }
        (_, bare) => bare.is_none(),
    })
}

/// Whether forces alone drive every axle: only then can there be no spring.
fn only_pushed(ride: &Ride) -> bool {
    let mut axles = ride.axles.iter();
    axles.all(|(_, record)| record.force.is_some() && !record.has_road() && !record.prescribed)
}

/// Whether a base without springs follows every axle's motion.
fn follows(prepared: &Prepared) -> bool {
    let train = || prepared.split.train.clone();
    prepared.dataset.tracks.iter().all(|track| {
        let moves = spread_valid(&track.measured, &track.valid, train());
        let fit = prepared.fits().get(track.axle);
        fit.is_some_and(|fit| fit.train_rms < policy::FOLLOWS * moves)
    })
}

/// Share of the budget that a second base has: what the first left, and at least this.
const LEAST: f64 = 0.5;

fn share_left(cost: &SearchCost) -> f64 {
    (1.0 - cost.steps as f64 / cost.budget.max(1) as f64).max(LEAST)
}
