//! The verdict: what was found is judged on every axle, and where that is not enough, looked for once more.

use rayon::prelude::*;
use tracing::debug;

use crate::judge;
use crate::policy;
use crate::prepare::Prepared;
use crate::search::attempt::Attempt;
use crate::search::offered::Offered;
use crate::search::{Round, Search};
use crate::verdict::by_parts::{self, Claim, Partly, Read};
use crate::verdict::carries::has_size;
use crate::verdict::choose::{Chosen, choose};
use crate::verdict::effect_report;
use crate::verdict::general_laws::{dominates, is_curve, is_outgrown};
use crate::verdict::input_noise;
use crate::verdict::judge::{Candidate, Judged, judge};
use veloid_core::EngineError;
use veloid_core::bicycle::PerAxle;
use veloid_core::settings::Settings;
use veloid_methods::output_error::spread_valid;
use veloid_model::dataset::{Dataset, Track};
use veloid_model::fit::physical::is_physical;
use veloid_model::fit::polish::polish;
use veloid_model::fit::refine::refined;
use veloid_model::fit::sandwich;
use veloid_model::fit::{FINE, Fitted, Fitter, Model, Motion, Term, motions};
use veloid_report::diagnosis::{Place, SearchCost, Verdict};
use veloid_report::windows::Rule;

/// The verdict and the model that it speaks of.
pub struct Decision {
    pub verdict: Verdict,
    /// As it was searched, with what it makes of the ride.
    pub model: Model,
    pub motions: Vec<Motion>,
    pub judged: Vec<Judged>,
    /// As it is measured on the record itself, beside the plain one.
    pub shown: Model,
    pub shown_plain: Model,
    /// The same without what noise in the road channel does to it.
    pub corrected: Model,
    /// The rounds that led there; none where likelihood did not.
    pub rounds: Vec<Round>,
    /// Others that explain the ride as well, best first.
    pub tied: Vec<Model>,
    /// What the search was offered at its end.
    pub offered: Option<Offered>,
    /// What was fitted to the end on the way.
    pub attempts: Vec<Attempt>,
    /// What was examined without a likelihood, each with its jackknife errors, and these of k and B.
    pub claims: Vec<(Claim, Vec<f64>)>,
    /// The row of the table that gave the verdict.
    pub rule: Rule,
    /// What parts of each track's record say, where they were asked.
    pub read: Vec<Option<Read>>,
    /// Effects that the likelihood names on an axle which they complete, while something is left on the other.
    pub certain: Vec<Term>,
    pub base_errors: PerAxle<[f64; 2]>,
    /// Whether a wider law explains the ride better, by little beside what is named.
    pub is_outgrown_a_little: bool,
    /// What the search has cost.
    pub cost: SearchCost,
}

/// Searches and judges.
pub fn decide(
    prepared: &Prepared,
    search: &Search,
    settings: &Settings,
) -> Result<Decision, EngineError> {
    let every: Vec<usize> = (0..prepared.dataset.tracks.len()).collect();
    let first = by_likelihood(prepared, search, choose(search)?, &every, settings)?;
    debug!(verdict = ?first.verdict, terms = ?first.model.terms, "judged by likelihood");
    let record = prepared.record();
    let by_whole = |track: &Track| track.has_road || is_over(prepared, track);
    let mut decision = match record.tracks.iter().any(by_whole) {
        true => on_road(first, prepared, search, settings)?,
        false => {
            let asked = vec![true; record.tracks.len()];
            asked_by_parts(first, &asked, prepared, search, settings)?
        }
    };
    decision.cost.steps = prepared.dataset.work.done();
    decision.cost.budget = search.budget.steps;
    debug!(verdict = ?decision.verdict, rule = ?decision.rule, terms = ?decision.model.terms, cost = ?decision.cost, "decided");
    Ok(decision)
}

/// Whether a free decay has ended where it is held out: parts of that have nothing to say.
fn is_over(prepared: &Prepared, track: &Track) -> bool {
    let moves = spread_valid(&track.measured, &track.valid, prepared.split.held.clone());
    let fit = prepared.recorded.get(track.axle);
    !track.is_driven() && fit.is_some_and(|fit| fit.held_rms > policy::FOLLOWS * moves)
}

/// What parts of the record say of the axles that are asked, to which models were not fitted.
fn asked_by_parts(
    first: Decision,
    asked: &[bool],
    prepared: &Prepared,
    search: &Search,
    settings: &Settings,
) -> Result<Decision, EngineError> {
    let record = prepared.record();
    let proposed: Vec<Model> = [std::slice::from_ref(&first.model), &first.tied].concat();
    let evidence = judge::evidence(search, record, asked, &proposed)?;
    let read = evidence.into_iter().zip(&record.tracks);
    let read: Vec<Option<Read>> = read
        .map(|(evidence, track)| Some(Read::new(evidence?, record.is_ridden(track))))
        .collect();
    let has_road = record.tracks.iter().any(|track| track.has_road);
    let nothing = first.verdict == Verdict::NothingMissing;
    let (verdict, rule) = by_parts::verdict(asked, (has_road, nothing), &read);
    let found = by_parts::models(search, record, &read);
    let mut decision = match (verdict, found) {
        (Verdict::NothingMissing, _) if first.verdict == verdict => first,
        (Verdict::NothingMissing, _) => first.without_shape(prepared, settings).nothing_missing(),
        (_, Some((found, tied))) if !found.model.terms.is_empty() => Decision {
            tied,
            ..first.in_part(found, prepared, settings)
        },
        _ => first.without_shape(prepared, settings),
    };
    let (verdict, rule) = match verdict {
        // Of a tie only one set can be simulated along the whole record.
        Verdict::Ambiguous if decision.tied.is_empty() => (Verdict::Unnamed, Rule::Unsupported),
        _ => (verdict, rule),
    };
    let errs_more = decision.judged.iter().any(|j| errs_more(j, 1.0));
    if verdict == Verdict::Unnamed && errs_more && !decision.model.terms.is_empty() {
        decision = decision.without_shape(prepared, settings);
    }
    Ok(Decision {
        verdict,
        rule,
        read,
        ..decision
    })
}

/// On a measured road the likelihood of the whole ride decides; what it leaves without a name, parts of the record are asked.
fn on_road(
    first: Decision,
    prepared: &Prepared,
    search: &Search,
    settings: &Settings,
) -> Result<Decision, EngineError> {
    let record = prepared.record();
    let swallowed = is_swallowed(search, &first, record);
    let explained = first.judged.iter().all(|j| !j.remains);
    let by_wider_law = explained && is_physical(&prepared.dataset, &search.plain, &first.model);
    if !swallowed && (first.verdict != Verdict::Unnamed || by_wider_law) {
        return Ok(first);
    }
    let named = named_by_axle(&first, prepared, search, settings)?;
    // Where the likelihood is not to be trusted, or what explains the ride is nothing physical, something may be left on all tracks.
    let everywhere = swallowed || explained;
    let is_named = |t: usize| named.iter().any(|(axle, _)| *axle == t);
    let asked: Vec<bool> = (first.judged.iter().enumerate())
        .map(|(t, j)| (j.remains || everywhere) && !is_named(t))
        .collect();
    let mut found = asked_by_parts(first, &asked, prepared, search, settings)?;
    for (t, named) in named {
        found = found.with_axle(t, named, prepared);
    }
    let whole = as_one(&found, prepared, search, settings)?;
    Ok(whole.unwrap_or(found))
}

/// Effects that were found axle by axle or beside a rest, as one model, where the likelihood names that.
fn as_one(
    found: &Decision,
    prepared: &Prepared,
    search: &Search,
    settings: &Settings,
) -> Result<Option<Decision>, EngineError> {
    let all_hold = found.claims.iter().all(|(claim, _)| claim.holds);
    if found.verdict != Verdict::NamedInPart || !all_hold {
        return Ok(None);
    }
    let polished = polish(&search.fitter, &found.model, search.thorough(&found.model));
    let chosen = Chosen {
        model: polished.unwrap_or_else(|| found.model.clone()),
        rounds: found.rounds.clone(),
        tied: Vec::new(),
        offered: None,
        attempts: found.attempts.clone(),
        is_spent: found.cost.is_spent,
    };
    let every: Vec<usize> = (0..prepared.dataset.tracks.len()).collect();
    let whole = by_likelihood(prepared, search, chosen, &every, settings)?;
    let is_named =
        whole.verdict == Verdict::Named && !is_swallowed(search, &whole, prepared.record());
    Ok(is_named.then_some(whole))
}

/// Each axle is judged whatever happens on the other: tracks on which the likelihood alone names what is missing, each with its
/// decision; none where only one was recorded.
fn named_by_axle(
    first: &Decision,
    prepared: &Prepared,
    search: &Search,
    settings: &Settings,
) -> Result<Vec<(usize, Decision)>, EngineError> {
    let mut found = Vec::new();
    if first.judged.len() < 2 {
        return Ok(found);
    }
    for (t, track) in prepared.dataset.tracks.iter().enumerate() {
        let axle = track.axle;
        let alone = on_axle(search, |term| {
            term.acts_on(axle) && term.place != Place::Both
        });
        let own = by_likelihood(prepared, &alone, choose(&alone)?, &[t], settings)?;
        if own.verdict == Verdict::Named && !is_swallowed(&alone, &own, prepared.record()) {
            found.push((t, own));
        }
    }
    Ok(found)
}

/// The search among some candidates, with a budget of its own.
fn on_axle<'s>(search: &Search<'s>, is_candidate: impl Fn(&Term) -> bool) -> Search<'s> {
    let dataset = search.fitter.dataset;
    Search {
        fitter: Fitter {
            dataset,
            samples: search.fitter.samples,
        },
        plain: search.plain.clone(),
        held: search.held.clone(),
        candidates: (search.candidates.iter().copied())
            .filter(is_candidate)
            .collect(),
        until: dataset.work.done() + search.budget.first,
        ..*search
    }
}

/// What the search by likelihood leads to, where the tracks of `asked` alone count.
fn by_likelihood(
    prepared: &Prepared,
    search: &Search,
    Chosen {
        model,
        rounds,
        tied,
        offered,
        attempts,
        is_spent,
    }: Chosen,
    asked: &[usize],
    settings: &Settings,
) -> Result<Decision, EngineError> {
    let shown = measured(prepared, search, &model);
    let motions = motions(&prepared.dataset, &model);
    let judged = judged(prepared, &model, &motions, &shown, settings);
    let counts = || asked.iter().map(|t| &judged[*t]);
    let explains = !model.terms.is_empty()
        && counts().all(is_explained)
        && is_physical(&prepared.dataset, &search.plain, &model);
    let wider = explains && (is_curve(search, &model) || is_outgrown(search, &model));
    let little = wider && dominates(search, &model);
    let verdict = match (model.terms.is_empty(), explains) {
        (true, _) if counts().all(|j| !j.remains) => Verdict::NothingMissing,
        (true, _) | (false, false) => Verdict::Unnamed,
        (false, true) if wider && !little => Verdict::Unnamed,
        (false, true) if tied.is_empty() => Verdict::Named,
        (false, true) => Verdict::Ambiguous,
    };
    let corrected = input_noise::corrected(&prepared.on_record(), &shown, settings.seed);
    Ok(Decision {
        // What noise is left says nothing of errors where something else is left too.
        corrected: match verdict {
            Verdict::Named | Verdict::Ambiguous => {
                sandwich::widened(&search.fitter, &model, corrected)
            }
            _ => corrected,
        },
        verdict,
        shown_plain: prepared.plain_of_record()?,
        model,
        motions,
        judged,
        shown,
        rounds,
        tied,
        offered,
        attempts,
        claims: Vec::new(),
        rule: Rule::Likelihood,
        read: Vec::new(),
        certain: Vec::new(),
        base_errors: PerAxle::default(),
        is_outgrown_a_little: little,
        cost: SearchCost {
            is_spent,
            ..SearchCost::default()
        },
    })
}

impl Decision {
    /// The effects that hold although something else is left, or the nearest shape.
    fn in_part(self, partly: Partly, prepared: &Prepared, settings: &Settings) -> Self {
        let motions = motions(&prepared.dataset, &partly.model);
        let mut judged = judged(prepared, &partly.model, &motions, &partly.model, settings);
        for (track, judged) in prepared.dataset.tracks.iter().zip(&mut judged) {
            if let Some(windows) = partly.in_windows.get(track.axle) {
                judged.predicts(windows);
            }
        }
        Self {
            motions,
            judged,
            corrected: partly.model.clone(),
            shown: partly.model.clone(),
            model: partly.model,
            shown_plain: partly.plain,
            claims: (partly.claims.into_iter().zip(partly.effect_errors)).collect(),
            base_errors: partly.base_errors,
            rounds: Vec::new(),
            ..self
        }
    }

    /// The same with what was decided on one axle.
    fn with_axle(self, t: usize, mut own: Self, prepared: &Prepared) -> Self {
        let axle = prepared.dataset.tracks[t].axle;
        let with = |all: &Model, own: &Model| all.with(own.of_track(t).0.clone());
        let mut joined = Self {
            verdict: Verdict::NamedInPart,
            model: with(&self.model, &own.model),
            shown: with(&self.shown, &own.shown),
            shown_plain: with(&self.shown_plain, &own.shown_plain),
            corrected: with(&self.corrected, &own.corrected),
            ..self
        };
        joined.motions[t] = own.motions.swap_remove(t);
        joined.judged[t] = own.judged.swap_remove(t);
        joined.rounds.retain(|round| !round.term.acts_on(axle));
        joined.rounds.append(&mut own.rounds);
        joined.certain.append(&mut own.model.terms);
        joined.attempts.append(&mut own.attempts);
        joined.is_outgrown_a_little |= own.is_outgrown_a_little;
        joined
    }

    /// That the plain model misses next to nothing of the force, whatever the noise is.
    fn nothing_missing(mut self) -> Self {
        self.judged.iter_mut().for_each(|j| j.remains = false);
        Self {
            verdict: Verdict::NothingMissing,
            ..self
        }
    }

    /// The plain model in the place of a shape that errs more where nothing was fitted.
    fn without_shape(self, prepared: &Prepared, settings: &Settings) -> Self {
        let model = prepared.plain.clone();
        let motions = motions(&prepared.dataset, &model);
        Self {
            judged: judged(prepared, &model, &motions, &self.shown_plain, settings),
            model,
            motions,
            shown: self.shown_plain.clone(),
            corrected: self.shown_plain.clone(),
            claims: Vec::new(),
            rounds: Vec::new(),
            ..self
        }
    }
}

/// The model as it is measured on the record itself.
fn measured(prepared: &Prepared, search: &Search, model: &Model) -> Model {
    if !prepared.is_dithered() {
        return model.clone();
    }
    let on_record = prepared.on_record();
    // Beyond its band the record holds nothing, not even noise: what an effect makes there would refute it.
    if prepared.dataset.tracks.iter().any(|t| t.band.is_some()) {
        return as_it_is(&on_record, model);
    }
    let settled = polish(&on_record, model, search.thorough(model));
    let mut shown = refined(&on_record, settled.as_ref().unwrap_or(model));
    // What lies between the samples is no noise: how far it may lead, the dithered fit shows.
    for (shown, dithered) in shown.fits.iter_mut().zip(&model.fits) {
        shown.covariance = dithered.covariance.clone();
    }
    shown
}

/// The model with what it leaves of a record, nothing fitted.
fn as_it_is(fitter: &Fitter, model: &Model) -> Model {
    let substeps = model.substeps(fitter.dataset, FINE);
    let of = |f: &Fitted| {
        let residuals = fitter.residuals(&f.unit, &f.point, substeps);
        let again = fitter.finish(&f.unit, f.point.clone(), residuals, f.covariance.clone());
        again.unwrap_or_else(|| f.clone())
    };
    Model::new(model.terms.clone(), model.fits.iter().map(of).collect())
}

fn judged(
    prepared: &Prepared,
    model: &Model,
    motions: &[Motion],
    shown: &Model,
    settings: &Settings,
) -> Vec<Judged> {
    let fitter = prepared.fitter();
    let of_track = |t| {
        let candidate = Candidate {
            model,
            motions,
            shown: (prepared.is_dithered()).then_some((prepared.record(), shown)),
        };
        judge(
            &fitter,
            &prepared.recorded,
            &candidate,
            t,
            &prepared.split,
            settings,
        )
    };
    let tracks = 0..prepared.dataset.tracks.len();
    tracks.into_par_iter().map(of_track).collect()
}

/// Whether a model with a name explains an axle: nothing remains or next to nothing, and the name does not mislead.
fn is_explained(judged: &Judged) -> bool {
    (!judged.remains || judged.share >= policy::ADEQUATE) && !errs_more(judged, policy::MISLEADS)
}

/// Gain in log likelihood (nats) which what effects take off the held-out squares of each track would be in white noise on so many samples.
fn gain_in_white(left: &[f64], plain: &[f64], samples: usize) -> f64 {
    (left.iter().zip(plain))
        .map(|(left, plain)| 1.0 - left / plain)
        .filter(|removed| *removed > policy::TAKEN_OFF)
        .map(|removed| -0.5 * samples as f64 * (1.0 - removed).ln())
        .sum()
}

/// Whether the gain of effects falls so short of what it would be in white noise that their noise has swallowed it.
fn falls_short(gain: f64, in_white: f64) -> bool {
    gain < policy::SWALLOWED * in_white
}

/// Whether a model leaves more than so many times what the plain one does on the held-out part.
fn errs_more(judged: &Judged, times: f64) -> bool {
    let held = &judged.held_out;
    held.extended_rms_m
        .is_none_or(|e| held.plain_rms_m.is_some_and(|p| e > times * p))
}

/// Whether the noise that was estimated from what the plain model leaves has swallowed what an effect takes off. Such a
/// likelihood shows little of what the effect is.
fn is_swallowed(search: &Search, decision: &Decision, record: &Dataset) -> bool {
    let model = &decision.model;
    let [left, plain] = [model, &search.plain].map(|m| search.held_squares(m));
    let white = gain_in_white(&left, &plain, search.fitter.samples);
    let sized = |t: &Term| {
        let effect = effect_report::effect(record, &decision.corrected, t, None, None);
        effect.is_some_and(|e| has_size(&e))
    };
    // What is slow is noise to most of a likelihood in any case.
    let is_quick = model.terms.iter().any(|term| !term.kind.spec().slow);
    let is_short = is_quick && falls_short(model.likelihood - search.plain.likelihood, white);
    !model.terms.is_empty() && (is_short || !model.terms.iter().any(sized))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::residual::omnibus::Remainder;
    use veloid_report::diagnosis::HeldOut;

    /// A model that leaves `extended` (m) of what the plain one leaves, which is 1.
    fn judged(remains: bool, share: f64, extended: Option<f64>) -> Judged {
        Judged {
            remainder: Remainder {
                p_value: 1.0,
                held_gain: 0.0,
                held_before: 1.0,
                held_after: 1.0,
                force: Vec::new(),
                residual: Vec::new(),
            },
            p_value: 1.0,
            remains,
            floor: 0.0,
            share,
            held_out: HeldOut {
                plain_rms_m: Some(1.0),
                extended_rms_m: extended,
                ..HeldOut::default()
            },
        }
    }

    #[test]
    fn a_name_explains_an_axle_on_which_next_to_nothing_is_left() {
        let explained = |remains, times: f64| {
            is_explained(&judged(remains, times * policy::ADEQUATE, Some(0.1)))
        };
        assert!(explained(true, 1.001) && !explained(true, 0.999));
        assert!(explained(false, 0.0));
    }

    #[test]
    fn a_name_that_errs_more_than_the_plain_model_misleads() {
        let explained = |errs: Option<f64>| is_explained(&judged(false, 1.0, errs));
        assert!(explained(Some(0.99 * policy::MISLEADS)));
        assert!(!explained(Some(1.01 * policy::MISLEADS)));
        // Nor does one that runs away.
        assert!(!explained(None));
    }

    #[test]
    fn what_is_taken_off_counts_from_a_share_on() {
        let samples = 800;
        let gain = |share: f64| gain_in_white(&[2.0 * (1.0 - share), 5.0], &[2.0, 5.0], samples);
        let share = 1.01 * policy::TAKEN_OFF;
        // White noise of a variance s has the log likelihood -n/2 ln s.
        let white = 400.0 * (1.0 / (1.0 - share)).ln();
        assert!((gain(share) / white - 1.0).abs() < 1e-9);
        assert_eq!(gain(0.99 * policy::TAKEN_OFF), 0.0);
    }

    #[test]
    fn noise_swallows_what_gains_next_to_nothing() {
        let bound = policy::SWALLOWED * 900.0;
        assert!(falls_short(0.99 * bound, 900.0) && !falls_short(1.01 * bound, 900.0));
        // Where effects take off little, there was nothing to swallow.
        assert!(!falls_short(1.0, 0.0));
    }
}
