//! The decision as a report.

use crate::axle::{AxleReporter, OnAxle};
use crate::beside;
use crate::decide::Decision;
use crate::explain::detectable::detectable;
use crate::explain::{hidden, next_ride, show, simulation, windows, words};
use crate::prepare::Prepared;
use crate::search::Search;
use crate::search::null::FINEST;
use crate::search::offered::Offered;
use crate::tried::tried;
use crate::verdict::carries::why_not;
use crate::verdict::effect_report;
use crate::verdict::judge::held_rms;
use veloid_core::bicycle::{Axle, Bike, PerAxle};
use veloid_core::document::format_number::significant;
use veloid_core::numerics::finite::finite;
use veloid_core::settings::Settings;
use veloid_methods::output_error::spread_valid;
use veloid_model::dataset::Dataset;
use veloid_model::fit::{Fitted, Model, Term, motions};
use veloid_report::diagnosis::{Diagnosis, EffectName, EffectReport, SwitchedOff, Verdict};
use veloid_report::identifiable::NO_VERDICT;
use veloid_report::windows::{Rule, Windows};

/// Share of an axle's samples that may be missing without a warning.
const LOST: f64 = 0.1;

/// The diagnosis as it is reported.
pub fn assemble(
    prepared: &Prepared,
    search: &Search,
    decision: &Decision,
    switched_off: Vec<SwitchedOff>,
    bike: &Bike,
    settings: &Settings,
) -> Diagnosis {
    let own;
    let offered = match &decision.offered {
        Some(offered) if offered.is_beside(&decision.model) => offered,
        _ => {
            own = Offered::of(search, &decision.model);
            &own
        }
    };
    let teller = AxleReporter {
        prepared,
        decision,
        plain_motions: &motions(&prepared.dataset, &search.plain),
        alpha: settings.alpha,
        chance: &|track| offered.chance(track, settings.seed),
    };
    let mut axles = PerAxle::default();
    for (t, track) in prepared.dataset.tracks.iter().enumerate() {
        let has_mass = bike.mass(track.axle).is_some();
        axles.set(track.axle, teller.axle(t, has_mass));
    }
    let verdict = decision.verdict;
    let tied = match verdict {
        Verdict::Ambiguous => &decision.tied[..],
        _ => &[],
    };
    let partly = verdict == Verdict::NamedInPart;
    let diagnosis = Diagnosis {
        verdict,
        rule: Some(decision.rule),
        sentence: String::new(),
        base: prepared.base,
        effects: effects(prepared, search, decision, settings),
        rest: partly.then(|| axles.filter_map(|_, on: &OnAxle| on.rest.clone())),
        alternatives: tied
            .iter()
            .map(|model| names(&prepared.dataset, model))
            .collect(),
        extended: axles.filter_map(|_, on| on.extended.clone()),
        model: Some(simulation::simulation(
            prepared.record(),
            &decision.shown,
            &prepared.recorded,
            prepared.split.held.clone(),
        )),
        warnings: warnings(prepared, decision, &axles, settings),
        location: axles.map(|_, on| on.location.clone()),
        held_out: axles.map(|_, on| on.held_out.clone()),
        windows: tables(prepared.record(), decision),
        tried: Vec::new(),
        next_ride: next_ride::propose(search, &decision.model, tied),
        detectable: detectable(search, &decision.model, offered),
        switched_off,
        free_form: axles.filter_map(|_, on| on.free_form.clone()),
        consequences: axles.map(|_, on| on.consequences.clone()),
        evidence: axles.map(|_, on| on.evidence.clone()),
        search_cost: decision.cost,
        validation: PerAxle::default(),
    };
    let diagnosis = match why_not(&diagnosis, &|axle| moves(prepared, axle)) {
        Some((rule, why)) => without_verdict(diagnosis, rule, why),
        None => diagnosis,
    };
    Diagnosis {
        validation: beside::validations(prepared, decision, diagnosis.verdict),
        sentence: words::sentence(&diagnosis) + &hidden::sentence(prepared.record(), &diagnosis),
        tried: tried(prepared, search, decision, diagnosis.verdict),
        ..diagnosis
    }
}

/// The table of each axle of which parts were asked.
fn tables(record: &Dataset, decision: &Decision) -> PerAxle<Windows> {
    let mut found = PerAxle::default();
    for (track, read) in record.tracks.iter().zip(&decision.read) {
        if let Some(read) = read {
            found.set(
                track.axle,
                windows::windows(track.spread(), &read.evidence.scores, &read.judgement),
            );
        }
    }
    found
}

/// The diagnosis of a record that carries no verdict: nothing that pretends otherwise is left in it.
fn without_verdict(diagnosis: Diagnosis, rule: Rule, why: String) -> Diagnosis {
    Diagnosis {
        verdict: Verdict::CannotTell,
        rule: Some(rule),
        sentence: why,
        effects: Vec::new(),
        alternatives: Vec::new(),
        extended: diagnosis
            .extended
            .map(|_, e| e.clone().withheld(NO_VERDICT)),
        model: None,
        next_ride: None,
        detectable: Vec::new(),
        free_form: PerAxle::default(),
        ..diagnosis
    }
}

fn names(dataset: &Dataset, model: &Model) -> Vec<EffectName> {
    let terms = model.terms.iter();
    terms.map(|term| show::name(dataset, term)).collect()
}

/// RMS of what an axle does where nothing was fitted (m), or of the force that answers (N); over the whole of a free decay, whose end has
/// no motion.
fn moves(prepared: &Prepared, axle: Axle) -> f64 {
    let track = prepared.dataset.tracks.iter().find(|t| t.axle == axle);
    track.map_or(0.0, |t| {
        let part = match t.is_driven() {
            true => prepared.split.held.clone(),
            false => 0..t.valid.len(),
        };
        spread_valid(&t.measured, &t.valid, part)
    })
}

/// The model's effects as they are reported.
fn effects(
    prepared: &Prepared,
    search: &Search,
    decision: &Decision,
    settings: &Settings,
) -> Vec<EffectReport> {
    let examined = !decision.claims.is_empty();
    let supported = (decision.claims.iter()).filter_map(|(claim, errors)| {
        show::supported(prepared.record(), &decision.corrected, claim, errors)
    });
    let mut effects: Vec<EffectReport> = match examined {
        true => supported.collect(),
        false => Vec::new(),
    };
    let found: Vec<Term> = (decision.model.terms.iter().copied())
        .filter(|term| !examined || decision.certain.contains(term))
        .collect();
    for (term, mut effect) in tested(prepared, search, decision, &found, settings) {
        effect.affirmed |=
            !examined && decision.verdict == Verdict::Named || decision.certain.contains(&term);
        effects.push(effect);
    }
    effects.sort_by_key(|effect| !effect.affirmed);
    for effect in &mut effects {
        effect.adequate = effect.affirmed || decision.verdict == Verdict::Ambiguous;
    }
    effects
}

/// Effects of `terms` that the search by likelihood found, with what speaks for each.
fn tested(
    prepared: &Prepared,
    search: &Search,
    decision: &Decision,
    terms: &[Term],
    settings: &Settings,
) -> Vec<(Term, EffectReport)> {
    if terms.is_empty() {
        return Vec::new();
    }
    let model = &decision.model;
    let without = search.without_each(model);
    let report = |term: &Term| {
        let less = without.iter().find(|m| !m.terms.contains(term));
        // What came in the place of another was never tested by itself.
        let mut rounds = decision.rounds.iter();
        let round = rounds.find(|r| r.term == *term && r.accepted);
        let p = round.and_then(|r| finite(r.p_value.max(FINEST)));
        let separation = less.map(|less| model.likelihood - less.likelihood);
        let record = prepared.record();
        let mut effect = effect_report::effect(record, &decision.corrected, term, separation, p)?;
        let less = less.unwrap_or(&search.plain);
        effect.material = is_material(prepared, term, model, less, settings.materiality);
        Some((*term, effect))
    };
    terms.iter().filter_map(report).collect()
}

/// Whether the held-out error of an axle that `term` acts on is larger by that share in the model without it.
fn is_material(
    prepared: &Prepared,
    term: &Term,
    model: &Model,
    less: &Model,
    materiality: f64,
) -> bool {
    let record = prepared.record();
    let tracks = 0..record.tracks.len();
    let mut acted = tracks.filter(|t| term.acts_on(record.tracks[*t].axle));
    acted.any(|t| {
        let [with, without] = [model, less].map(|m| held_rms((record, m), t, &prepared.split));
        with < (1.0 - materiality) * without
    })
}

/// What there is to warn of: the recording, what only an expectation shows, each axle, and a wider law.
fn warnings(
    prepared: &Prepared,
    decision: &Decision,
    axles: &PerAxle<OnAxle>,
    settings: &Settings,
) -> Vec<String> {
    let mut warnings = prepared.warnings.clone();
    let record = prepared.record();
    for fit in &decision.shown.fits {
        for (term, name, value, deviation) in effect_report::unlearned(record, fit) {
            warnings.push(format!(
                "{} ({}): {name} is not identifiable beyond the value expected of any bicycle, {value} ± {:.1} (95 %); k, B and \
                 the effect's other parameters depend on it and have no intervals",
                term.id(record),
                term.place.name(),
                1.96 * deviation
            ));
        }
    }
    warnings.extend(
        decision
            .corrected
            .fits
            .iter()
            .filter_map(|fit| twin(record, fit)),
    );
    for track in &record.tracks {
        let lost = track.valid.iter().filter(|v| !**v).count() as f64 / record.samples as f64;
        if lost > LOST {
            warnings.push(format!(
                "{} axle: {:.0} % of the samples are clipped, missing or before the fit",
                track.axle,
                100.0 * lost
            ));
        }
    }
    if let [only] = &record.tracks[..] {
        warnings.push(format!(
            "only the {} axle was recorded with what drives it: effects that need both axles are switched off",
            only.axle
        ));
    }
    warnings.extend(axles.iter().flat_map(|(_, on)| on.warnings.clone()));
    if decision.cost.is_spent {
        warnings.push(format!(
            "the search for missing physics ended after {:.1} million integrator steps, before everything was tried; a larger \
             search_budget (now {} per sample) lets it continue",
            1e-6 * decision.cost.steps as f64,
            settings.search_budget
        ));
    }
    if decision.is_outgrown_a_little {
        let left = "a more general law, which is not in the library, explains the ride better than the named effects; \
                    its additional contribution is small";
        warnings.push(left.to_owned());
    }
    warnings
}

/// That other numbers explain an axle in exactly the same way.
fn twin(record: &Dataset, fit: &Fitted) -> Option<String> {
    let (term, [kappa, beta], values) = effect_report::twin(fit)?;
    let track = fit.unit.tracks.first().map(|t| &record.tracks[*t])?;
    let mass = track.scale.mass;
    let reported = (term.kind.spec().report)(&values, &track.scale);
    let others: Vec<String> = (reported.iter())
        .map(|r| {
            format!(
                "{} {} {}",
                r.name.replace('_', " "),
                significant(r.value, 4),
                r.unit
            )
        })
        .collect();
    Some(format!(
        "{} ({}): k = {} N/m and B = {} N s/m with {} explain the record exactly as well; only knowledge of the bicycle or a \
         sensor on the wheel can decide between the two",
        term.id(record),
        term.place.name(),
        significant(mass * kappa, 4),
        significant(mass * beta, 4),
        others.join(", ").replace(" -,", ",").trim_end_matches(" -")
    ))
}
