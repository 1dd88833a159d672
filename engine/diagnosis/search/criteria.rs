//! What the search judges models by: likelihood, held-out score, cost of parameters.

use std::ops::Range;

use rayon::prelude::*;

use crate::policy;
use crate::residual::replicate::is_noisy;
use veloid_core::EngineError;
use veloid_core::Progress;
use veloid_core::bicycle::Axle;
use veloid_core::numerics::autoregressive::NoiseModel;
use veloid_model::dataset::Budget;
use veloid_model::fit::physical::is_physical;
use veloid_model::fit::polish::reduce;
use veloid_model::fit::{COARSE, Effort, FINE, Fitted, Fitter, Model, Term};

pub struct Search<'a> {
    pub fitter: Fitter<'a>,
    pub plain: Model,
    pub held: Range<usize>,
    pub candidates: Vec<Term>,
    pub alpha: f64,
    pub seed: u64,
    /// Counted work at which the search ends with what it has.
    pub until: u64,
    /// Of the whole diagnosis.
    pub budget: Budget,
    pub progress: &'a dyn Progress,
}

impl Search<'_> {
    pub fn quick(&self, model: &Model) -> Effort {
        let angle = if model.terms.is_empty() { COARSE } else { FINE };
        Effort {
            iterations: 8,
            gain: 0.1,
            substeps: model.substeps(self.fitter.dataset, angle),
        }
    }

    pub fn thorough(&self, model: &Model) -> Effort {
        Effort {
            iterations: 20,
            gain: 0.01,
            substeps: model.substeps(self.fitter.dataset, FINE),
        }
    }

    /// Residuals up to the end of the held-out part, by track and with the noise that the model gives it.
    pub fn residuals<'m>(&self, model: &'m Model) -> Vec<(usize, Vec<f64>, &'m NoiseModel)> {
        let substeps = model.substeps(self.fitter.dataset, FINE);
        let of_fit = |fit: &'m Fitted| {
            let end = self.held.end;
            let residuals = self
                .fitter
                .residuals_to(&fit.unit, &fit.point, substeps, end);
            let tracks = fit.unit.tracks.iter().copied();
            tracks
                .zip(residuals)
                .zip(&fit.noise_models)
                .map(|((t, r), c)| (t, r, c))
        };
        model.fits.par_iter().flat_map_iter(of_fit).collect()
    }

    /// Log score of the held-out part under the model's own noise.
    pub fn held_score(&self, model: &Model) -> f64 {
        let dataset = self.fitter.dataset;
        let mut total = 0.0;
        for (t, r, noise_model) in self.residuals(model) {
            let white = noise_model.whiten(&r);
            for i in self.held.clone().filter(|i| dataset.tracks[t].valid[*i]) {
                total -=
                    0.5 * (white[i] * white[i] / noise_model.variance + noise_model.variance.ln());
            }
        }
        if total.is_finite() {
            total
        } else {
            f64::NEG_INFINITY
        }
    }

    /// Sum of squares of the held-out residual, by track.
    pub fn held_squares(&self, model: &Model) -> Vec<f64> {
        self.squares(model, &self.held)
    }

    /// Sum of squares of the residual of a part, by track.
    fn squares(&self, model: &Model, part: &Range<usize>) -> Vec<f64> {
        let mut squares = vec![0.0; self.fitter.dataset.tracks.len()];
        for (t, r, _) in self.residuals(model) {
            squares[t] = r[part.clone()].iter().map(|x| x * x).sum();
        }
        squares
    }

    /// Share of the plain model's held-out squares that a model leaves on an axle.
    pub fn left(&self, axle: Axle, model: &Model) -> f64 {
        let tracks = self.fitter.dataset.tracks.iter();
        let on_axle = |squares: Vec<f64>| -> f64 {
            let own = tracks.clone().zip(squares).filter(|(t, _)| t.axle == axle);
            own.map(|(_, square)| square).sum()
        };
        on_axle(self.held_squares(model)) / on_axle(self.held_squares(&self.plain))
    }

    /// Whether what `larger` has beyond `model` is large enough to be reported beside other effects: in
    /// likelihood, or in the held-out error, where a slow effect shows that coloured noise would hide.
    pub fn counts(&self, model: &Model, larger: &Model) -> bool {
        let gain = larger.likelihood - model.likelihood;
        let held = [model, larger].map(|m| self.held_squares(m));
        (gains_enough(gain, self.fitter.samples) || shows(&held[0], &held[1]))
            && !self.is_trifle([model, larger], held)
    }

    /// Whether the squares that one more effect removes may be the error of the laws beside it: those `held` out without and with it,
    /// or fitted ones where it belongs to a moment of these.
    fn is_trifle(&self, [model, larger]: [&Model; 2], held: [Vec<f64>; 2]) -> bool {
        let term = added(model, larger);
        let fitted = 0..self.fitter.samples;
        let [plain, before, after] = match term.kind.spec().local {
            true => [&self.plain, model, larger].map(|m| self.squares(m, &fitted)),
            false => {
                let [before, after] = held;
                [self.held_squares(&self.plain), before, after]
            }
        };
        let trifle = |t: usize| removes_a_trifle([plain[t], before[t], after[t]]);
        let mut tracks = self.fitter.dataset.tracks.iter().enumerate();
        tracks.all(|(t, track)| !term.acts_on(track.axle) || trifle(t))
    }

    /// Log likelihood less what the number of parameters costs (Schwarz's criterion), and less again for
    /// what no bicycle can be.
    pub fn merit(&self, model: &Model) -> f64 {
        let cost = cost(&model.terms, self.fitter.samples);
        let odd = !is_physical(self.fitter.dataset, &self.plain, model);
        model.likelihood - cost - if odd { policy::CLOSE } else { 0.0 }
    }

    /// Whether a term acts on an axle whose road has noise.
    pub fn has_noisy_road(&self, term: Term) -> bool {
        let mut tracks = self.fitter.dataset.tracks.iter();
        tracks.any(|t| term.acts_on(t.axle) && is_noisy(t))
    }

    /// Whether the held-out squares of some track show what `larger` has beyond `model`.
    pub fn shows(&self, model: &Model, larger: &Model) -> bool {
        shows(&self.held_squares(model), &self.held_squares(larger))
    }

    /// Whether `larger` removes that share of the held-out squares of some track.
    pub fn removes(&self, model: &Model, larger: &Model, share: f64) -> bool {
        any_removed(&self.held_squares(model), &self.held_squares(larger), share)
    }

    pub fn check(&self) -> Result<(), EngineError> {
        if self.progress.cancelled() {
            Err(EngineError::Cancelled)
        } else {
            Ok(())
        }
    }

    pub fn report_progress(&self) {
        let done = self.fitter.dataset.work.done();
        self.progress.searched(done, self.budget.steps);
    }

    /// Whether the budget is spent. To be asked while nothing else computes: then the answer is the same on every machine.
    pub fn is_spent(&self) -> bool {
        self.fitter.dataset.work.done() > self.until
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
}

/// Log likelihood that the parameters of effects cost on so many samples (Schwarz's criterion).
pub fn cost(terms: &[Term], samples: usize) -> f64 {
    let count = |t: &Term| t.kind.spec().parameters.len() as f64;
    let parameters: f64 = terms.iter().map(count).sum();
    0.5 * parameters * (samples as f64).ln()
}

/// Whether a second effect's gain (nats) on so many samples is large enough.
fn gains_enough(gain: f64, samples: usize) -> bool {
    gain > policy::SECOND_GAINS * samples as f64
}

/// Whether the squares of some track show a second effect.
fn shows(before: &[f64], after: &[f64]) -> bool {
    any_removed(before, after, policy::SECOND_REMOVES)
}

/// Whether one more effect removes no more than the error of the laws beside it. Squares of the plain model, and before and after it.
fn removes_a_trifle([plain, before, after]: [f64; 3]) -> bool {
    before - after < policy::TRIFLE * (plain - before)
}

/// Whether a model leaves so small a share of the plain model's squares that it explains an axle.
pub fn explains_nearly_all(left: f64) -> bool {
    left <= 1.0 - policy::ADEQUATE
}

/// Whether one more effect may be looked for beside these.
pub fn has_room(terms: &[Term]) -> bool {
    terms.len() < policy::MOST_TERMS
}

/// Held-out log score (nats) by which an effect must win that gained so much on the fitted part, of which the held-out part is a `share`.
pub fn to_repeat(gain: f64, share: f64) -> f64 {
    2.0 + policy::HELD * gain * share
}

/// Whether that share of the squares of some track is gone.
pub fn any_removed(before: &[f64], after: &[f64], share: f64) -> bool {
    let mut pairs = before.iter().zip(after);
    pairs.any(|(before, after)| *after < (1.0 - share) * before)
}

/// The term that `larger` has and `model` has not.
pub fn added(model: &Model, larger: &Model) -> Term {
    let new = larger.terms.iter().find(|t| !model.terms.contains(t));
    *new.unwrap_or(&larger.terms[0])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::example;
    use veloid_model::effects::Kind;

    #[test]
    fn a_second_effect_gains_for_each_sample_or_removes_a_share_on_some_track() {
        let bound = policy::SECOND_GAINS * 500.0;
        assert!(gains_enough(1.01 * bound, 500) && !gains_enough(0.99 * bound, 500));
        assert!(!gains_enough(1.01 * bound, 510));
        let left = |share: f64| shows(&[2.0, 3.0], &[2.0, 3.0 * (1.0 - share)]);
        assert!(left(1.01 * policy::SECOND_REMOVES) && !left(0.99 * policy::SECOND_REMOVES));
    }

    #[test]
    fn what_laws_are_wrong_by_is_no_second_effect() {
        // Of 50 squares the first effects leave 10, and what is a trifle is measured by the 40 that they took.
        let trifle = |share: f64| removes_a_trifle([50.0, 10.0, 10.0 - share * 40.0]);
        assert!(trifle(0.99 * policy::TRIFLE) && !trifle(1.01 * policy::TRIFLE));
    }

    #[test]
    fn what_is_left_of_an_adequate_model_is_next_to_nothing() {
        let rest = 1.0 - policy::ADEQUATE;
        assert!(explains_nearly_all(0.99 * rest) && !explains_nearly_all(1.01 * rest));
    }

    #[test]
    fn effects_are_added_up_to_the_most() {
        let term = example::term(Kind::CubicStiffness, Axle::Front);
        assert!(has_room(&[term; policy::MOST_TERMS - 1]));
        assert!(!has_room(&[term; policy::MOST_TERMS]));
    }

    #[test]
    fn a_gain_repeats_on_a_part_as_long_as_its_share() {
        assert_eq!(to_repeat(0.0, 0.25), to_repeat(100.0, 0.0));
        let wanted = to_repeat(100.0, 0.25) - to_repeat(0.0, 0.25);
        assert!((wanted - 25.0 * policy::HELD).abs() < 1e-12, "{wanted}");
    }

    #[test]
    fn what_no_bicycle_can_be_has_less_merit_by_what_counts_as_close() {
        let dataset = example::dataset();
        let search = example::search(&dataset);
        let friction = example::term(Kind::CoulombFriction, Axle::Front);
        let merit = |force: f64| search.merit(&example::model(&dataset, &[(friction, force)]));
        let lost = merit(1.0) - merit(-1.0);
        assert!((lost - policy::CLOSE).abs() < 1e-9, "{lost}");
        // Dry friction has a force and a width, each for half the logarithm of the number of samples.
        let samples = search.fitter.samples as f64;
        assert!((merit(1.0) + samples.ln()).abs() < 1e-9);
    }

    #[test]
    fn an_axle_without_effects_keeps_all_that_the_plain_model_leaves() {
        let dataset = example::dataset();
        let search = example::search(&dataset);
        let cubic = example::term(Kind::CubicStiffness, Axle::Rear);
        let model = example::model(&dataset, &[(cubic, 1e9)]);
        assert!((search.left(Axle::Front, &model) - 1.0).abs() < 1e-9);
        assert!(search.left(Axle::Rear, &model) > 2.0);
    }

    #[test]
    fn the_added_term_is_the_one_that_is_new() {
        let dataset = example::dataset();
        let [a, b] = [Kind::CubicStiffness, Kind::SensorGain]
            .map(|kind| (example::term(kind, Axle::Front), 0.0));
        let one = example::model(&dataset, &[b]);
        assert_eq!(added(&one, &example::model(&dataset, &[a, b])), a.0);
    }
}
