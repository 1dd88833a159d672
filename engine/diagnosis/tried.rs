//! What was tried: sets of effects that were fitted to the end, and why each is not the answer.

use crate::decide::Decision;
use crate::explain::windows::why_not as unsupported;
use crate::judge::parameters;
use crate::prepare::Prepared;
use crate::search::Search;
use crate::search::attempt::{Attempt, is_own};
use crate::search::extend::Reach;
use crate::search::in_parts::Seen;
use crate::verdict::by_parts::Read;
use crate::verdict::effect_report;
use crate::verdict::judge::held_rms;
use std::collections::BTreeMap;
use veloid_core::EngineError;
use veloid_core::bicycle::PerAxle;
use veloid_core::document::format_number::significant;
use veloid_core::numerics::finite::finite;
use veloid_core::settings::Settings;
use veloid_model::dataset::{Dataset, Track};
use veloid_model::effects::users_law;
use veloid_model::fit::physical::is_physical;
use veloid_model::fit::{Model, Term};
use veloid_model::law::own::Where;
use veloid_report::diagnosis::{Diagnosis, ParameterReport, Place, Verdict};
use veloid_report::tried::{Tried, TriedEffect};

/// Sets that are reported.
pub const MOST: usize = 40;
/// Of each axle that parts of its record were asked about, the heaviest.
const BY_PARTS: usize = 12;

pub const NO_VERDICT: &str = "the record carries no verdict";
const OUT_OF_RANGE: &str = "a value lies outside its physical range";

/// What was tried on the way to a decision, of which the report says `verdict`.
pub fn tried(
    prepared: &Prepared,
    search: &Search,
    decision: &Decision,
    verdict: Verdict,
) -> Vec<Tried> {
    let teller = Teller::new(prepared, search, decision, verdict);
    let mut all: Vec<Tried> = Vec::new();
    all.extend(teller.answer());
    let attempts = own_law_fitted(search, &decision.attempts);
    all.extend(attempts.iter().map(|attempt| teller.attempt(attempt)));
    for (track, read) in prepared.record().tracks.iter().zip(&decision.read) {
        let read = read.iter().flat_map(|read| teller.by_parts(track, read));
        all.extend(read);
    }
    let own: Vec<Term> = search.candidates.iter().copied().filter(is_own).collect();
    let own = own.first().map(|term| term.id(prepared.record()));
    in_order(all, own)
}

/// Each set once, the answer first, then by gain, and no more than [`MOST`] but for those with the user's law.
pub fn in_order(all: Vec<Tried>, own: Option<&str>) -> Vec<Tried> {
    let names = |tried: &Tried| -> Vec<(String, Place)> {
        let names = tried.effects.iter().map(|e| (e.id.clone(), e.axle));
        names.collect()
    };
    let mut kept: Vec<Tried> = Vec::new();
    for tried in all {
        if kept.iter().all(|other| names(other) != names(&tried)) {
            kept.push(tried);
        }
    }
    let rank = |t: &Tried| (t.why_not.is_none(), t.gain.unwrap_or(f64::NEG_INFINITY));
    kept.sort_by(|a, b| {
        let (a, b) = (rank(a), rank(b));
        b.0.cmp(&a.0).then(b.1.total_cmp(&a.1))
    });
    let is_own = |t: &Tried| own.is_some_and(|id| t.has(id));
    while kept.len() > MOST {
        let last = kept
            .iter()
            .rposition(|t| !is_own(t))
            .unwrap_or(kept.len() - 1);
        kept.remove(last);
    }
    kept
}

/// The likeliest attempt of each set of effects; with a law of the user's own by itself where the search has not come to it.
fn own_law_fitted(search: &Search, attempts: &[Attempt]) -> Vec<Attempt> {
    let mut best: Vec<Attempt> = Vec::new();
    let alone = (search.candidates.iter())
        .filter(|term| is_own(term) && attempts.iter().all(|a| !a.model.terms.contains(term)));
    let own = alone.flat_map(|term| {
        let others: Vec<Term> = search
            .candidates
            .iter()
            .filter(|t| *t != term)
            .copied()
            .collect();
        let offers = search.offers(&search.plain, &others);
        let found = search.refits(&search.plain, &offers, Reach::Far, f64::NEG_INFINITY);
        Attempt::of_round(&found, |_| None)
    });
    for attempt in attempts.iter().cloned().chain(own) {
        match best
            .iter_mut()
            .find(|b| b.model.terms == attempt.model.terms)
        {
            Some(known) if known.model.likelihood >= attempt.model.likelihood => {}
            Some(known) => *known = attempt,
            None => best.push(attempt),
        }
    }
    best
}

struct Teller<'a> {
    prepared: &'a Prepared,
    search: &'a Search<'a>,
    decision: &'a Decision,
    verdict: Verdict,
    /// The effects that the verdict speaks of.
    answer: &'a [Term],
    /// RMS error of the plain model on the held-out part, by track.
    plain: Vec<f64>,
}

impl<'a> Teller<'a> {
    fn new(
        prepared: &'a Prepared,
        search: &'a Search<'a>,
        decision: &'a Decision,
        verdict: Verdict,
    ) -> Self {
        let mut teller = Self {
            prepared,
            search,
            decision,
            verdict,
            answer: match verdict.names_effects() {
                true => &decision.model.terms,
                false => &[],
            },
            plain: Vec::new(),
        };
        teller.plain = teller.held_out(&decision.shown_plain);
        teller
    }

    fn record(&self) -> &Dataset {
        self.prepared.record()
    }

    fn held_out(&self, model: &Model) -> Vec<f64> {
        let tracks = 0..self.record().tracks.len();
        let rms = |t| held_rms((self.record(), model), t, &self.prepared.split);
        tracks.map(rms).collect()
    }

    /// Held-out errors on the axles that a model acts on.
    fn by_axle(&self, model: &Model, held: &[f64]) -> PerAxle<f64> {
        let mut found = PerAxle::default();
        for (track, rms) in self.record().tracks.iter().zip(held) {
            let acted = model.terms.iter().any(|t| t.acts_on(track.axle));
            if let Some(rms) = finite(*rms).filter(|_| acted) {
                found.set(track.axle, rms);
            }
        }
        found
    }

    fn effects(&self, model: &Model) -> Vec<TriedEffect> {
        let of = |term: &Term| TriedEffect {
            id: term.id(self.record()).to_owned(),
            axle: term.place,
            parameters: effect_report::effect(self.record(), model, term, None, None)
                .map_or_else(BTreeMap::new, |effect| effect.parameters),
        };
        model.terms.iter().map(of).collect()
    }

    /// Gain of the decision's model, where likelihood found it.
    fn answer_gain(&self) -> Option<f64> {
        let by_likelihood = self.decision.claims.is_empty();
        by_likelihood.then_some(self.decision.model.likelihood - self.search.plain.likelihood)
    }

    /// The model that the verdict speaks of.
    fn answer(&self) -> Option<Tried> {
        let model = &self.decision.corrected;
        (!self.answer.is_empty()).then(|| Tried {
            effects: self.effects(model),
            parameters: parameters(&model.terms),
            gain: self.answer_gain().and_then(finite),
            held_out_rms_m: self.by_axle(model, &self.held_out(&self.decision.shown)),
            why_not: (self.verdict == Verdict::Ambiguous)
                .then(|| "other sets explain the ride as well".to_owned()),
        })
    }

    fn attempt(&self, attempt: &Attempt) -> Tried {
        let model = &attempt.model;
        let held = self.held_out(model);
        let effects = self.effects(model);
        let gain = model.likelihood - self.search.plain.likelihood;
        Tried {
            parameters: parameters(&model.terms),
            gain: finite(gain),
            held_out_rms_m: self.by_axle(model, &held),
            why_not: Some(self.why_not(attempt, gain, &held, &effects)),
            effects,
        }
    }

    fn why_not(
        &self,
        attempt: &Attempt,
        gain: f64,
        held: &[f64],
        effects: &[TriedEffect],
    ) -> String {
        let Attempt { model, chance } = attempt;
        let nats = |x: f64| significant(x, 3);
        let undetermined = || {
            let terms = model.terms.iter().zip(effects);
            terms
                .filter_map(|(term, effect)| undetermined(term, effect))
                .next()
        };
        let tracks = self
            .record()
            .tracks
            .iter()
            .zip(held.iter().zip(&self.plain));
        let is_confirmed = tracks
            .filter(|(track, _)| model.terms.iter().any(|t| t.acts_on(track.axle)))
            .any(|(_, (held, plain))| held < plain);
        if self.verdict == Verdict::CannotTell {
            return NO_VERDICT.to_owned();
        }
        if self
            .decision
            .tied
            .iter()
            .any(|tied| tied.terms == model.terms)
        {
            return format!("explains the ride as well as {}", self.name(self.answer));
        }
        if !is_physical(self.search.fitter.dataset, &self.search.plain, model) {
            return OUT_OF_RANGE.to_owned();
        }
        match chance {
            Some([gain, by_chance]) if gain <= by_chance => {
                return format!(
                    "its last effect gains {} in log likelihood, noise alone up to {}",
                    nats(*gain),
                    nats(*by_chance)
                );
            }
            _ => {}
        }
        if let Some(why) = undetermined() {
            return why;
        }
        if !is_confirmed {
            return "the held-out part does not confirm it".to_owned();
        }
        self.beside_the_answer(model, gain)
    }

    /// Why a model that gains something is not the answer.
    fn beside_the_answer(&self, model: &Model, gain: f64) -> String {
        let within = |few: &[Term], all: &[Term]| few.iter().all(|term| all.contains(term));
        let named = self.name(self.answer);
        if self.answer.is_empty() {
            return match self.verdict {
                Verdict::NothingMissing => "too little of its gain repeats on the held-out part",
                _ => "leaves more than noise",
            }
            .to_owned();
        }
        if within(&model.terms, self.answer) {
            return format!("part of the answer, {named}");
        }
        if within(self.answer, &model.terms) {
            return format!("adds too little to {named}");
        }
        match self.answer_gain() {
            Some(answer) if gain > answer => {
                let more = parameters(&model.terms).saturating_sub(parameters(self.answer));
                let further = significant(gain - answer, 3);
                format!("gains {further} more than {named} with {more} more parameters, too little")
            }
            _ => format!("explains no more than {named}"),
        }
    }

    fn name(&self, terms: &[Term]) -> String {
        let named = |t: &Term| {
            let id = t.id(self.record()).replace('_', " ");
            format!("{id} ({})", t.place.name())
        };
        let names: Vec<String> = terms.iter().map(named).collect();
        names.join(" with ")
    }

    /// The heaviest sets that parts of a track's record were asked about, and those with a law of the user's own.
    fn by_parts(&self, track: &Track, read: &Read) -> Vec<Tried> {
        let (evidence, judgement) = (&read.evidence, &read.judgement);
        let weight = |s: &usize| judgement.weights[*s].unwrap_or(-1.0);
        let mut order: Vec<usize> = (0..evidence.sets.len()).collect();
        order.sort_by(|a, b| weight(b).total_cmp(&weight(a)));
        let kept = order.iter().enumerate().filter(|(rank, s)| {
            let terms = evidence.sets[**s][0].terms();
            !terms.is_empty() && (*rank < BY_PARTS || terms.iter().any(is_own))
        });
        let of = |s: usize| {
            let (seen, set) = (&evidence.sets[s][0], &evidence.scores.sets[s]);
            let mut held_out_rms_m = PerAxle::default();
            if let Some(rms) = finite(track.spread() * set.mean(0).sqrt()) {
                held_out_rms_m.set(track.axle, rms);
            }
            let reason = || match judgement.weights[s] {
                None => OUT_OF_RANGE.to_owned(),
                Some(weight) => {
                    let effects = set.effects.iter();
                    let why = |e: &usize| unsupported(judgement, *e, &judgement.supports[*e]);
                    effects.filter_map(why).next().unwrap_or_else(|| {
                        format!("holds {} of the support", significant(weight, 2))
                    })
                }
            };
            Tried {
                effects: values(track, seen, self.record()),
                parameters: set.parameters,
                gain: None,
                held_out_rms_m,
                why_not: Some(match self.verdict {
                    Verdict::CannotTell => NO_VERDICT.to_owned(),
                    _ => reason(),
                }),
            }
        };
        kept.map(|(_, s)| of(*s)).collect()
    }
}

/// The effects of a set with their values, whose errors parts do not give.
fn values(track: &Track, seen: &Seen, record: &Dataset) -> Vec<TriedEffect> {
    let terms = seen.terms().iter().zip(&seen.point.values);
    terms
        .map(|(term, values)| TriedEffect {
            id: term.id(record).to_owned(),
            axle: term.place,
            parameters: (term.kind.spec().report)(values, &track.scale)
                .into_iter()
                .map(|r| {
                    let parameter = ParameterReport {
                        value: r.value,
                        std_error: None,
                        not_identifiable: None,
                        unit: r.unit.into_owned(),
                    };
                    (r.name.into_owned(), parameter)
                })
                .collect(),
        })
        .collect()
}

/// Why an effect's size is not known, if it is not.
fn undetermined(term: &Term, effect: &TriedEffect) -> Option<String> {
    let spec = term.kind.spec();
    let name = match is_own(term) {
        // Of a law of the user's own the parameters are in the order of their names.
        true => effect.parameters.keys().nth(spec.size_parameter)?.clone(),
        false => term.kind.reported().get(spec.size_parameter)?.to_string(),
    };
    let parameter = effect.parameters.get(&name)?;
    let plain = name.replace('_', " ");
    let why = parameter.not_identifiable.as_ref();
    why.map(|why| format!("{plain} is not determined: {why}"))
}

/// The diagnosis with an entry for each place of the user's law that was not fitted, and `why`, unless the ride lacks a channel.
///
/// # Errors
/// A law that cannot be read.
pub fn with_own_law(
    mut diagnosis: Diagnosis,
    settings: &Settings,
    why: &str,
) -> Result<Diagnosis, EngineError> {
    let Some(law) = users_law(settings)? else {
        return Ok(diagnosis);
    };
    let off = diagnosis.switched_off.iter().find(|off| off.id == law.id);
    let why = off.map_or(why, |off| &off.why).to_owned();
    let places = match law.acts {
        Where::Front => &[Place::Front][..],
        Where::Rear => &[Place::Rear],
        Where::Each => &[Place::Front, Place::Rear],
        Where::Both => &[Place::Both],
    };
    for place in places {
        let is_there = |e: &TriedEffect| e.id == law.id && e.axle == *place;
        if !diagnosis
            .tried
            .iter()
            .any(|t| t.effects.iter().any(is_there))
        {
            diagnosis.tried.push(Tried {
                effects: vec![TriedEffect {
                    id: law.id.clone(),
                    axle: *place,
                    parameters: BTreeMap::new(),
                }],
                parameters: law.parameters.len(),
                gain: None,
                held_out_rms_m: PerAxle::default(),
                why_not: Some(why.clone()),
            });
        }
    }
    Ok(diagnosis)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(id: &str, gain: f64, why_not: Option<&str>) -> Tried {
        Tried {
            effects: vec![TriedEffect {
                id: id.to_owned(),
                axle: Place::Front,
                parameters: BTreeMap::new(),
            }],
            parameters: 1,
            gain: Some(gain),
            held_out_rms_m: PerAxle::default(),
            why_not: why_not.map(str::to_owned),
        }
    }

    #[test]
    fn the_answer_comes_first_and_a_law_of_the_users_own_is_never_left_out() {
        let many = (0..2 * MOST).map(|i| of(&format!("effect_{i}"), i as f64, Some("too little")));
        let mut all: Vec<Tried> = many.collect();
        all.push(of("own_law", -1.0, Some("too little")));
        all.push(of("effect_7", 1e9, Some("known already")));
        all.push(of("named", 0.5, None));
        let kept = in_order(all, Some("own_law"));
        let ids: Vec<&str> = kept.iter().map(|t| t.effects[0].id.as_str()).collect();
        assert_eq!(ids.len(), MOST);
        assert_eq!(
            (ids[0], ids[1], ids[MOST - 1]),
            ("named", "effect_79", "own_law")
        );
    }

    #[test]
    fn a_law_that_was_not_fitted_is_listed_with_the_reason() {
        let settings = Settings {
            law: Some(
                "id = 'mine'\nforce = 'a * d^5'\nparameters.a = { start = 1, range = [0, 2] }"
                    .to_owned(),
            ),
            ..Settings::default()
        };
        let bare = Diagnosis::without_verdict("No verdict.".to_owned());
        let listed = with_own_law(bare, &settings, NO_VERDICT).unwrap_or_else(|e| panic!("{e}"));
        let places: Vec<Place> = listed.tried.iter().map(|t| t.effects[0].axle).collect();
        assert_eq!(places, [Place::Front, Place::Rear]);
        assert_eq!(listed.tried[0].why_not.as_deref(), Some(NO_VERDICT));
        let again = with_own_law(listed.clone(), &settings, "another reason");
        assert_eq!(again.unwrap_or_else(|e| panic!("{e}")), listed);
    }
}
