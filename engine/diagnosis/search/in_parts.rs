//! The search by parts of one axle's record: models are fitted to every other one and judged on those between. Of windows the first
//! half gives the starting state, and the second is judged. No noise model is asked.

use std::ops::Range;

use rayon::prelude::*;

use super::Search;
use super::parts::{Blocks, Parts, contiguous};
use super::weak_form;
use crate::policy;
use veloid_model::dataset::Windows;
use veloid_model::fit::physical::has_physical_effects;
use veloid_model::fit::shooting::{Shooting, Shot};
use veloid_model::fit::{Fitted, Point, Term, Unit};
use veloid_model::law::{AT_REST, MAX_PARAMETERS, Values};
use veloid_report::diagnosis::Place;

/// Steps of each try of a start.
const TRIES: usize = 5;
/// Starts that are fitted to all parts, and steps of such a fit to windows and of one to a fold.
const FITTED: usize = 2;
const STEPS: usize = 10;
const FOLD_STEPS: usize = 6;
/// Times what the best start leaves that another may leave and be fitted to all windows as well.
const FOLLOWED: f64 = 1.5;
/// Starts that are tried at most.
const MOST_STARTS: usize = 8;
/// Of these solutions of a regression at most.
const REGRESSED: usize = 3;
/// Times its scaled size at which an effect with one start is tried.
const SIZES: [f64; 3] = [0.3, 1.0, 4.0];
/// Stiffnesses beside the plain model's at which the plain model is tried.
const STIFFER: [f64; 5] = [0.1, 0.4, 1.0, 3.0, 10.0];

/// A set of effects, fitted to parts of one axle's record.
#[derive(Clone)]
pub struct Seen {
    pub unit: Unit,
    /// Fitted to all parts, and to every other one in turn.
    pub point: Point,
    pub folds: [Point; 2],
    /// Held-out mean squared error of each part, beside the record's variance.
    pub errors: Vec<f64>,
}

impl Seen {
    /// Mean over the parts.
    pub fn left(&self) -> f64 {
        self.errors.iter().sum::<f64>() / self.errors.len().max(1) as f64
    }

    pub fn terms(&self) -> &[Term] {
        &self.unit.terms
    }
}

/// One axle, in windows or in blocks of its whole record.
pub struct InParts<'a> {
    search: &'a Search<'a>,
    parts: Parts<'a>,
    track: usize,
    /// Terms that act on this axle alone.
    pub candidates: Vec<Term>,
}

impl<'a> InParts<'a> {
    pub fn new(search: &'a Search<'a>, track: usize, windows: &'a Windows) -> Self {
        let dataset = search.fitter.dataset;
        let shooting = Shooting {
            dataset,
            track,
            spans: &windows.spans,
            period: windows.period / dataset.step,
            variance: (dataset.tracks[track].spread().powi(2)).max(f64::MIN_POSITIVE),
        };
        Self::of(search, track, Parts::Windows(shooting))
    }

    /// The axle's record as one simulation, in blocks.
    pub fn whole(search: &'a Search<'a>, track: usize) -> Self {
        let white = search.plain.noise_model(track).bleached();
        let blocks = Blocks::new(search.fitter.dataset, track, policy::BLOCKS, white);
        Self::of(search, track, Parts::Blocks(blocks))
    }

    fn of(search: &'a Search<'a>, track: usize, parts: Parts<'a>) -> Self {
        let axle = search.fitter.dataset.tracks[track].axle;
        let alone = |term: &&Term| term.acts_on(axle) && term.place != Place::Both;
        Self {
            search,
            track,
            parts,
            candidates: search.candidates.iter().filter(alone).copied().collect(),
        }
    }

    fn count(&self) -> usize {
        self.parts.count()
    }

    fn unit(&self, terms: &[Term]) -> Unit {
        let mut terms = terms.to_vec();
        terms.sort();
        Unit {
            tracks: vec![self.track],
            terms,
        }
    }

    /// The model without effects.
    pub fn plain(&self) -> Option<Seen> {
        let unit = self.unit(&[]);
        let (known, _) = self.search.plain.carried(&unit);
        let starts = STIFFER.map(|stiffer| {
            let mut point = known.clone();
            point.base[0].kappa *= stiffer;
            point
        });
        self.best(unit, starts.to_vec())
    }

    /// A model with one effect more, from the effect's own starts, from what the equation of motion as a regression says, and from
    /// where fits of the whole record have led.
    pub fn with(&self, parent: &Seen, term: Term) -> Option<Seen> {
        let mut terms = parent.unit.terms.clone();
        terms.push(term);
        let unit = self.unit(&terms);
        let at = unit.terms.iter().position(|t| *t == term)?;
        let mut base = Point {
            base: parent.point.base.clone(),
            values: vec![[0.0; MAX_PARAMETERS]; unit.terms.len()],
            initial: vec![AT_REST; unit.terms.len()],
        };
        for (known, values) in parent.unit.terms.iter().zip(&parent.point.values) {
            if let Some(i) = unit.terms.iter().position(|t| t == known) {
                base.values[i] = *values;
            }
        }
        let mut starts = weak_form::starts(&self.search.fitter, &unit, at, &base);
        starts.truncate(REGRESSED);
        starts.extend(self.own_starts(&unit, at).into_iter().map(|values| {
            let mut point = base.clone();
            point.values[at] = values;
            point
        }));
        starts.truncate(MOST_STARTS);
        self.best(unit, starts)
    }

    /// A model that fits of the whole record have led to.
    pub fn known(&self, fit: &Fitted) -> Option<Seen> {
        self.best(self.unit(&fit.unit.terms), vec![fit.point.clone()])
    }

    /// A model from where others than these windows have led to.
    pub fn from(&self, unit: Unit, start: Point) -> Option<Seen> {
        self.best(unit, vec![start])
    }

    pub fn is_physical(&self, seen: &Seen) -> bool {
        has_physical_effects(self.search.fitter.dataset, &seen.unit, &seen.point)
    }

    /// Fits of a model without each of some groups of neighbouring parts in turn.
    pub fn without_each(&self, seen: &Seen, groups: usize) -> Vec<Point> {
        let count = self.count();
        let fit = |left_out: Range<usize>| {
            let kept: Vec<usize> = (0..count).filter(|part| !left_out.contains(part)).collect();
            let steps = self.parts.steps(FOLD_STEPS);
            self.parts.fit(&seen.unit, &seen.point, &kept, steps)
        };
        let all: Vec<Range<usize>> = contiguous(count, groups).collect();
        let fits = all.into_par_iter().filter_map(fit);
        fits.map(|shot| shot.point).collect()
    }

    /// Starts of the effect itself.
    fn own_starts(&self, unit: &Unit, at: usize) -> Vec<Values> {
        let spec = unit.terms[at].kind.spec();
        let scale = unit.scale(self.search.fitter.dataset, at);
        let starts = (spec.starts)(scale);
        if starts.len() > SIZES.len() || spec.amplitudes.is_empty() {
            return starts;
        }
        let mut found = Vec::new();
        for start in starts {
            for size in SIZES {
                for sign in [1.0, -1.0] {
                    let mut values = start;
                    for a in spec.amplitudes {
                        values[*a] *= size * sign;
                    }
                    let within = spec.amplitudes.iter().all(|a| {
                        let [low, high] = (spec.parameters[*a].limits)(scale);
                        (low..=high).contains(&values[*a])
                    });
                    if within {
                        found.push(values);
                    }
                }
            }
        }
        found
    }

    /// The best fit from several starts, and what windows say of it that were not fitted.
    fn best(&self, unit: Unit, starts: Vec<Point>) -> Option<Seen> {
        let all: Vec<usize> = (0..self.count()).collect();
        let some = self.parts.some();
        let tried = |start: &Point| self.parts.fit(&unit, start, &some, TRIES);
        let mut ranked: Vec<Shot> = starts.par_iter().filter_map(tried).collect();
        ranked.sort_by(|a, b| a.left.total_cmp(&b.left));
        ranked.truncate(FITTED);
        let worth = FOLLOWED * ranked.first().map_or(0.0, |first| first.left);
        ranked.retain(|shot| shot.left <= worth);
        let steps = |of_windows| self.parts.steps(of_windows);
        let fitted = |shot: &Shot| self.parts.fit(&unit, &shot.point, &all, steps(STEPS));
        let fits = ranked.par_iter().filter_map(fitted);
        let shot = fits.min_by(|a, b| a.left.total_cmp(&b.left))?;
        let mut errors = vec![f64::INFINITY; all.len()];
        let folds = [0, 1].map(|fold| {
            let (held, fitted): (Vec<usize>, Vec<usize>) =
                all.iter().partition(|w| **w % 2 == fold);
            let fit = self
                .parts
                .fit(&unit, &shot.point, &fitted, steps(FOLD_STEPS));
            let point = fit.map_or_else(|| shot.point.clone(), |shot| shot.point);
            let judged = self.parts.held_out(&unit, &point, &held);
            held.iter()
                .zip(judged)
                .for_each(|(w, left)| errors[*w] = left);
            point
        });
        Some(Seen {
            unit,
            point: shot.point,
            folds,
            errors,
        })
    }
}
