//! What the judge's table says of the axles of a record, as a model with what speaks for its effects.

use crate::judge::Evidence;
use crate::judge::numbers::Numbers;
use crate::judge::table::{Judgement, Rule, judge, place_of};
use crate::search::Search;
use crate::search::in_parts::{InParts, Seen};
use crate::search::squares::{of_squares, search_by_squares};
use veloid_core::bicycle::PerAxle;
use veloid_core::plant::Coefficient;
use veloid_model::dataset::{Dataset, Track};
use veloid_model::fit::{Effort, Fitted, Model, Point, Term};
use veloid_report::diagnosis::Verdict;
use veloid_report::windows::Support;

/// Parts that the jackknife leaves out in turn.
const JACKKNIFE: usize = 5;
/// Steps of a fit of a model's start along the whole record.
const STARTED: usize = 8;

/// An effect of a model with the evidence for it, and whether that is enough.
pub struct Claim {
    pub term: Term,
    pub support: Support,
    pub holds: bool,
}

/// Effects that are affirmed although something else may be left, or at least are the nearest shape.
pub struct Partly {
    /// The model with these effects, and the plain one, both fitted to the plain squares.
    pub model: Model,
    pub plain: Model,
    pub claims: Vec<Claim>,
    /// Standard errors of what is reported of each claim's effect, and of k (N/m) and B (N s/m).
    pub effect_errors: Vec<Vec<f64>>,
    pub base_errors: PerAxle<[f64; 2]>,
    /// Errors in windows that were not fitted.
    pub in_windows: PerAxle<Predictions>,
}

/// Errors of predictions over a part of a second window, each from a start of its own.
#[derive(Clone, Copy, Debug)]
pub struct Predictions {
    /// Over how long (s).
    pub horizon: f64,
    /// RMS (m, or N where a force is predicted) of the plain and the extended model.
    pub plain: f64,
    pub extended: f64,
}

/// An axle's evidence and what the table reads from it.
pub struct Read {
    pub evidence: Evidence,
    pub judgement: Judgement,
}

impl Read {
    pub fn new(evidence: Evidence, is_ridden: bool) -> Self {
        let numbers = match is_ridden {
            true => Numbers::on_road(),
            false => Numbers::default(),
        };
        Self {
            judgement: judge(&evidence.scores, &numbers),
            evidence,
        }
    }

    fn rule(&self) -> Rule {
        self.judgement.rule
    }

    /// Whether nothing is missing: the table says so, or no effect takes its share of windows and the likelihood has found `nothing`. Of
    /// the whole record, from which a mass without a spring drifts away, a likelihood with coloured noise takes anything for noise.
    fn lacks_nothing(&self, nothing: bool) -> bool {
        match self.rule() {
            Rule::NothingMissed | Rule::NoiseLeft => true,
            Rule::Unsupported => {
                let in_windows = self.evidence.scores.lengths.len() > 1;
                nothing && in_windows && self.judgement.is_idle
            }
            _ => false,
        }
    }

    /// Whether all that is missing on the axle has a name, or nothing is.
    fn is_complete(&self) -> bool {
        match self.rule() {
            Rule::NothingMissed | Rule::NoiseLeft => true,
            Rule::Supported => self.judgement.is_complete,
            _ => false,
        }
    }

    /// The sets that the verdict speaks of, the first of which is reported; of what has no name the nearest shape.
    fn sets(&self) -> Vec<&Vec<Seen>> {
        let scores = &self.evidence.scores;
        let places: Vec<usize> = match self.rule() {
            Rule::Supported | Rule::Tied => (self.judgement.sets.iter())
                .filter_map(|set| place_of(scores, set))
                .collect(),
            Rule::GeneralLaw | Rule::Unsupported => self.judgement.nearest.into_iter().collect(),
            _ => Vec::new(),
        };
        places.iter().map(|p| &self.evidence.sets[*p]).collect()
    }

    fn claim(&self, term: Term) -> Claim {
        let place = self.evidence.terms.iter().position(|t| *t == term);
        Claim {
            term,
            holds: place.is_some_and(|e| self.judgement.named.contains(&e)),
            support: place
                .map(|e| self.judgement.support(&self.evidence.scores, e))
                .unwrap_or_default(),
        }
    }
}

/// The verdict on all axles that are asked, and the rule of the axle that decides. Of a measured road the likelihood has
/// found more than noise beside every named effect; on a bench it may have found `nothing`.
pub fn verdict(
    asked: &[bool],
    (has_road, nothing): (bool, bool),
    read: &[Option<Read>],
) -> (Verdict, Rule) {
    if let Some(first) = read.iter().flatten().next()
        && !has_road
        && read
            .iter()
            .all(|r| r.as_ref().is_some_and(|r| r.lacks_nothing(nothing)))
    {
        let rule = match first.rule() {
            Rule::NothingMissed => Rule::NothingMissed,
            _ => Rule::NoiseLeft,
        };
        return (Verdict::NothingMissing, rule);
    }
    let first = |wanted: &dyn Fn(&Read) -> bool| read.iter().flatten().find(|r| wanted(r));
    let all_known = (read.iter().zip(asked)).all(|(read, asked)| read.is_some() || !asked);
    if let Some(named) = first(&|r| r.rule() == Rule::Supported) {
        return match all_known && !has_road && first(&|r| !r.is_complete()).is_none() {
            true => (Verdict::Named, named.rule()),
            false => (Verdict::NamedInPart, named.rule()),
        };
    }
    if first(&|r| r.rule() == Rule::Tied).is_some() {
        return (Verdict::Ambiguous, Rule::Tied);
    }
    if let Some(nameless) = first(&|r| matches!(r.rule(), Rule::GeneralLaw | Rule::Unsupported)) {
        return (Verdict::Unnamed, nameless.rule());
    }
    match has_road {
        true => (Verdict::Unnamed, Rule::Likelihood),
        false => (Verdict::CannotTell, Rule::NotFollowed),
    }
}

/// The model that the verdict speaks of, along the whole record, and those that tie with it; nothing where it has no fit.
pub fn models(
    search: &Search,
    record: &Dataset,
    read: &[Option<Read>],
) -> Option<(Partly, Vec<Model>)> {
    let dataset = of_squares(record);
    let every = vec![true; dataset.tracks.len()];
    let again = search_by_squares(search, &dataset, &every, search.until)?;
    let mut model = again.plain.clone();
    let (mut claims, mut effect_errors) = (Vec::new(), Vec::new());
    let (mut base_errors, mut in_windows) = (PerAxle::default(), PerAxle::default());
    let mut others: Vec<Fitted> = Vec::new();
    for (t, read) in read.iter().enumerate() {
        let Some(read) = read else { continue };
        let sets = read.sets();
        let Some(first) = sets.first() else { continue };
        let fit = whole(&again, t, &first[0])?;
        let points = Refits::of(&again, t, first);
        for term in &fit.unit.terms {
            effect_errors.push(effect_error(&dataset, &fit, *term, &points));
            claims.push(read.claim(*term));
        }
        let track = &dataset.tracks[t];
        base_errors.set(track.axle, base_error(&points));
        if let Some(predictions) = predictions(read, first, track) {
            in_windows.set(track.axle, predictions);
        }
        model = model.with(fit);
        others.extend(
            sets[1..]
                .iter()
                .filter_map(|seen| whole(&again, t, &seen[0])),
        );
    }
    let tied = others.into_iter().map(|fit| model.with(fit)).collect();
    let partly = Partly {
        model,
        plain: again.plain,
        claims,
        effect_errors,
        base_errors,
        in_windows,
    };
    Some((partly, tied))
}

/// A model of one axle along the whole record, with a start of its own.
fn whole(again: &Search, t: usize, seen: &Seen) -> Option<Fitted> {
    let dataset = again.fitter.dataset;
    let (plain, _) = again.plain.of_track(t);
    let mut point = seen.point.clone();
    point.base[0] = point.base[0].starting_as(&plain.point.base[0]);
    let effort = Effort {
        iterations: STARTED,
        gain: 1e-2,
        substeps: seen.unit.fine_substeps(dataset, &seen.point),
    };
    (again.fitter).started(&seen.unit, &point, &plain.noise_models, effort)
}

/// What the longer windows leave; nothing where the whole record was judged, and where the motion is prescribed, since the
/// force has no initial state that drifts away from the record.
fn predictions(read: &Read, seen: &[Seen], track: &Track) -> Option<Predictions> {
    if track.input.prescribed {
        return None;
    }
    let scores = &read.evidence.scores;
    let windows = scores.lengths.first().filter(|_| seen.len() > 1)?;
    let rms = |left: f64| track.spread() * left.sqrt();
    Some(Predictions {
        horizon: 0.5 * windows.length_s,
        plain: rms(scores.plain()?.mean(0)),
        extended: rms(seen[0].left()),
    })
}

/// Fits of a model to parts of the record, from which its errors are read.
enum Refits {
    /// To the folds of windows of two lengths.
    Folds(Vec<Point>),
    /// Without each fifth of the whole record.
    Jackknife(Vec<Point>),
}

impl Refits {
    fn of(search: &Search, t: usize, seen: &[Seen]) -> Self {
        match seen {
            [whole] => {
                let view = InParts::whole(search, t);
                Self::Jackknife(view.without_each(whole, JACKKNIFE))
            }
            windows => {
                let folds = windows.iter().flat_map(|seen| &seen.folds);
                Self::Folds(folds.cloned().collect())
            }
        }
    }

    fn points(&self) -> &[Point] {
        match self {
            Self::Folds(points) | Self::Jackknife(points) => points,
        }
    }

    /// Standard error of a number that each fit shows: half of what folds spread, or the delete-a-block jackknife's, infinite where a
    /// part has no fit (Efron & Tibshirani 1993, eq. 11.5).
    fn error(&self, value: impl Fn(&Point) -> f64) -> f64 {
        let values: Vec<f64> = self.points().iter().map(value).collect();
        match self {
            Self::Folds(_) => {
                let low = values.iter().copied().fold(f64::INFINITY, f64::min);
                let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                0.5 * (high - low)
            }
            Self::Jackknife(_) if values.len() < JACKKNIFE => f64::INFINITY,
            Self::Jackknife(_) => {
                let count = values.len() as f64;
                let mean = values.iter().sum::<f64>() / count;
                let squares: f64 = values.iter().map(|x| (x - mean).powi(2)).sum();
                ((count - 1.0) / count * squares).sqrt()
            }
        }
    }
}

/// What is reported of an effect.
fn reported(dataset: &Dataset, fit: &Fitted, term: Term) -> Option<Vec<f64>> {
    let at = fit.unit.terms.iter().position(|t| *t == term)?;
    let scale = fit.unit.scale(dataset, at);
    let reported = (term.kind.spec().report)(&fit.point.values[at], scale);
    Some(reported.into_iter().map(|r| r.value).collect())
}

/// Standard errors of what is reported of an effect.
fn effect_error(dataset: &Dataset, fit: &Fitted, term: Term, refits: &Refits) -> Vec<f64> {
    let numbers = |point: &Point| {
        let at = Fitted {
            point: point.clone(),
            ..fit.clone()
        };
        reported(dataset, &at, term).unwrap_or_default()
    };
    let count = numbers(&fit.point).len();
    (0..count)
        .map(|r| refits.error(|point| numbers(point)[r]))
        .collect()
}

/// The same of k (N/m) and B (N s/m).
fn base_error(refits: &Refits) -> [f64; 2] {
    [Coefficient::Kappa, Coefficient::Beta]
        .map(|number| refits.error(|point| point.base[0].get(number) / point.base[0].per_mass))
}

#[cfg(test)]
mod tests {
    use super::*;
    use veloid_core::plant::Coefficients;

    #[test]
    fn errors_are_what_folds_spread_or_the_jackknifes() {
        let points = |values: &[f64]| -> Vec<Point> {
            let point = |value: &f64| Point {
                base: vec![Coefficients {
                    kappa: *value,
                    ..Coefficients::default()
                }],
                values: Vec::new(),
                initial: Vec::new(),
            };
            values.iter().map(point).collect()
        };
        let kappa = |point: &Point| point.base[0].kappa;
        let folds = Refits::Folds(points(&[3.0, -1.0, 2.0]));
        assert_eq!(folds.error(kappa), 2.0);
        // Of a mean of five the jackknife gives the error of the mean.
        let left_out = [2.0, 4.0, 6.0, 8.0, 10.0].map(|x| (30.0 - x) / 4.0);
        let error = Refits::Jackknife(points(&left_out)).error(kappa);
        assert!(
            (error - (40.0_f64 / 4.0 / 5.0).sqrt()).abs() < 1e-12,
            "{error}"
        );
        assert_eq!(
            Refits::Jackknife(points(&[1.0])).error(kappa),
            f64::INFINITY
        );
    }
}
