//! The evidence of every axle: proposed sets of effects are fitted to parts of its record and judged on those that were held out.
//! Nothing is decided here.

use std::ops::Range;

use rayon::prelude::*;

use super::numbers::Numbers;
use super::proposals::{has_limit, parameters, proposals};
use super::scores::{ScoredLength, ScoredSet, Scores};
use super::table::{Rule, judge};
use super::weights::MOST;
use crate::policy;
use crate::search::Search;
use crate::search::in_parts::{InParts, Seen};
use crate::search::parts::contiguous;
use crate::search::squares::{of_squares, search_by_squares};
use crate::search::weak_form;
use veloid_core::EngineError;
use veloid_model::dataset::windows::dominant_period;
use veloid_model::dataset::{Dataset, Track, Windows};
use veloid_model::fit::{Fitted, Model, Term};
use veloid_model::law::Family;

/// Times the search's budget that the scores may take.
const BUDGET: u64 = 2;

/// What was tried on one axle.
pub struct Evidence {
    pub scores: Scores,
    /// The effects of `scores`.
    pub terms: Vec<Term>,
    /// The sets of `scores`, by length.
    pub sets: Vec<Vec<Seen>>,
}

/// What was tried on each track that is `asked`; `proposed` are models of the whole record.
pub fn evidence(
    search: &Search,
    record: &Dataset,
    asked: &[bool],
    proposed: &[Model],
) -> Result<Vec<Option<Evidence>>, EngineError> {
    let dataset = of_squares(record);
    let until = search.fitter.dataset.work.done() + BUDGET * search.budget.steps;
    let Some(again) = search_by_squares(search, &dataset, asked, until) else {
        return Ok(asked.iter().map(|_| None).collect());
    };
    let of_track = |(t, asked): (usize, &bool)| {
        let fits = proposed.iter().flat_map(|model| &model.fits);
        let own = |fit: &&Fitted| {
            let terms = &fit.unit.terms;
            fit.unit.tracks == [t]
                && (1..=policy::MOST_BY_WINDOWS).contains(&terms.len())
                && !has_limit(terms)
                && terms.iter().all(|term| again.candidates.contains(term))
        };
        let fits: Vec<&Fitted> = fits.filter(own).collect();
        match asked {
            true => of_track(&again, t, &fits),
            false => Ok(None),
        }
    };
    asked.iter().enumerate().map(of_track).collect()
}

/// By windows of two lengths, or by the whole record: where these follow nothing, since a short record has no room for them; without a
/// spring that holds the mass, since a window's free start hides what a mass does that was at rest; and on a road, whose axle is
/// damped and does not drift.
fn of_track(
    search: &Search,
    t: usize,
    proposed: &[&Fitted],
) -> Result<Option<Evidence>, EngineError> {
    let dataset = search.fitter.dataset;
    let track = &dataset.tracks[t];
    let has_start = !dataset.is_ridden(track)
        && dataset.is_held
        && (track.input.force.is_none() || track.swings());
    if let Some(windows) = divided(track, dataset.samples).filter(|_| has_start) {
        let views = windows
            .each_ref()
            .map(|windows| InParts::new(search, t, windows));
        let lengths = windows.iter().map(|w| length(track, w)).collect();
        let found = gathered(search, t, (&views, lengths), proposed)?;
        let follows =
            |found: &Evidence| judge(&found.scores, &Numbers::default()).rule != Rule::NotFollowed;
        if let Some(found) = found.filter(follows) {
            return Ok(Some(found));
        }
    }
    let view = InParts::whole(search, t);
    gathered(search, t, (&[view], vec![whole(track)]), proposed)
}

fn gathered(
    search: &Search,
    t: usize,
    (views, lengths): (&[InParts], Vec<ScoredLength>),
    proposed: &[&Fitted],
) -> Result<Option<Evidence>, EngineError> {
    let dataset = search.fitter.dataset;
    let track = &dataset.tracks[t];
    let Some(proposed) = proposals(search, &views[0], proposed)? else {
        return Ok(None);
    };
    let in_all = |first: Seen| -> Option<Vec<Seen>> {
        let again = |view: &InParts| view.from(first.unit.clone(), first.point.clone());
        let others: Option<Vec<Seen>> = views[1..].iter().map(again).collect();
        others.map(|others| [vec![first], others].concat())
    };
    let sets: Vec<Vec<Seen>> = proposed.into_par_iter().filter_map(in_all).collect();
    search.check()?;
    let mut terms: Vec<Term> = sets.iter().flat_map(|s| s[0].terms().to_vec()).collect();
    terms.sort();
    terms.dedup();
    let name = |term: &Term| term.id(dataset).to_owned();
    let scores = Scores {
        lengths,
        missed_force: missed(dataset, track),
        effects: terms.iter().map(name).collect(),
        sets: (sets.iter())
            .map(|seen| {
                let mut set = scored(seen, &terms, views);
                set.is_physical &= holds(dataset, track, &seen[0]);
                set
            })
            .collect(),
    };
    Ok(Some(Evidence {
        scores,
        terms,
        sets,
    }))
}

/// Whether a spring of the model pulls back, where it is asked whether there is one.
fn holds(dataset: &Dataset, track: &Track, seen: &Seen) -> bool {
    dataset.is_held || !track.plant.has_spring() || seen.point.base[0].kappa > 0.0
}

fn scored(seen: &[Seen], terms: &[Term], views: &[InParts]) -> ScoredSet {
    let own = seen[0].terms();
    let place = |term: &Term| terms.iter().position(|t| t == term);
    ScoredSet {
        effects: own.iter().filter_map(place).collect(),
        parameters: parameters(own),
        is_general: own.iter().any(|term| term.kind.spec().is_general),
        is_physical: !draws_a_curve(own)
            && views
                .iter()
                .zip(seen)
                .all(|(view, seen)| view.is_physical(seen)),
        left: seen.iter().map(|seen| blocks(&seen.errors)).collect(),
    }
}

/// Whether several springs, alike in both directions, draw a curve that has no name. One of them beside a law that differs between the
/// directions does not, since a curve has one odd and one even part.
fn draws_a_curve(terms: &[Term]) -> bool {
    let is_one = |t: &&Term| t.kind.is_named(Family::Spring) && t.kind.spec().is_odd;
    terms.iter().filter(is_one).count() > 1
}

/// Share of the force on the mass (RMS) that the plain model misses.
fn missed(dataset: &Dataset, track: &Track) -> Option<f64> {
    weak_form::missed(dataset, track, dataset.samples, dominant_period(track)?)
}

/// A record in ordinary windows and in shorter ones, or where it has no room for these, in others between the ordinary ones.
fn divided(track: &Track, samples: usize) -> Option<[Windows; 2]> {
    let of_length = |times| Windows::of(track, samples, times);
    let ordinary = of_length(1.0)?;
    let shorter = of_length(policy::SHORTER).filter(|w| w.length() < ordinary.length());
    let others = shorter.or_else(|| ordinary.between(samples))?;
    Some([ordinary, others])
}

fn length(track: &Track, windows: &Windows) -> ScoredLength {
    let samples = windows.length();
    ScoredLength {
        length_s: samples as f64 * track.input.step,
        parts: windows.spans.len(),
        samples: windows.spans.len() * (samples - samples / 2),
        noise: noise(track),
    }
}

fn whole(track: &Track) -> ScoredLength {
    ScoredLength {
        length_s: track.valid.len() as f64 * track.input.step,
        parts: policy::BLOCKS,
        samples: track.valid.iter().filter(|v| **v).count(),
        noise: noise(track),
    }
}

/// Noise that was declared or measured.
fn noise(track: &Track) -> f64 {
    let noise = track.sensor_noise().unwrap_or_default();
    (noise / track.spread().max(f64::MIN_POSITIVE)).powi(2)
}

/// Means over blocks of neighbouring parts; a model that runs away leaves [`MOST`].
fn blocks(errors: &[f64]) -> Vec<f64> {
    let count = policy::BLOCKS.min(errors.len());
    let mean = |block: Range<usize>| errors[block.clone()].iter().sum::<f64>() / block.len() as f64;
    contiguous(errors.len(), count)
        .map(|block| mean(block).min(MOST))
        .collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::example;

    /// A mass without a spring that swings with a period of 1 s, let go.
    fn swinging(samples: usize) -> Track {
        let mut track = example::dataset().tracks[0].clone();
        track.set_road(&vec![0.0; samples]);
        track.has_road = false;
        track.plant = &veloid_core::plant::Damper::MOVING;
        let seconds = |i: usize| track.input.step * i as f64;
        track.measured = (0..samples)
            .map(|i| (std::f64::consts::TAU * seconds(i)).sin())
            .collect();
        track.valid = vec![true; samples];
        track
    }

    #[test]
    fn the_second_windows_are_shorter_or_lie_between_the_first() {
        let of = |samples: usize| divided(&swinging(samples), samples).unwrap();
        let [ordinary, shorter] = of(6000).map(|w| w.length() as f64);
        assert!((shorter - policy::SHORTER * ordinary).abs() <= 1.0);
        let [ordinary, between] = of(150 * policy::FEWEST_WINDOWS);
        assert_eq!(ordinary.length(), between.length());
        let half = ordinary.spans[0].start + ordinary.length() / 2;
        assert_eq!(between.spans[0].start, half);
    }

    #[test]
    fn parts_are_compared_in_so_many_blocks() {
        let errors = vec![1.0; 4 * policy::BLOCKS];
        assert_eq!(blocks(&errors), vec![1.0; policy::BLOCKS]);
        assert_eq!(blocks(&errors[..3]), [1.0; 3]);
        assert_eq!(blocks(&[f64::INFINITY]), [MOST]);
    }
}
