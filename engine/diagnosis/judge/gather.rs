//! The scores of every axle: proposed sets of effects are fitted to windows of two lengths and judged on those that were held out.
//! Nothing is decided here.

use rayon::prelude::*;

use super::proposals::proposals;
use super::scores::{ScoredLength, ScoredSet, Scores};
use super::weights::MOST;
use crate::policy;
use crate::search::Search;
use crate::search::in_windows::{InWindows, Seen};
use crate::verdict::affirm::{self, is_part_of_a_curve};
use crate::verdict::by_windows::missed;
use crate::verdict::partly::{of_squares, search_by_squares};
use crate::verdict::twice::divided;
use crate::verdict::windows::parameters;
use veloid_core::EngineError;
use veloid_core::bicycle::PerAxle;
use veloid_core::numerics::spectrum::deviation;
use veloid_model::dataset::{Dataset, Track, Windows};
use veloid_model::fit::{Fitted, Model, Term};
use veloid_model::law::Family;

/// Times the search's budget that the scores may take.
const BUDGET: u64 = 3;

/// The scores of every axle that no road drives and whose record has windows; `proposed` are models of the whole record.
pub fn scores(
    search: &Search,
    record: &Dataset,
    proposed: &[Model],
) -> Result<PerAxle<Scores>, EngineError> {
    let mut found = PerAxle::default();
    let dataset = of_squares(record);
    let asked: Vec<bool> = dataset
        .tracks
        .iter()
        .map(|t| !dataset.is_ridden(t))
        .collect();
    let until = search.fitter.dataset.work.done() + BUDGET * search.budget.steps;
    let Some(again) = search_by_squares(search, &dataset, &asked, until) else {
        return Ok(found);
    };
    for t in (0..dataset.tracks.len()).filter(|t| asked[*t]) {
        let fits = proposed.iter().flat_map(|model| &model.fits);
        let own = |fit: &&Fitted| {
            let terms = &fit.unit.terms;
            fit.unit.tracks == [t] && terms.iter().all(|term| again.candidates.contains(term))
        };
        let fits: Vec<&Fitted> = fits
            .filter(own)
            .filter(|fit| !fit.unit.terms.is_empty())
            .collect();
        if let Some(scores) = of_track(&again, t, &fits)? {
            found.set(dataset.tracks[t].axle, scores);
        }
    }
    Ok(found)
}

fn of_track(
    search: &Search,
    t: usize,
    proposed: &[&Fitted],
) -> Result<Option<Scores>, EngineError> {
    let dataset = search.fitter.dataset;
    let track = &dataset.tracks[t];
    let Some(windows) = divided(track, dataset.samples) else {
        return Ok(None);
    };
    let axles = windows
        .each_ref()
        .map(|windows| InWindows::new(search, t, windows));
    let [long, short] = &axles;
    let Some(sets) = proposals(search, long, proposed)? else {
        return Ok(None);
    };
    let again = |seen: &Seen| short.from(seen.unit.clone(), seen.point.clone());
    let seen: Vec<[Seen; 2]> = (sets.into_par_iter())
        .filter_map(|seen| Some([seen.clone(), again(&seen)?]))
        .collect();
    search.check()?;
    let mut terms: Vec<Term> = seen.iter().flat_map(|s| s[0].terms().to_vec()).collect();
    terms.sort();
    terms.dedup();
    Ok(Some(Scores {
        lengths: windows.iter().map(|w| length(track, w)).collect(),
        missed_force: missed(dataset, t),
        effects: terms
            .iter()
            .map(|term| term.id(dataset).to_owned())
            .collect(),
        sets: seen
            .iter()
            .map(|seen| scored(seen, &terms, &axles))
            .collect(),
    }))
}

fn scored(seen: &[Seen; 2], terms: &[Term], axles: &[InWindows; 2]) -> ScoredSet {
    let own = seen[0].terms();
    let place = |term: &Term| terms.iter().position(|t| t == term);
    ScoredSet {
        effects: own.iter().filter_map(place).collect(),
        parameters: parameters(own),
        is_general: own.iter().any(|term| term.kind.spec().is_general),
        is_physical: !draws_a_curve(own)
            && axles
                .iter()
                .zip(seen)
                .all(|(axle, seen)| axle.is_physical(seen)),
        left: seen.iter().map(|seen| blocks(&seen.errors)).collect(),
    }
}

/// Whether several springs, alike in both directions, draw a curve that has no name.
fn draws_a_curve(terms: &[Term]) -> bool {
    terms
        .iter()
        .any(|term| is_part_of_a_curve(*term, terms, Family::Spring))
}

fn length(track: &Track, windows: &Windows) -> ScoredLength {
    let samples = windows.length();
    let variance = track.spread().powi(2).max(f64::MIN_POSITIVE);
    ScoredLength {
        length_s: samples as f64 * track.input.step,
        samples: windows.spans.len() * (samples - samples / 2),
        noise: deviation(track.sensor_floor, track.input.step).powi(2) / variance,
    }
}

/// Means over blocks of neighbouring windows; a model that runs away leaves [`MOST`].
fn blocks(errors: &[f64]) -> Vec<f64> {
    affirm::blocks(errors.len(), policy::BLOCKS.min(errors.len()))
        .map(|block| errors[block.clone()].iter().sum::<f64>() / block.len() as f64)
        .map(|mean| mean.min(MOST))
        .collect()
}
