//! Naming what is left out: forward selection with an exact refit of every candidate, a backward
//! pass, and an exchange pass that also gives the rivals.

use std::ops::Range;

use rayon::prelude::*;

use crate::EngineError;
use crate::bicycle::Axle;
use crate::identify::Progress;
use crate::output_error::colour::Colour;

use super::coherence;
use super::extend::{Model, Reach, is_far, polish, reduce};
use super::fit::{Effort, Fitted, Fitter};
use super::model::Term;
use super::null::Null;
use super::physical::is_physical;
use super::refit::LEADERS;
use super::replicate::{is_noisy, stands_out};
use super::signature::Signatures;

/// Share of its gain (for each sample) that an effect must repeat on the held-out part.
const HELD: f64 = 0.3;
/// Gain for each sample that a second effect must make.
const BESIDE: f64 = 0.02;
/// Share of the held-out squares that it must remove instead; where the road is noisy, in any case.
const SHOWN: f64 = 0.08;
/// Share of the explainable held-out variance beyond which an extension is adequate anyway.
pub const ADEQUATE: f64 = 0.98;
/// Share of the held-out squares that tells of a slow effect, which noise of a slow colour explains as well.
const SLOWLY: f64 = 0.8;
/// Times the gain that chance could bring that an effect must make which the held-out part cannot
/// confirm, since it belongs to a moment of the fitted part.
const UNCONFIRMED: f64 = 2.0;
/// Largest angle (rad) that the stiffest axle turns through in one step of the integrator, while
/// searching and in the end.
pub const COARSE: f64 = 0.45;
pub const FINE: f64 = 0.3;
/// Candidates that are behind the best by no more than this in log likelihood are chosen by merit.
const CLOSE: f64 = 8.0;
/// Effects that may act at once.
const MOST_TERMS: usize = 3;

/// What one round of the forward selection saw.
#[derive(Clone, Debug)]
pub struct Round {
    pub term: Term,
    /// Family-wise p value of its gain in log likelihood.
    pub p_value: f64,
    pub accepted: bool,
}

/// Result of the search.
pub struct Named {
    pub model: Model,
    pub rounds: Vec<Round>,
    /// Other models of the same or smaller size, best first.
    pub rivals: Vec<Model>,
}

pub struct Search<'a> {
    pub fitter: Fitter<'a>,
    pub plain: Model,
    pub held: Range<usize>,
    pub candidates: Vec<Term>,
    pub alpha: f64,
    pub seed: u64,
    pub progress: &'a dyn Progress,
}

impl Search<'_> {
    pub fn quick(&self, model: &Model) -> Effort {
        let angle = if model.terms.is_empty() { COARSE } else { FINE };
        Effort {
            iterations: 8,
            gain: 0.1,
            substeps: model.substeps(self.fitter.scene, angle),
        }
    }

    pub fn thorough(&self, model: &Model) -> Effort {
        Effort {
            iterations: 20,
            gain: 0.01,
            substeps: model.substeps(self.fitter.scene, FINE),
        }
    }

    /// Residuals up to the end of the held-out part, by track and with the noise that the model gives it.
    fn residuals<'m>(&self, model: &'m Model) -> Vec<(usize, Vec<f64>, &'m Colour)> {
        let substeps = model.substeps(self.fitter.scene, FINE);
        let of_fit = |fit: &'m Fitted| {
            let end = self.held.end;
            let residuals = self
                .fitter
                .residuals_to(&fit.unit, &fit.point, substeps, end);
            let tracks = fit.unit.tracks.iter().copied();
            tracks
                .zip(residuals)
                .zip(&fit.colours)
                .map(|((t, r), c)| (t, r, c))
        };
        model.fits.iter().flat_map(of_fit).collect()
    }

    /// Log score of the held-out part under the model's own noise.
    pub fn held_score(&self, model: &Model) -> f64 {
        let scene = self.fitter.scene;
        let mut total = 0.0;
        for (t, r, colour) in self.residuals(model) {
            let white = colour.whiten(&r);
            for i in self.held.clone().filter(|i| scene.tracks[t].valid[*i]) {
                total -= 0.5 * (white[i] * white[i] / colour.variance + colour.variance.ln());
            }
        }
        if total.is_finite() {
            total
        } else {
            f64::NEG_INFINITY
        }
    }

    /// Sum of squares of the held-out residual, by track.
    fn held_squares(&self, model: &Model) -> Vec<f64> {
        let mut squares = vec![0.0; self.fitter.scene.tracks.len()];
        for (t, r, _) in self.residuals(model) {
            squares[t] = r[self.held.clone()].iter().map(|x| x * x).sum();
        }
        squares
    }

    /// Share of the plain model's held-out squares that a model leaves on an axle.
    pub fn left(&self, axle: Axle, model: &Model) -> f64 {
        let tracks = self.fitter.scene.tracks.iter();
        let on_axle = |squares: Vec<f64>| -> f64 {
            let own = tracks.clone().zip(squares).filter(|(t, _)| t.axle == axle);
            own.map(|(_, square)| square).sum()
        };
        on_axle(self.held_squares(model)) / on_axle(self.held_squares(&self.plain))
    }

    /// Whether what `larger` has beyond `model` is large enough to be told beside other effects: in
    /// likelihood, or in the held-out error, where a slow effect shows that coloured noise would hide.
    fn counts(&self, model: &Model, larger: &Model) -> bool {
        larger.likelihood - model.likelihood > BESIDE * self.fitter.samples as f64
            || self.shows(model, larger)
    }

    /// Log likelihood less what the number of parameters costs (Schwarz's criterion), and less again for
    /// what no bicycle can be.
    pub fn merit(&self, model: &Model) -> f64 {
        let count = |t: &Term| t.kind.spec().parameters.len() as f64;
        let parameters: f64 = model.terms.iter().map(count).sum();
        let cost = 0.5 * parameters * (self.fitter.samples as f64).ln();
        let odd = !is_physical(self.fitter.scene, &self.plain, model);
        model.likelihood - cost - if odd { CLOSE } else { 0.0 }
    }

    /// All rounds from the plain model on.
    pub fn run(&self) -> Result<Named, EngineError> {
        let mut model = self.plain.clone();
        let mut rounds = Vec::new();
        let mut rivals: Vec<Model> = Vec::new();
        // Effects that came near to the best of some round.
        let mut near: Vec<Term> = Vec::new();
        // The last model whose every effect proved itself on the held-out part.
        let mut proven = self.plain.clone();
        // The model with the noise under which promises are looked for, where that is not its own.
        let mut pale: Option<Model> = None;
        while model.terms.len() < MOST_TERMS {
            self.check()?;
            let goes_on = 'round: {
                let offers = self.offers(pale.as_ref().unwrap_or(&model), &model.terms);
                let null = Null::new(&offers, self.seed, rounds.len());
                if !self.promising(&model, &offers, &null) {
                    break 'round false;
                }
                let found = self.refits(&model, &offers, Reach::Far);
                // What noise of the road channel brings leads to nothing.
                let real = |m: &&Model| self.beats_road_noise(&model, m);
                let Some(best) = found.iter().take(LEADERS).find(real) else {
                    break 'round false;
                };
                let least = 0.5 * (best.likelihood - model.likelihood);
                let leaders: Vec<&Model> = found
                    .iter()
                    .take(LEADERS)
                    .filter(|m| m.likelihood <= best.likelihood)
                    .filter(|m| m.likelihood - model.likelihood >= least)
                    .collect();
                near.extend(leaders.iter().map(|m| added(&model, m)));
                // Of those that explain the ride as well, the one that a bicycle can be and that says least.
                let mut accepted: Vec<&Model> = Vec::new();
                for leader in leaders {
                    if accepted
                        .first()
                        .is_some_and(|first| leader.likelihood < first.likelihood - CLOSE)
                    {
                        break;
                    }
                    if self.accepts(&proven, &model, leader, &null)
                        && (std::ptr::eq(leader, best) || real(&leader))
                    {
                        accepted.push(leader);
                    }
                }
                let choice = accepted
                    .into_iter()
                    .max_by(|a, b| self.merit(a).total_cmp(&self.merit(b)));
                let tell = |m: &Model, accepted: bool| Round {
                    term: added(&model, m),
                    p_value: null.p_value(m.likelihood - model.likelihood),
                    accepted,
                };
                if let Some(choice) = choice {
                    rounds.push(tell(choice, true));
                    model = self.pruned(
                        polish(&self.fitter, choice, self.thorough(choice))
                            .unwrap_or_else(|| choice.clone()),
                    );
                    rivals = if model.terms.len() == 1 {
                        found
                    } else {
                        let tried = self.exchanged(&mut model, &near)?;
                        model = self.pruned(model);
                        tried
                    };
                    proven = model.clone();
                    true
                } else {
                    rounds.push(tell(best, false));
                    // Far from the ride one effect alone may mislead where two together explain it.
                    let far = best
                        .fits
                        .iter()
                        .any(|f| is_far(self.fitter.scene, best, &f.unit));
                    if !far || model.terms.len() > proven.terms.len() {
                        break 'round false;
                    }
                    model = best.clone();
                    true
                }
            };
            pale = match (goes_on, pale) {
                (true, _) => None,
                (false, None) => self.paled(&model),
                (false, Some(_)) => break,
            };
            if !goes_on && pale.is_none() {
                break;
            }
        }
        let model = proven;
        for round in &mut rounds {
            round.accepted &= model.terms.contains(&round.term);
        }
        rivals.retain(|m| m.terms.len() <= model.terms.len() && m.terms != model.terms);
        rivals.sort_by(|a, b| b.likelihood.total_cmp(&a.likelihood));
        rivals.dedup_by(|a, b| a.terms == b.terms);
        Ok(Named {
            model,
            rounds,
            rivals,
        })
    }

    /// The model with white noise on the axles whose residual goes with what drives them, if any does: a model
    /// of the noise that has taken a mode for noise hides what would explain it.
    fn paled(&self, model: &Model) -> Option<Model> {
        let scene = self.fitter.scene;
        let driven: Vec<usize> = (self.residuals(model).into_iter())
            .filter(|(t, residual, _)| {
                coherence::of_track(&scene.tracks[*t], residual).score > coherence::DRIVEN
            })
            .map(|(t, ..)| t)
            .collect();
        let mut pale = model.clone();
        for fit in &mut pale.fits {
            let axles = fit.unit.tracks.iter().zip(&mut fit.colours);
            for (_, colour) in axles.filter(|(t, _)| driven.contains(t)) {
                *colour = Colour::white(colour.total_variance());
            }
        }
        (!driven.is_empty()).then_some(pale)
    }

    /// Whether the effect that `larger` has beyond `model` is real where the road is quiet: its gain
    /// beyond the family-wise null, large enough to be told beside others, and repeated on the held-out
    /// part since the last `proven` model.
    fn accepts(&self, proven: &Model, model: &Model, larger: &Model, null: &Null) -> bool {
        let gain = larger.likelihood - model.likelihood;
        let term = added(model, larger);
        let local = term.kind.spec().local;
        let slow = term.kind.spec().slow;
        let share = self.held.len() as f64 / self.fitter.samples as f64;
        let wanted = if local {
            -2.0 - 0.05 * gain * share
        } else if slow {
            2.0
        } else {
            2.0 + HELD * (larger.likelihood - proven.likelihood) * share
        };
        let beyond_chance = null.p_value(gain) <= self.alpha
            && (!local || gain > UNCONFIRMED * null.bound(self.alpha));
        let counts = model.terms.is_empty() && !slow || self.counts(model, larger);
        let repeats = self.held_score(larger) - self.held_score(proven) > wanted;
        let told = if slow { SLOWLY } else { ADEQUATE };
        beyond_chance && counts && (repeats || self.removes(proven, larger, told))
    }

    /// Whether a term acts on an axle whose road has noise.
    pub fn has_noisy_road(&self, term: Term) -> bool {
        let mut tracks = self.fitter.scene.tracks.iter();
        tracks.any(|t| term.acts_on(t.axle) && is_noisy(t))
    }

    /// Whether what `larger` has beyond `model` is more than noise of the road channel can bring, and
    /// shows in the held-out error.
    fn beats_road_noise(&self, model: &Model, larger: &Model) -> bool {
        let term = added(model, larger);
        !self.has_noisy_road(term)
            || self.shows(model, larger)
                && (term.kind.spec().slow || stands_out(&self.fitter, model, term, self.seed))
    }

    /// Whether the held-out squares of some track show what `larger` has beyond `model`.
    pub fn shows(&self, model: &Model, larger: &Model) -> bool {
        self.removes(model, larger, SHOWN)
    }

    /// Whether `larger` removes that share of the held-out squares of some track.
    fn removes(&self, model: &Model, larger: &Model, share: f64) -> bool {
        let (before, after) = (self.held_squares(model), self.held_squares(larger));
        let mut pairs = before.iter().zip(after);
        pairs.any(|(before, after)| after < (1.0 - share) * before)
    }

    fn check(&self) -> Result<(), EngineError> {
        if self.progress.cancelled() {
            Err(EngineError::Cancelled)
        } else {
            Ok(())
        }
    }

    /// Standard deviations that a score must reach to be significant among all offers.
    pub fn score_bound(&self, offers: &[Signatures]) -> f64 {
        (2.0 * Null::new(offers, self.seed, MOST_TERMS + 1).bound(self.alpha)).sqrt()
    }

    /// Drops terms that the others have made superfluous.
    fn pruned(&self, mut model: Model) -> Model {
        while model.terms.len() > 1 {
            let weakest = self
                .without_each(&model)
                .into_iter()
                .max_by(|a, b| a.likelihood.total_cmp(&b.likelihood));
            match weakest {
                Some(less) if !self.counts(&less, &model) => model = less,
                _ => break,
            }
        }
        model
    }

    pub fn without_each(&self, model: &Model) -> Vec<Model> {
        model
            .terms
            .par_iter()
            .filter_map(|t| {
                let terms: Vec<Term> = model.terms.iter().copied().filter(|x| x != t).collect();
                reduce(&self.fitter, model, &terms, self.thorough(model))
            })
            .collect()
    }

    /// Tries others in the place of each of the model's effects, those that promise something and those
    /// that came `near` before; takes improvements, and gives the models that were tried.
    fn exchanged(&self, model: &mut Model, near: &[Term]) -> Result<Vec<Model>, EngineError> {
        let mut tried = Vec::new();
        if model.terms.len() < 2 {
            return Ok(tried);
        }
        for less in self.without_each(model) {
            self.check()?;
            let dropped = *model
                .terms
                .iter()
                .find(|t| !less.terms.contains(t))
                .unwrap_or(&model.terms[0]);
            let mut taken = less.terms.clone();
            taken.push(dropped);
            let offers = self.offers(&less, &taken);
            let loss = model.likelihood - less.likelihood;
            let offers: Vec<Signatures> = offers
                .into_iter()
                .filter(|o| near.contains(&o.term) || o.promise() > 0.2 * loss)
                .collect();
            tried.extend(self.refits(&less, &offers, Reach::Near));
        }
        if let Some(best) = tried
            .iter()
            .max_by(|a, b| self.merit(a).total_cmp(&self.merit(b)))
            && self.merit(best) > self.merit(model) + 1.0
        {
            let better = best.clone();
            tried.push(std::mem::replace(model, better));
        }
        tried.retain(|m| m.terms != model.terms);
        Ok(tried)
    }
}

/// The term that `larger` has and `model` has not.
pub fn added(model: &Model, larger: &Model) -> Term {
    let new = larger.terms.iter().find(|t| !model.terms.contains(t));
    *new.unwrap_or(&larger.terms[0])
}
