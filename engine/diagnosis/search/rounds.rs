//! Naming what is left out: forward selection with an exact refit of every candidate, a backward
//! pass, and an exchange pass that also gives the rivals.

use rayon::prelude::*;

use super::attempt::Attempt;
use super::criteria::{Search, added, has_room, to_repeat};
use super::extend::{Reach, is_far};
use super::null::Null;
use super::offered::Offered;
use super::refit::{HOPE, LEADERS, SOME};
use super::score_test::{Signatures, stands_out};
use tracing::debug;

use crate::policy;
use crate::residual::coherence;
use veloid_core::EngineError;
use veloid_model::fit::polish::polish;
use veloid_model::fit::{Model, Term};
use veloid_report::diagnosis::Place;

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
    /// What the last round saw, and led nowhere.
    pub offered: Option<Offered>,
    pub attempts: Vec<Attempt>,
}

/// Where the rounds have come to.
struct SearchState {
    model: Model,
    /// The last model whose every effect proved itself on the held-out part.
    proven: Model,
    rounds: Vec<Round>,
    rivals: Vec<Model>,
    /// Effects that came near to the best of some round.
    near: Vec<Term>,
    /// What the last round saw that led nowhere.
    offered: Option<Offered>,
    attempts: Vec<Attempt>,
}

impl Search<'_> {
    /// All rounds from the plain model on.
    pub fn run(&self) -> Result<Named, EngineError> {
        let mut state = SearchState {
            model: self.plain.clone(),
            proven: self.plain.clone(),
            rounds: Vec::new(),
            rivals: Vec::new(),
            near: Vec::new(),
            offered: None,
            attempts: Vec::new(),
        };
        // The model with the noise under which effects are looked for, where that is not its own.
        let mut prewhitened: Option<Model> = None;
        while has_room(&state.model.terms) && !self.is_spent() {
            self.check()?;
            self.report_progress();
            let goes_on = self.round(&mut state, prewhitened.as_ref())?;
            prewhitened = match (goes_on, prewhitened) {
                (true, _) => None,
                (false, None) => self.prewhitening(&state.model),
                (false, Some(_)) => break,
            };
            if !goes_on && prewhitened.is_none() {
                break;
            }
        }
        Ok(state.named())
    }

    /// One round; whether it led to another model.
    fn round(
        &self,
        state: &mut SearchState,
        prewhitened: Option<&Model>,
    ) -> Result<bool, EngineError> {
        let along = prewhitened.unwrap_or(&state.model);
        let (offered, null) = Offered::with_null(self, &state.model, along, state.rounds.len());
        let goes_on = self.followed(state, &offered.offers, &null)?;
        if !goes_on && prewhitened.is_none() {
            state.offered = Some(offered.kept());
        }
        Ok(goes_on)
    }

    /// Follows what is offered; whether it led to another model.
    fn followed(
        &self,
        state: &mut SearchState,
        offers: &[Signatures],
        null: &Null,
    ) -> Result<bool, EngineError> {
        let model = &state.model;
        if !self.promising(model, offers, null) {
            return Ok(false);
        }
        // Far from the ride a linear prediction says little.
        let least = match self.is_far_anywhere(model) {
            true => SOME,
            false => SOME.max(HOPE * null.bound(self.alpha)),
        };
        let found = self.refits(model, offers, Reach::Far, least);
        let bound = null.bound(self.alpha);
        (state.attempts).extend(Attempt::of_round(&found, |m| {
            let gain = m.likelihood - model.likelihood;
            Some([gain - self.unresolved(added(model, m).place), bound])
        }));
        // What noise of the road channel brings leads to nothing.
        let real = |m: &&Model| self.beats_road_noise(model, m);
        let Some(best) = found.iter().take(LEADERS).find(real) else {
            return Ok(false);
        };
        let leaders = leaders(model, best, &found);
        state.near.extend(leaders.iter().map(|m| added(model, m)));
        let seen = |m: &Model, accepted: bool| {
            let term = added(model, m);
            let gain = m.likelihood - model.likelihood - self.unresolved(term.place);
            let p_value = null.p_value(gain);
            debug!(?term, gain, p_value, accepted, "round");
            Round {
                term,
                p_value,
                accepted,
            }
        };
        if let Some(choice) = self.choice(state, leaders, best, null) {
            state.rounds.push(seen(choice, true));
            let polished = polish(&self.fitter, choice, self.thorough(choice));
            let extended = self.pruned(polished.unwrap_or_else(|| choice.clone()));
            self.settle(state, extended, found)?;
            return Ok(true);
        }
        state.rounds.push(seen(best, false));
        // Far from the ride one effect alone may mislead where two together explain it.
        let far = best
            .fits
            .iter()
            .any(|f| is_far(self.fitter.dataset, best, &f.unit));
        if !far || model.terms.len() > state.proven.terms.len() {
            return Ok(false);
        }
        state.model = best.clone();
        Ok(true)
    }

    /// Of the leaders that explain the ride as well as the first accepted, the one that a bicycle can be and that says
    /// least.
    fn choice<'m>(
        &self,
        state: &SearchState,
        leaders: Vec<&'m Model>,
        best: &Model,
        null: &Null,
    ) -> Option<&'m Model> {
        let model = &state.model;
        let mut accepted: Vec<&Model> = Vec::new();
        for leader in leaders {
            if accepted
                .first()
                .is_some_and(|first| is_behind(leader.likelihood, first.likelihood))
            {
                break;
            }
            if self.accepts(&state.proven, model, leader, null)
                && (std::ptr::eq(leader, best) || self.beats_road_noise(model, leader))
            {
                accepted.push(leader);
            }
        }
        accepted
            .into_iter()
            .max_by(|a, b| self.merit(a).total_cmp(&self.merit(b)))
    }

    /// Goes on from an extended model that was chosen among those `found`, once other effects were tried in the place of
    /// each of its own.
    fn settle(
        &self,
        state: &mut SearchState,
        mut extended: Model,
        found: Vec<Model>,
    ) -> Result<(), EngineError> {
        state.rivals = if extended.terms.len() == 1 {
            found
        } else {
            let tried = self.exchanged(&mut extended, &state.near)?;
            extended = self.pruned(extended);
            (state.attempts).extend(Attempt::of_round(&tried, |_| None));
            tried
        };
        state.proven = extended.clone();
        state.model = extended;
        Ok(())
    }

    /// The model with white noise on the axles whose residual goes with what drives them, if any does: a model
    /// of the noise that has taken a mode for noise hides what would explain it.
    fn prewhitening(&self, model: &Model) -> Option<Model> {
        let dataset = self.fitter.dataset;
        let driven: Vec<usize> = (self.residuals(model).into_par_iter())
            .filter(|(t, residual, _)| {
                coherence::of_track(&dataset.tracks[*t], residual).is_no_noise()
            })
            .map(|(t, ..)| t)
            .collect();
        let mut prewhitened = model.clone();
        for fit in &mut prewhitened.fits {
            let axles = fit.unit.tracks.iter().zip(&mut fit.noise_models);
            for (_, noise_model) in axles.filter(|(t, _)| driven.contains(t)) {
                *noise_model = noise_model.bleached();
            }
        }
        (!driven.is_empty()).then_some(prewhitened)
    }

    /// Whether the effect that `larger` has beyond `model` is real where the road is quiet: its gain
    /// beyond the family-wise null, large enough to be reported beside others, and repeated on the held-out
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
            to_repeat(larger.likelihood - proven.likelihood, share)
        };
        let beyond_chance = null.p_value(gain - self.unresolved(term.place)) <= self.alpha
            && self.outweighs_chance([model, larger], gain, || null.bound(self.alpha));
        let counts = model.terms.is_empty() && !slow || self.counts(model, larger);
        let repeats = self.held_score(larger) - self.held_score(proven) > wanted;
        beyond_chance && counts && (repeats || self.removes(proven, larger, instead(slow)))
    }

    /// Gain in log likelihood that what lies between the samples may bring to an effect at a place.
    pub fn unresolved(&self, place: Place) -> f64 {
        let tracks = self.fitter.dataset.tracks.iter();
        let own = tracks.filter(|track| place.acts_on(track.axle));
        own.map(|track| track.unresolved).sum()
    }

    /// Whether what `larger` has beyond `model` is more than noise of the road channel can bring, and
    /// shows in the held-out error.
    fn beats_road_noise(&self, model: &Model, larger: &Model) -> bool {
        let term = added(model, larger);
        !self.has_noisy_road(term)
            || self.shows(model, larger)
                && (term.kind.spec().slow || stands_out(&[(&self.fitter, model)], term, self.seed))
    }

    /// Whether an effect that took another one's place would have been accepted by itself beside the rest, among these `offers`.
    pub fn stands(&self, less: &Model, model: &Model, offers: &[Signatures]) -> bool {
        let term = added(less, model);
        let by_chance = || Null::new(offers, self.seed, policy::MOST_TERMS + 2).bound(self.alpha);
        let gain = model.likelihood - less.likelihood - self.unresolved(term.place);
        self.beats_road_noise(less, model) && self.outweighs_chance([less, model], gain, by_chance)
    }

    /// Whether a gain is clearly more than what chance makes (nats), where the effect that `larger` has beyond `model` belongs to a moment,
    /// which the held-out part cannot confirm.
    fn outweighs_chance(
        &self,
        [model, larger]: [&Model; 2],
        gain: f64,
        by_chance: impl FnOnce() -> f64,
    ) -> bool {
        !added(model, larger).kind.spec().local
            || outweighs(gain, by_chance(), self.unevenness(model, larger))
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

    /// Tries others in the place of each of the model's effects, those that predict something and those
    /// that came `near` before; takes improvements that chance does not make, and gives the models that were tried.
    fn exchanged(&self, model: &mut Model, near: &[Term]) -> Result<Vec<Model>, EngineError> {
        let (mut tried, mut better) = (Vec::new(), Vec::new());
        if model.terms.len() < 2 {
            return Ok(tried);
        }
        for less in self.without_each(model) {
            self.check()?;
            if self.is_spent() {
                break;
            }
            let dropped = *model
                .terms
                .iter()
                .find(|t| !less.terms.contains(t))
                .unwrap_or(&model.terms[0]);
            let mut taken = less.terms.clone();
            taken.push(dropped);
            let offers = self.offers(&less, &taken);
            let loss = model.likelihood - less.likelihood;
            let (mut offers, rest): (Vec<Signatures>, Vec<Signatures>) = offers
                .into_iter()
                .partition(|o| near.contains(&o.term) || o.predicted_gain() > 0.2 * loss);
            let found = self.refits(&less, &offers, Reach::Near, SOME);
            offers.extend(rest);
            let gains = |m: &&Model| self.merit(m) > self.merit(model) + 1.0;
            let best =
                (found.iter().filter(gains)).max_by(|a, b| self.merit(a).total_cmp(&self.merit(b)));
            if let Some(best) = best
                && self.stands(&less, best, &offers)
            {
                better.push(best.clone());
            }
            tried.extend(found);
        }
        let best = (better.into_iter()).max_by(|a, b| self.merit(a).total_cmp(&self.merit(b)));
        if let Some(best) = best {
            tried.push(std::mem::replace(model, best));
        }
        tried.retain(|m| m.terms != model.terms);
        Ok(tried)
    }
}

/// Whether a model's log likelihood is too far behind the first one's to be chosen by merit.
fn is_behind(likelihood: f64, first: f64) -> bool {
    likelihood < first - policy::CLOSE
}

/// Whether an effect that the held-out part cannot confirm gains so much more than chance does.
fn outweighs(gain: f64, chance: f64, unevenness: f64) -> bool {
    gain > policy::UNCONFIRMED * chance * unevenness
}

/// Share of the held-out squares that an effect must remove which does not repeat its gain on them.
fn instead(slow: bool) -> f64 {
    if slow {
        policy::SLOWLY
    } else {
        policy::ADEQUATE
    }
}

/// Those at the front of the `found` ones that gain at least half of what the best does.
fn leaders<'m>(model: &Model, best: &Model, found: &'m [Model]) -> Vec<&'m Model> {
    let least = 0.5 * (best.likelihood - model.likelihood);
    found
        .iter()
        .take(LEADERS)
        .filter(|m| m.likelihood <= best.likelihood)
        .filter(|m| m.likelihood - model.likelihood >= least)
        .collect()
}

impl SearchState {
    /// The last model that proved itself, with the rounds and the rivals seen from there.
    fn named(self) -> Named {
        let (model, mut rounds, mut rivals) = (self.proven, self.rounds, self.rivals);
        for round in &mut rounds {
            round.accepted &= model.terms.contains(&round.term);
        }
        rivals.retain(|m| m.terms.len() <= model.terms.len() && m.terms != model.terms);
        rivals.sort_by(|a, b| b.likelihood.total_cmp(&a.likelihood));
        rivals.dedup_by(|a, b| a.terms == b.terms);
        Named {
            model,
            rounds,
            rivals,
            offered: self.offered,
            attempts: self.attempts,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::search::criteria::any_removed;

    #[test]
    fn merit_chooses_among_what_is_close_to_the_first() {
        assert!(is_behind(50.0 - 1.01 * policy::CLOSE, 50.0));
        assert!(!is_behind(50.0 - 0.99 * policy::CLOSE, 50.0));
    }

    #[test]
    fn what_the_held_out_part_cannot_confirm_gains_more_than_chance() {
        let bound = policy::UNCONFIRMED * 12.0 * 1.5;
        assert!(outweighs(1.01 * bound, 12.0, 1.5) && !outweighs(0.99 * bound, 12.0, 1.5));
    }

    #[test]
    fn what_does_not_repeat_its_gain_removes_nearly_all_and_a_slow_effect_less() {
        let removes = |share: f64, slow| any_removed(&[1.0], &[1.0 - share], instead(slow));
        assert!(removes(1.001 * policy::ADEQUATE, false));
        assert!(!removes(0.999 * policy::ADEQUATE, false));
        assert!(removes(1.01 * policy::SLOWLY, true) && !removes(0.99 * policy::SLOWLY, true));
    }
}
