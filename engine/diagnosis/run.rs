//! The diagnosis from start to finish.

use super::dataset::Budget;
use super::decide::decide;
use super::prepare::Prepared;
use super::search::Search;
use super::search::extend::candidates;
use super::tell::tell;
use crate::EngineError;
use crate::bicycle::Bike;
use crate::progress::Progress;
use crate::report::diagnosis::Diagnosis;
use crate::report::stages::Conclusion;
use crate::ride::Ride;
use crate::settings::Settings;

/// Says what physics the plain model leaves out of a ride.
pub fn diagnose(
    ride: &Ride,
    bike: &Bike,
    settings: &Settings,
    conclusion: &Conclusion,
    progress: &dyn Progress,
) -> Result<Diagnosis, EngineError> {
    let prepared = Prepared::new(ride, bike, settings, conclusion)?;
    let (candidates, switched_off) = candidates(&prepared.scene);
    let samples = prepared.scene.samples * prepared.scene.tracks.len();
    let budget = Budget::new(settings.search_budget, samples);
    let search = Search {
        fitter: prepared.fitter(),
        plain: prepared.plain.clone(),
        held: prepared.split.held.clone(),
        candidates,
        alpha: settings.alpha,
        seed: settings.seed,
        until: budget.first,
        budget,
        progress,
    };
    let decision = decide(&prepared, &search, settings)?;
    Ok(tell(
        &prepared,
        &search,
        &decision,
        switched_off,
        bike,
        settings,
    ))
}
