//! The diagnosis from start to finish.

use super::decide::decide;
use super::prepare::Prepared;
use super::search::Search;
use super::search::extend::candidates;
use crate::assemble::assemble;
use crate::judge::{self, scores::Scores};
use crate::policy;
use crate::verdict::choose::{Chosen, choose};
use veloid_core::bicycle::{Bike, PerAxle};
use veloid_core::settings::Settings;
use veloid_core::{EngineError, Progress};
use veloid_methods::output_error::spread_valid;
use veloid_model::dataset::Budget;
use veloid_report::Estimate;
use veloid_report::diagnosis::{Base, Diagnosis, HeldOut, SearchCost, SwitchedOff, Verdict};
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
    let mut sprung = asked.prepared(Base::SpringAndDamper)?;
    let bare = asked.without_springs()?;
    sprung.dataset.is_held = bare.is_none();
    let sprung = asked.diagnosed(&sprung, 1.0)?;
    let Some(bare) = bare.filter(|_| sprung.verdict != Verdict::NothingMissing) else {
        return Ok(sprung);
    };
    let bare = asked.diagnosed(&bare, share_left(&sprung))?;
    Ok(better(sprung, bare))
}

/// The held-out scores of every set of effects that was tried on each axle of a bench: what the table of `judge` decides by.
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
    let prepared = asked.prepared(Base::SpringAndDamper)?;
    let search = asked.search(&prepared, 1.0).0;
    let Chosen {
        model, mut tied, ..
    } = choose(&search)?;
    tied.push(model);
    judge::scores(&search, prepared.record(), &tied)
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

    /// The masses without springs, where that explains most of what forces alone bring about.
    fn without_springs(&self) -> Result<Option<Prepared>, EngineError> {
        if !only_pushed(self.ride) {
            return Ok(None);
        }
        match self.prepared(Base::Damper) {
            Ok(mut prepared) if explains_most(&prepared) => {
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

    /// The diagnosis from one base, with a share of the budget.
    fn diagnosed(&self, prepared: &Prepared, share: f64) -> Result<Diagnosis, EngineError> {
        let settings = self.settings;
        let (search, switched_off) = self.search(prepared, share);
        let decision = decide(prepared, &search, settings)?;
        Ok(assemble(
            prepared,
            &search,
            &decision,
            switched_off,
            self.bike,
            settings,
        ))
    }
}

/// Whether forces alone drive every axle: only then can there be no spring.
fn only_pushed(ride: &Ride) -> bool {
    let mut axles = ride.axles.iter();
    axles.all(|(_, record)| record.force.is_some() && !record.has_road() && !record.prescribed)
}

/// Whether a base without springs explains most of every axle's motion.
fn explains_most(prepared: &Prepared) -> bool {
    let train = || prepared.split.train.clone();
    prepared.dataset.tracks.iter().all(|track| {
        let moves = spread_valid(&track.measured, &track.valid, train());
        let fit = prepared.fits().get(track.axle);
        fit.is_some_and(|fit| leaves_little(fit.train_rms, moves))
    })
}

/// Whether a base leaves so little (RMS) of what moves so (RMS) that more can be built on it.
fn leaves_little(left: f64, moves: f64) -> bool {
    left.powi(2) < policy::BARE_LEAVES * moves.powi(2)
}

/// Share of the budget that a second base has: what the first left, and at least this.
const LEAST: f64 = 0.5;

fn share_left(first: &Diagnosis) -> f64 {
    let cost = &first.search_cost;
    (1.0 - cost.steps as f64 / cost.budget.max(1) as f64).max(LEAST)
}

/// The diagnosis whose verdict says more; of two that say as much the one without a spring, unless it errs more.
fn better(sprung: Diagnosis, bare: Diagnosis) -> Diagnosis {
    let says = |d: &Diagnosis| match d.verdict {
        Verdict::NothingMissing | Verdict::Named => 2,
        Verdict::NamedInPart => 1,
        Verdict::Ambiguous | Verdict::Unnamed | Verdict::CannotTell => 0,
    };
    let error = |d: &Diagnosis| -> f64 {
        let left = |held: &HeldOut| held.extended_rms_m.unwrap_or(f64::INFINITY);
        d.held_out.iter().map(|(_, held)| left(held)).product()
    };
    // A spring that the record does not show is no base to build on.
    let shows_spring = |e: &Estimate| e.k_std_n_m.is_some_and(|std| e.k_n_m > policy::SHOWN * std);
    let no_spring = !sprung.extended.iter().all(|(_, e)| shows_spring(e));
    let errs_little = error(&bare) <= policy::AS_GOOD * error(&sprung);
    let wins = match says(&bare).cmp(&says(&sprung)) {
        std::cmp::Ordering::Greater => !bare.effects.is_empty() || errs_little,
        std::cmp::Ordering::Equal => says(&bare) > 0 && (errs_little || no_spring),
        std::cmp::Ordering::Less => says(&bare) > 0 && no_spring,
    };
    let [first, second] = [sprung.search_cost, bare.search_cost];
    let diagnosed = if wins { bare } else { sprung };
    Diagnosis {
        search_cost: SearchCost {
            steps: first.steps + second.steps,
            budget: first.budget + second.budget,
            ..diagnosed.search_cost
        },
        ..diagnosed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn diagnosed(base: Base, verdict: Verdict, left: f64) -> Diagnosis {
        let held = HeldOut {
            extended_rms_m: Some(left),
            ..HeldOut::default()
        };
        Diagnosis {
            base,
            verdict,
            held_out: PerAxle {
                front: Some(held),
                rear: None,
            },
            ..Diagnosis::without_verdict(String::new())
        }
    }

    #[test]
    fn a_spring_goes_where_nothing_is_lost_by_that() {
        let base = |(with, left): (Verdict, f64), (without, other): (Verdict, f64)| {
            let sprung = diagnosed(Base::SpringAndDamper, with, left);
            better(sprung, diagnosed(Base::Damper, without, other)).base
        };
        let (named, unnamed) = (Verdict::Named, Verdict::Unnamed);
        assert_eq!(
            base((named, 1.0), (named, 0.99 * policy::AS_GOOD)),
            Base::Damper
        );
        assert_eq!(
            base((named, 1.0), (named, 1.01 * policy::AS_GOOD)),
            Base::SpringAndDamper
        );
        assert_eq!(base((unnamed, 1.0), (unnamed, 0.1)), Base::SpringAndDamper);
        // A damper that leaves more explains nothing, whatever is said of its noise.
        let nothing = Verdict::NothingMissing;
        assert_eq!(base((unnamed, 1.0), (nothing, 2.0)), Base::SpringAndDamper);
        assert_eq!(base((unnamed, 1.0), (nothing, 1.0)), Base::Damper);
        assert_eq!(base((named, 2.0), (unnamed, 1.0)), Base::SpringAndDamper);
    }

    #[test]
    fn a_spring_that_the_record_does_not_show_is_no_base() {
        let base = |k: f64, without: Verdict| {
            let mut sprung = diagnosed(Base::SpringAndDamper, Verdict::Named, 1.0);
            sprung.extended.front = Some(Estimate {
                k_n_m: k,
                k_std_n_m: Some(1.0),
                ..Estimate::default()
            });
            better(sprung, diagnosed(Base::Damper, without, 2.0)).base
        };
        let in_part = Verdict::NamedInPart;
        assert_eq!(base(1.01 * policy::SHOWN, in_part), Base::SpringAndDamper);
        assert_eq!(base(0.99 * policy::SHOWN, in_part), Base::Damper);
        assert_eq!(base(0.0, Verdict::Unnamed), Base::SpringAndDamper);
    }

    #[test]
    fn a_mass_on_a_damper_is_a_base_where_it_leaves_little_of_the_motion() {
        let moves = 3e-3;
        let left = |times: f64| (times * policy::BARE_LEAVES).sqrt() * moves;
        assert!(leaves_little(left(0.99), moves) && !leaves_little(left(1.01), moves));
    }
}
