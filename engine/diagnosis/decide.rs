//! The verdict: what was found is judged on every axle, and where that is not enough, looked for once more.

use rayon::prelude::*;
use tracing::debug;

use crate::policy;
use crate::prepare::Prepared;
use crate::search::offered::Offered;
use crate::search::{Round, Search};
use crate::verdict::affirm::Claim;
use crate::verdict::by_windows;
use crate::verdict::carries::has_size;
use crate::verdict::choose::{Chosen, choose};
use crate::verdict::effect_report;
use crate::verdict::general_laws::{dominates, is_curve, is_outgrown};
use crate::verdict::input_noise;
use crate::verdict::judge::{Candidate, Judged, judge};
use crate::verdict::partly::{self, Partly, Rest, partly};
use crate::verdict::twice::Sights;
use veloid_core::EngineError;
use veloid_core::bicycle::PerAxle;
use veloid_core::numerics::spectrum::most_white;
use veloid_core::settings::Settings;
use veloid_methods::output_error::rms_valid;
use veloid_model::dataset::{Dataset, Track};
use veloid_model::fit::physical::is_physical;
use veloid_model::fit::polish::polish;
use veloid_model::fit::refine::refined;
use veloid_model::fit::sandwich;
use veloid_model::fit::{FINE, Fitted, Fitter, Model, Motion, Term, motions};
use veloid_report::diagnosis::{Place, SearchCost, Verdict};

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
    /// What was examined without a likelihood, each with its jackknife errors, and these of k and B.
    pub claims: Vec<(Claim, Vec<f64>)>,
    /// What windows of each track's record say, where they were asked.
    pub sighted: Vec<Option<Sights>>,
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
    let doubt = doubt(&first, prepared, search);
    debug!(verdict = ?first.verdict, terms = ?first.model.terms, ?doubt, "judged by likelihood");
    let mut decision = match first.verdict == Verdict::Unnamed || doubt != Doubt::Not {
        true => {
            let found = second_look(first, doubt, prepared, search, settings)?;
            let whole = match doubt {
                Doubt::Not => as_one(&found, prepared, search, &every, settings)?,
                Doubt::Swallowed | Doubt::OnBench => None,
            };
            match whole {
                Some(whole) => simplest(whole, prepared, search)?,
                None => found,
            }
        }
        false => simplest(agreed(first, prepared, search, settings), prepared, search)?,
    };
    decision.cost.steps = prepared.dataset.work.done();
    decision.cost.budget = search.budget.steps;
    debug!(verdict = ?decision.verdict, terms = ?decision.model.terms, cost = ?decision.cost, "decided");
    Ok(decision)
}

/// Times the search's budget that windows may take: what a search by windows costs at all does not shrink with the record, and
/// half of it is the second length.
const WINDOWS: u64 = 3;

/// Why a verdict by likelihood is asked again.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Doubt {
    Not,
    /// The noise has swallowed what an effect takes off.
    Swallowed,
    /// On a bench effects have names although hardly any force is missing, or nothing is missing although more than noise is left.
    OnBench,
}

fn doubt(first: &Decision, prepared: &Prepared, search: &Search) -> Doubt {
    let slight = || by_windows::misses_little(prepared.record());
    let on_bench = match first.verdict {
        Verdict::Named | Verdict::Ambiguous => slight(),
        Verdict::NothingMissing => is_loud(first, prepared) && !slight(),
        Verdict::NamedInPart | Verdict::Unnamed | Verdict::CannotTell => false,
    };
    if on_bench {
        Doubt::OnBench
    } else if is_swallowed(search, first, prepared.record()) {
        Doubt::Swallowed
    } else {
        Doubt::Not
    }
}

/// Whether no road drives any axle, and what the model leaves on one is mostly no white noise: then the noise that was fitted to it may
/// have swallowed what is missing.
fn is_loud(decision: &Decision, prepared: &Prepared) -> bool {
    let record = prepared.record();
    let loud = |(t, track): (usize, &Track)| {
        let left = decision.shown.residual(record, t);
        let rms = rms_valid(&left, &track.valid, prepared.split.held.clone());
        most_white(&left, record.step).is_some_and(|noise| is_more_than(noise, rms))
    };
    let mut tracks = record.tracks.iter().enumerate();
    record.tracks.iter().all(|track| !track.has_road) && tracks.any(loud)
}

/// What holds although no model explains the ride, or the nearest shape.
fn second_look(
    first: Decision,
    doubt: Doubt,
    prepared: &Prepared,
    search: &Search,
    settings: &Settings,
) -> Result<Decision, EngineError> {
    let named = match doubt {
        Doubt::OnBench => Vec::new(),
        Doubt::Not | Doubt::Swallowed => named_by_axle(&first, prepared, search, settings)?,
    };
    // Where the likelihood is not to be trusted, or what explains the ride is a wider law or nothing physical, something may be left on all
    // tracks.
    let explained = first.judged.iter().all(|j| !j.remains) && doubt == Doubt::Not;
    let by_wider_law = explained && is_physical(&prepared.dataset, &search.plain, &first.model);
    let rest = Rest {
        remains: (first.judged.iter())
            .enumerate()
            .map(|(t, j)| {
                let is_named = named.iter().any(|(axle, _)| *axle == t);
                (j.remains || doubt != Doubt::Not || explained) && !is_named
            })
            .collect(),
        outgrown: outgrown(by_wider_law),
    };
    let said = first.verdict;
    let first = Decision {
        verdict: Verdict::Unnamed,
        ..first
    };
    let record = prepared.record();
    // What a wider law explains to within the noise is the likelihood's affair.
    let work = &prepared.dataset.work;
    let allowed = work.done() + WINDOWS * search.budget.steps;
    let sighted = match by_wider_law {
        true => Vec::new(),
        false => by_windows::sighted(search, record, &rest, allowed)?,
    };
    let cut_short = work.done() > allowed;
    // What the first search has left, and at least what was set aside, whatever windows have taken.
    let budget = search.budget;
    let until = budget.steps.max(work.done() + budget.steps - budget.first);
    let found = match by_windows::by_windows(search, record, &rest, &sighted) {
        Some(found) => Some(found),
        None => partly(search, record, &rest, &first.model, until)?
            .map(|found| by_windows::uncontradicted(found, record, &sighted)),
    };
    let holds = |term: &Term| {
        let mut claims = found.iter().flat_map(|found| &found.claims);
        claims.any(|claim| claim.holds && claim.term == *term)
    };
    let is_confirmed =
        doubt == Doubt::OnBench && said == Verdict::Named && first.model.terms.iter().all(holds);
    let mut decision = match found {
        _ if is_confirmed => Decision {
            verdict: said,
            ..first
        },
        Some(partly) => first.in_part(partly, prepared, settings),
        None => first,
    };
    for (t, named) in named {
        decision = decision.with_axle(t, named, prepared);
    }
    decision.sighted = sighted;
    decision.cost.is_spent |= work.done() > until || cut_short;
    let errs_more = decision.verdict == Verdict::Unnamed
        && !decision.model.terms.is_empty()
        && decision.judged.iter().any(|j| errs_more(j, 1.0));
    let nothing = decision.verdict == Verdict::Unnamed && by_windows::misses_little(record);
    Ok(match (nothing, errs_more) {
        (true, _) => (decision.without_shape(prepared, settings)).nothing_missing(),
        (false, true) => decision.without_shape(prepared, settings),
        (false, false) => decision,
    })
}

/// Effects that were found axle by axle or beside a rest, as one model, where the likelihood names that.
fn as_one(
    found: &Decision,
    prepared: &Prepared,
    search: &Search,
    every: &[usize],
    settings: &Settings,
) -> Result<Option<Decision>, EngineError> {
    let by_likelihood_alone = found.sighted.iter().all(Option::is_none);
    let all_hold = found.claims.iter().all(|(claim, _)| claim.holds);
    if found.verdict != Verdict::NamedInPart || !by_likelihood_alone || !all_hold {
        return Ok(None);
    }
    let polished = polish(&search.fitter, &found.model, search.thorough(&found.model));
    let chosen = Chosen {
        model: polished.unwrap_or_else(|| found.model.clone()),
        rounds: found.rounds.clone(),
        tied: Vec::new(),
        offered: None,
        is_spent: found.cost.is_spent,
    };
    let whole = by_likelihood(prepared, search, chosen, every, settings)?;
    let is_named =
        whole.verdict == Verdict::Named && !is_swallowed(search, &whole, prepared.record());
    Ok(is_named.then_some(whole))
}

/// Where models tie, what they agree on, if that explains nearly all: of what they differ in, only the rest is then reported.
fn agreed(first: Decision, prepared: &Prepared, search: &Search, settings: &Settings) -> Decision {
    let in_all = |term: &&Term| first.tied.iter().all(|m| m.terms.contains(term));
    let core: Vec<Term> = first.model.terms.iter().filter(in_all).copied().collect();
    if first.verdict != Verdict::Ambiguous || core.is_empty() {
        return first;
    }
    match partly::of_core(search, prepared.record(), &first.model, &core) {
        Some(core) => first.in_part(core, prepared, settings),
        None => first,
    }
}

/// A set of effects that the likelihood names ties with a simpler one that windows of the record support in its place.
fn simplest(
    named: Decision,
    prepared: &Prepared,
    search: &Search,
) -> Result<Decision, EngineError> {
    if named.verdict != Verdict::Named {
        return Ok(named);
    }
    let simpler = by_windows::simpler(search, prepared.record(), &named.model)?;
    Ok(match simpler {
        Some(simpler) => Decision {
            verdict: Verdict::Ambiguous,
            tied: vec![simpler],
            ..named
        },
        None => named,
    })
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
        claims: Vec::new(),
        sighted: Vec::new(),
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
            verdict: match partly.claims.iter().any(|claim| claim.holds) {
                true => Verdict::NamedInPart,
                false => self.verdict,
            },
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

/// Whether a model that leaves so much (RMS) leaves mostly something else than white noise.
fn is_more_than(noise: f64, rms: f64) -> bool {
    rms > policy::LOUD_REST * noise
}

/// Share of a model's held-out squares that a law wider than one of its names must leave for this to hold.
fn outgrown(by_wider_law: bool) -> f64 {
    match by_wider_law {
        true => policy::NEARLY_ALL,
        false => policy::OUTGROWN,
    }
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
    use crate::verdict::affirm;
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
    fn more_than_noise_is_left_where_that_is_louder_by_far() {
        let loud = |times: f64| is_more_than(0.3, times * policy::LOUD_REST * 0.3);
        assert!(loud(1.01) && !loud(0.99));
    }

    #[test]
    fn beside_a_law_that_explains_the_ride_to_its_noise_hardly_less_is_left() {
        let grows = |left: f64, by_wider_law| {
            affirm::is_outgrown([left, 1.0, 1.0], outgrown(by_wider_law), true)
        };
        assert!(grows(0.999 * policy::NEARLY_ALL, true));
        assert!(!grows(1.001 * policy::NEARLY_ALL, true));
        assert!(grows(0.999 * policy::OUTGROWN, false));
        assert!(!grows(1.001 * policy::OUTGROWN, false));
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
