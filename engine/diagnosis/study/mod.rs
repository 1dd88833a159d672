//! Several rides of one bicycle as one: effects too weak for one ride are found in many, and k and B are common where the rides
//! bear that.

mod joint;
mod rounds;
mod tell;

use super::dataset::Budget;
use super::prepare::Prepared;
use super::search::Search;
use super::search::extend::candidates;
use crate::EngineError;
use crate::progress::Progress;
use crate::report::diagnosis::Diagnosis;
use crate::report::study::{LeftAside, StudyReport};
use crate::settings::{Settings, within};
use rounds::Rides;

/// A ride that takes part.
pub struct Ready {
    pub name: String,
    pub prepared: Prepared,
    /// What it says alone.
    pub alone: Diagnosis,
}

/// Rides that one study takes.
const MOST: usize = 64;
/// Samples that all rides together may have on one axle after each was brought to the rate that carries it: what the search keeps of
/// them is some 3 kB a sample.
const MOST_SAMPLES: usize = 400_000;

/// What the rides say together.
pub fn study(
    rides: &[Ready],
    left_aside: Vec<LeftAside>,
    settings: &Settings,
    progress: &dyn Progress,
) -> Result<StudyReport, EngineError> {
    let samples: usize = rides.iter().map(|r| r.prepared.scene.samples).sum();
    within("rides of a study", rides.len() as f64, 2.0, MOST as f64)?;
    within(
        "samples of a study",
        samples as f64,
        0.0,
        MOST_SAMPLES as f64,
    )?;
    let axles = |r: &Ready| -> Vec<_> { r.prepared.scene.tracks.iter().map(|t| t.axle).collect() };
    if let Some(other) = rides.iter().find(|r| axles(r) != axles(&rides[0])) {
        return Err(EngineError::Setting {
            name: "rides of a study",
            problem: format!(
                "{} and {} were recorded on different axles",
                rides[0].name, other.name
            ),
        });
    }
    let searches = rides.iter().map(|ride| search(ride, settings, progress));
    let study = Rides {
        searches: searches.collect(),
        alpha: settings.alpha,
        seed: settings.seed,
    };
    let found = study.run()?;
    tell::tell(&study, rides, found, left_aside, settings)
}

fn search<'a>(ride: &'a Ready, settings: &Settings, progress: &'a dyn Progress) -> Search<'a> {
    let prepared = &ride.prepared;
    let samples = prepared.scene.samples * prepared.scene.tracks.len();
    let budget = Budget::new(settings.search_budget, samples);
    Search {
        fitter: prepared.fitter(),
        plain: prepared.plain.clone(),
        held: prepared.split.held.clone(),
        candidates: candidates(&prepared.scene).0,
        alpha: settings.alpha,
        seed: settings.seed,
        until: budget.first,
        budget,
        progress,
    }
}
