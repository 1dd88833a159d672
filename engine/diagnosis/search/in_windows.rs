//! The same search by windows: models are fitted to every other window of one axle's record and judged on the second halves of
//! those between, whose first halves give them their starting states. No noise model is asked, and no long simulation.

use rayon::prelude::*;

use super::Search;
use super::weak_form;
use veloid_model::dataset::Windows;
use veloid_model::fit::physical::has_physical_effects;
use veloid_model::fit::shooting::{Prediction, Shooting, Shot};
use veloid_model::fit::{Fitted, Point, Term, Unit};
use veloid_model::law::{MAX_PARAMETERS, Values};
use veloid_report::diagnosis::Place;

/// Windows, spread evenly, on which starts are tried, and steps of each try.
const TRIED_ON: usize = 10;
const TRIES: usize = 5;
/// Starts that are fitted to all windows, and steps of such a fit and of one to a fold.
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

/// A set of effects as the windows of one axle see it.
#[derive(Clone)]
pub struct Seen {
    pub unit: Unit,
    /// Fitted to all windows, and to every other one in turn.
    pub point: Point,
    pub folds: [Point; 2],
    /// Held-out mean squared error of each window, beside the record's variance.
    pub errors: Vec<f64>,
}

impl Seen {
    /// Mean over the windows.
    pub fn left(&self) -> f64 {
        self.errors.iter().sum::<f64>() / self.errors.len().max(1) as f64
    }

    pub fn terms(&self) -> &[Term] {
        &self.unit.terms
    }
}

/// One axle in windows.
pub struct InWindows<'a> {
    search: &'a Search<'a>,
    shooting: Shooting<'a>,
    track: usize,
    /// Terms that act on this axle alone.
    pub candidates: Vec<Term>,
}

impl<'a> InWindows<'a> {
    pub fn new(search: &'a Search<'a>, track: usize, windows: &'a Windows) -> Self {
        let dataset = search.fitter.dataset;
        let axle = dataset.tracks[track].axle;
        let alone = |term: &&Term| term.acts_on(axle) && term.place != Place::Both;
        Self {
            search,
            track,
            shooting: Shooting {
                dataset,
                track,
                spans: &windows.spans,
                period: windows.period / dataset.step,
                variance: (dataset.tracks[track].spread().powi(2)).max(f64::MIN_POSITIVE),
            },
            candidates: search.candidates.iter().filter(alone).copied().collect(),
        }
    }

    fn count(&self) -> usize {
        self.shooting.spans.len()
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
            initial: vec![[0.0; 2]; unit.terms.len()],
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

    /// The model with several effects, one after the other.
    pub fn of_set(&self, plain: &Seen, terms: &[Term]) -> Option<Seen> {
        let mut seen = plain.clone();
        for term in terms {
            seen = self.with(&seen, *term)?;
        }
        Some(seen)
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

    /// All windows as the numbers predict them that are fitted to all.
    pub fn predictions(&self, seen: &Seen) -> Vec<Prediction> {
        let all: Vec<usize> = (0..self.count()).collect();
        self.shooting.held_out(&seen.unit, &seen.point, &all)
    }

    /// What a model leaves of some windows, beside the record's variance.
    pub fn held_out(&self, seen: &Seen, windows: &[usize]) -> Vec<f64> {
        let judged = self.shooting.held_out(&seen.unit, &seen.point, windows);
        judged
            .into_iter()
            .map(|prediction| prediction.left)
            .collect()
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
        let some: Vec<usize> = match self.count() > TRIED_ON {
            true => (0..TRIED_ON).map(|i| i * self.count() / TRIED_ON).collect(),
            false => all.clone(),
        };
        let tried = |start: &Point| self.shooting.fit(&unit, start, &some, TRIES);
        let mut ranked: Vec<Shot> = starts.par_iter().filter_map(tried).collect();
        ranked.sort_by(|a, b| a.left.total_cmp(&b.left));
        ranked.truncate(FITTED);
        let worth = FOLLOWED * ranked.first().map_or(0.0, |first| first.left);
        ranked.retain(|shot| shot.left <= worth);
        let fitted = |shot: &Shot| self.shooting.fit(&unit, &shot.point, &all, STEPS);
        let fits = ranked.par_iter().filter_map(fitted);
        let shot = fits.min_by(|a, b| a.left.total_cmp(&b.left))?;
        let mut errors = vec![f64::INFINITY; all.len()];
        let folds = [0, 1].map(|fold| {
            let (held, fitted): (Vec<usize>, Vec<usize>) =
                all.iter().partition(|w| **w % 2 == fold);
            let fit = self.shooting.fit(&unit, &shot.point, &fitted, FOLD_STEPS);
            let point = fit.map_or_else(|| shot.point.clone(), |shot| shot.point);
            let judged = self.shooting.held_out(&unit, &point, &held);
            held.iter()
                .zip(judged)
                .for_each(|(w, prediction)| errors[*w] = prediction.left);
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
