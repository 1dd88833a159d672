//! The search for effects: each one's trace beside what is known, fits of the promising, and again beside the best.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::fit::{Fit, Frame};
use super::lines::{has_line, lines};
use super::model::{Model, axle_of};
use super::nuisance::Course;
use super::record::Record;
use super::roles::is_linear;
use crate::policy;
use veloid_core::bicycle::PerAxle;
use veloid_core::{EngineError, Progress};
use veloid_model::effects::Kind;
use veloid_model::fit::Term;
use veloid_model::law::{Scale, Values};

/// Part of its start's size at which an effect's trace is taken.
const SMALL: f64 = 0.03;
/// Starts of an effect that are tried at most.
const MOST_STARTS: usize = 24;
/// Candidates that are fitted, first and beside others, and the share of the best one's trace that they must have.
const FITTED: usize = 7;
const FITTED_BESIDE: usize = 4;
const PROMISING: f64 = 0.04;
/// Gain (of twice the log likelihood) of a trace that is worth a fit.
const WORTH: f64 = 8.0;
const ITERATIONS: usize = 9;
/// The same of a model that is known.
const SETTLED: usize = 3;
/// Gain of twice the log likelihood below which a fit ends, and one that is to be exact.
const ENOUGH: f64 = 1.0;
const EXACT: f64 = 0.1;

/// An effect at the size that its trace suggests.
pub struct Scored {
    pub term: Term,
    pub values: Values,
    /// Gain of twice the log likelihood.
    pub gain: f64,
    /// The same with a size of one standard error.
    pub unit: Values,
    /// As of [`Model`].
    pub rolled: Vec<f64>,
}

impl Scored {
    fn beside(&self, known: &Model) -> Model {
        let mut model = known.with(self.term, self.values);
        if !self.rolled.is_empty() {
            model.rolled.clone_from(&self.rolled);
        }
        model
    }
}

/// Everything that the search has come to.
pub struct Found {
    pub courses: Vec<Course>,
    pub plain: Fit,
    /// Fits of the rounds that have led to something, each round beside the last one's best.
    pub fits: Vec<Fit>,
    pub best: Fit,
    /// What one more effect would gain.
    pub left: f64,
    /// One that is linear as the axles are and gains something.
    pub doubt: Option<Term>,
    /// Traces of all candidates beside the best model.
    pub traces: Vec<Scored>,
}

/// The search on one record.
pub struct Search<'a> {
    pub record: &'a Record,
    pub scales: &'a PerAxle<Scale>,
    pub candidates: &'a [Term],
    /// Models with a second mass, by their spectra: starts whose k and B may be far from the plain ones.
    pub linear: &'a [Model],
    pub progress: &'a dyn Progress,
}

impl Search<'_> {
    pub fn run(&self, plain: Fit, courses: Vec<Course>) -> Result<Option<Found>, EngineError> {
        let mut found = Found {
            fits: Vec::new(),
            best: plain.clone(),
            plain,
            courses,
            left: 0.0,
            doubt: None,
            traces: Vec::new(),
        };
        for round in 0..policy::MOST_TERMS {
            if self.progress.cancelled() {
                return Err(EngineError::Cancelled);
            }
            match self.round(round, &mut found) {
                Some(true) => {}
                Some(false) => break,
                None => return Ok(None),
            }
        }
        Ok(Some(found))
    }

    /// Looks for one more effect; whether there is one. Nothing where a fit fails.
    fn round(&self, round: usize, found: &mut Found) -> Option<bool> {
        let base = found.best.model.clone();
        let frame = self.frame(&found.courses, &base)?;
        let known = frame.fit(&base, SETTLED, EXACT)?;
        found.traces = self.scored(&frame, &known.model);
        let most = if round == 0 { FITTED } else { FITTED_BESIDE };
        let mut fits = self.fits(&frame, &known.model, &found.traces, most);
        if round == 0 {
            let linear = self.linear.par_iter();
            let linear = linear.filter_map(|model| frame.fit(model, ITERATIONS, ENOUGH));
            fits.extend(linear.collect::<Vec<_>>());
        }
        let highest = self.record.hz(self.record.lines.len());
        fits.retain(|fit| is_seen(&fit.model, highest));
        fits.sort_by(|a, b| self.charged(a).total_cmp(&self.charged(b)));
        found.left = 0.0;
        found.doubt = self.doubt(&known, &fits);
        let Some(best) = self.preferred(&known, &fits) else {
            return Some(false);
        };
        found.left = self.charged(&known) - self.charged(&best);
        let first = self.charged(&found.plain) - self.charged(&known);
        let wanted = wanted(round, first);
        tracing::debug!(?round, gained = found.left, wanted, best = ?best.model, "one more effect");
        if found.left < wanted {
            return Some(false);
        }
        found.fits.extend(fits);
        // The nuisances were those of the poorer model.
        let mut fit = best;
        for _ in 0..2 {
            found.courses = self
                .frame(&found.courses, &fit.model)?
                .settled(&fit.model)?;
            fit = self
                .frame(&found.courses, &fit.model)?
                .fit(&fit.model, ITERATIONS, EXACT)?;
        }
        (found.best, found.left) = (fit, 0.0);
        Some(true)
    }

    pub fn frame<'f>(&'f self, courses: &'f [Course], model: &Model) -> Option<Frame<'f>> {
        Frame::around(self.record, self.scales, courses, model)
    }

    /// Fits of the most promising candidates beside a model.
    fn fits(&self, frame: &Frame, known: &Model, traces: &[Scored], most: usize) -> Vec<Fit> {
        let floor = WORTH.max(PROMISING * traces.first().map_or(0.0, |s| s.gain));
        let fit = |s: &Scored| {
            let mut fit = frame.fit(&s.beside(known), ITERATIONS, ENOUGH)?;
            fit.cost += lines(frame, &fit.model);
            Some(fit)
        };
        let worth = traces.par_iter().take(most).filter(|s| s.gain > floor);
        worth.filter_map(fit).collect()
    }

    /// The effect that is linear as the axles are and explains the ride better than none, by however little.
    fn doubt(&self, known: &Fit, sorted: &[Fit]) -> Option<Term> {
        let added = |fit: &Fit| fit.model.effects.last().map(|(term, _)| *term);
        let is_linear = |fit: &&Fit| added(fit).is_some_and(|term| is_linear(term.kind));
        let best = sorted.iter().find(is_linear)?;
        is_doubt(self.charged(known) - self.charged(best)).then(|| added(best))?
    }

    /// The best fit, but a law with a name where a general one is ahead by little beside what both explain.
    fn preferred(&self, known: &Fit, sorted: &[Fit]) -> Option<Fit> {
        let best = sorted.first()?;
        let is_general = |fit: &Fit| {
            fit.model
                .effects
                .iter()
                .any(|(t, _)| t.kind.spec().is_general)
        };
        let named = sorted.iter().find(|fit| !is_general(fit));
        let gained = self.charged(known) - self.charged(best);
        let behind = named.map_or(f64::INFINITY, |n| self.charged(n) - self.charged(best));
        match behind < (policy::OUTGROWS * gained).max(policy::DETECTED) {
            true => named.cloned(),
            false => Some(best.clone()),
        }
    }

    /// -2 ln L with what each parameter costs.
    pub fn charged(&self, fit: &Fit) -> f64 {
        let angles = fit.model.rolled.len().saturating_sub(1);
        let parameters = (fit.model.slots().len() + angles) as f64;
        fit.cost + parameters * 0.5 * (self.record.values() as f64).ln()
    }

    /// Candidates by their traces beside a model, the largest first.
    fn scored(&self, frame: &Frame, model: &Model) -> Vec<Scored> {
        let Some(beside) = Beside::new(frame, model) else {
            return Vec::new();
        };
        let used = model.terms();
        let is_free = |term: &&Term| {
            // What one wheel's line leaves is no line of the other.
            let same_line = |u: &Term| has_line(u.kind) && u.kind == term.kind;
            used.iter().all(|u| u != *term && !same_line(u))
        };
        let free: Vec<&Term> = self.candidates.iter().filter(is_free).collect();
        let mut scored: Vec<Scored> = free.par_iter().filter_map(|t| beside.score(**t)).collect();
        scored.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        scored
    }
}

/// Whether the resonance of every second mass, up to its half power at f (1 + zeta), is among the frequencies that are judged (up to
/// `highest`, Hz). Beyond them it bends the highest ones as contact patches do.
fn is_seen(model: &Model, highest: f64) -> bool {
    let half_power = |[_, hertz, damping, ..]: &Values| hertz * (1.0 + damping);
    (model.effects.iter())
        .filter(|(term, _)| term.kind == Kind::SprungMass)
        .all(|(_, values)| half_power(values) < highest)
}

fn is_doubt(gained: f64) -> bool {
    gained > policy::DOUBT
}

/// Gain that one more effect must make beside others, which have gained so much.
fn wanted(round: usize, first: f64) -> f64 {
    match round {
        0 => policy::DETECTED,
        _ => (2.0 * policy::DETECTED).max(policy::BESIDE_FIRST * first),
    }
}

/// A wheel out of round: sine and cosine of the first segment in units of the start, and the angle (rad) of each beside it.
struct Turned {
    sizes: DVector<f64>,
    gain: f64,
    angles: Vec<f64>,
}

/// What a model leaves, without the directions in which its own numbers move it.
struct Beside<'a> {
    frame: &'a Frame<'a>,
    model: &'a Model,
    predicted: super::predict::Spectra,
    residual: DVector<f64>,
    known: DMatrix<f64>,
}

impl<'a> Beside<'a> {
    fn new(frame: &'a Frame<'a>, model: &'a Model) -> Option<Self> {
        let predicted = frame.predictor.spectra(std::slice::from_ref(model)).pop()?;
        let (_, models, steps) = frame.varied(model);
        let others = frame.predictor.spectra(&models);
        let known = frame.directions(&predicted, &others, &steps).qr().q();
        let residual = frame.column(&frame.left(&predicted).residuals);
        Some(Self {
            frame,
            model,
            predicted,
            residual,
            known,
        })
    }

    /// Sine and cosine of a wheel whose angle is another in each segment; nothing of a single segment.
    fn turned(&self, own: &DMatrix<f64>) -> Option<Turned> {
        let segments = self.predicted.len();
        let rows = own.nrows() / segments;
        if segments == 1 {
            return None;
        }
        let (mut gain, mut found) = (0.0, Vec::new());
        for s in 0..segments {
            let part = own.rows(s * rows, rows);
            let toward = part.tr_mul(&self.residual.rows(s * rows, rows));
            let sizes = part.tr_mul(&part).cholesky()?.solve(&toward);
            gain += sizes.dot(&toward);
            found.push(sizes);
        }
        let angle = |sizes: &DVector<f64>| sizes[1].atan2(sizes[0]);
        let size = found.iter().map(DVector::norm).sum::<f64>() / segments as f64;
        let first = angle(&found[0]);
        Some(Turned {
            sizes: DVector::from_vec(vec![size * first.cos(), size * first.sin()]),
            gain,
            angles: found.iter().map(|sizes| angle(sizes) - first).collect(),
        })
    }

    /// The best of an effect's starts.
    fn score(&self, term: Term) -> Option<Scored> {
        let scale = self.frame.predictor.scales.get(axle_of(&term))?;
        let spec = term.kind.spec();
        let starts = (spec.starts)(scale);
        let each = spec.amplitudes.len().max(1);
        let groups: Vec<&[Values]> = starts.chunks(each).collect();
        let thinned = groups.len().div_ceil(MOST_STARTS / each).max(1);
        let groups: Vec<&[Values]> = groups.into_iter().step_by(thinned).collect();
        let small = |values: &Values| {
            let mut values = *values;
            for a in spec.amplitudes {
                values[*a] *= SMALL;
            }
            self.model.with(term, values)
        };
        let models: Vec<Model> = groups.iter().flat_map(|g| g.iter().map(small)).collect();
        let spectra = self.frame.predictor.spectra(&models);
        let traces = self
            .frame
            .directions(&self.predicted, &spectra, &vec![SMALL; models.len()]);
        let mut best: Option<Scored> = None;
        for (g, group) in groups.iter().enumerate() {
            let own = traces.columns(g * each, group.len()).into_owned();
            let own = &own - &self.known * self.known.tr_mul(&own);
            let normal = own.tr_mul(&own);
            if !(normal[(0, 0)] > 1e-9 && normal.iter().all(|x| x.is_finite())) {
                continue;
            }
            let error = 1.0 / normal[(0, 0)].sqrt();
            let turned = (term.kind == Kind::WheelOutOfRound).then(|| self.turned(&own));
            let fitted = match turned.flatten() {
                Some(turned) => Some((turned.sizes, turned.gain, turned.angles)),
                None => {
                    let toward = own.tr_mul(&self.residual);
                    let sizes = normal.cholesky().map(|c| c.solve(&toward));
                    sizes.map(|sizes| (sizes.clone(), sizes.dot(&toward), Vec::new()))
                }
            };
            let Some((mut sizes, mut gain, angles)) = fitted else {
                continue;
            };
            let mut values = group[0];
            for (i, a) in spec.amplitudes.iter().enumerate() {
                let [low, high] = (spec.parameters[*a].limits)(scale);
                if low >= 0.0 && sizes[i] < 0.0 {
                    (gain, sizes[i]) = (0.0, SMALL);
                }
                let start = group.iter().map(|v| v[*a]).fold(0.0, f64::max);
                values[*a] = (sizes[i] * start).clamp(low.max(-5.0 * start), high.min(5.0 * start));
            }
            let mut unit = group[0];
            if let Some(a) = spec.amplitudes.first() {
                unit[*a] *= error;
            }
            if best.as_ref().is_none_or(|b| gain > b.gain) {
                let radius = scale.wheel_radius * values[2];
                best = Some(Scored {
                    term,
                    values,
                    gain,
                    unit,
                    rolled: angles.iter().map(|angle| radius * angle).collect(),
                });
            }
        }
        best
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use veloid_model::law::padded;

    #[test]
    fn a_second_mass_beyond_the_band_is_not_seen() {
        let term = Term {
            kind: Kind::SprungMass,
            place: veloid_report::diagnosis::Place::Rear,
        };
        let at = |hertz| Model::new([8.0, 3.0], [7.0, 2.0]).with(term, padded([0.2, hertz, 0.1]));
        assert!(is_seen(&at(30.0), 35.0) && !is_seen(&at(32.0), 35.0));
    }

    #[test]
    fn what_gains_little_is_a_doubt() {
        assert!(is_doubt(1.01 * policy::DOUBT) && !is_doubt(0.99 * policy::DOUBT));
    }

    #[test]
    fn a_second_effect_must_gain_twice_as_much_and_a_part_of_the_first() {
        assert_eq!(wanted(0, 0.0), policy::DETECTED);
        assert_eq!(wanted(1, policy::DETECTED), 2.0 * policy::DETECTED);
        assert_eq!(wanted(1, 1e4), 1e4 * policy::BESIDE_FIRST);
    }
}
