//! The study from start to finish.

use super::ready::Ready;
use super::rounds::Rides;
use crate::search::Search;
use crate::search::extend::candidates;
use crate::study::assemble::assemble;
use veloid_core::Progress;
use veloid_core::settings::{Settings, within};
use veloid_core::{EngineError, SettingProblem};
use veloid_model::dataset::Budget;
use veloid_model::fit::Fitter;
use veloid_report::study::{LeftAside, StudyReport};

/// Rides that one study takes.
const MOST: usize = 64;
/// Samples that all rides together may have on one axle after each was brought to the rate that carries it: what the search keeps of
/// them is some 2 kB a sample.
const MOST_SAMPLES: usize = 400_000;

/// What the rides say together.
pub fn study(
    rides: &[Ready],
    left_aside: Vec<LeftAside>,
    settings: &Settings,
    progress: &dyn Progress,
) -> Result<StudyReport, EngineError> {
    let samples: usize = rides.iter().map(|r| r.dataset.samples).sum();
    within("rides of a study", rides.len() as f64, 2.0, MOST as f64)?;
    within(
        "samples of a study",
        samples as f64,
        0.0,
        MOST_SAMPLES as f64,
    )?;
    let axles = |r: &Ready| -> Vec<_> { r.dataset.tracks.iter().map(|t| t.axle).collect() };
    if let Some(other) = rides.iter().find(|r| axles(r) != axles(&rides[0])) {
        return Err(EngineError::Setting {
            name: "rides of a study",
            problem: SettingProblem::DifferentAxles {
                first: rides[0].name.clone(),
                second: other.name.clone(),
            },
        });
    }
    let searches = rides.iter().map(|ride| search(ride, settings, progress));
    let study = Rides {
        searches: searches.collect(),
        alpha: settings.alpha,
        seed: settings.seed,
    };
    let found = study.run()?;
    assemble(&study, rides, found, left_aside, settings)
}

fn search<'a>(ride: &'a Ready, settings: &Settings, progress: &'a dyn Progress) -> Search<'a> {
    let samples = ride.dataset.samples * ride.dataset.tracks.len();
    let budget = Budget::new(settings.search_budget, samples);
    Search {
        fitter: Fitter {
            dataset: &ride.dataset,
            samples: ride.split.train.end,
        },
        plain: ride.plain.clone(),
        held: ride.split.held.clone(),
        candidates: candidates(&ride.dataset).0,
        alpha: settings.alpha,
        seed: settings.seed,
        until: budget.first,
        budget,
        progress,
    }
}
