//! The verdict as a report.

use std::collections::BTreeMap;

use super::fit::Fit;
use super::judged::Judged;
use super::model::{Model, Slot, axle_of};
use super::roles::{Role, is_linear, role};
use super::search::Scored;
use super::shown::Shown;
use crate::explain::windows::windows;
use crate::explain::words;
use crate::policy;
use crate::tried::in_order;
use crate::verdict::effect_report::{as_good_as_zero, propagated, sentence};
use nalgebra::DMatrix;
use veloid_core::bicycle::{Axle, PerAxle};
use veloid_core::document::format_number::significant;
use veloid_core::numerics::finite::finite;
use veloid_model::effects::{ALL, Kind};
use veloid_model::fit::Term;
use veloid_model::law::{Family, Values};
use veloid_report::Estimate;
use veloid_report::diagnosis::{
    Detectable, Diagnosis, EffectName, EffectReport, Location, ParameterReport, Place, SwitchedOff,
    Verdict,
};
use veloid_report::identifiable::identified;
use veloid_report::tried::{Tried, TriedEffect};

pub fn report(judged: &Judged) -> Diagnosis {
    let masses = judged.scales.map(|_, scale| scale.mass);
    let mut held_out = PerAxle::default();
    let mut evidence = PerAxle::default();
    let mut spread = 0.0;
    for shown in judged.views().map(|view| Shown::of(&view, &masses)) {
        if shown.axle == judged.record.other() {
            spread = shown.spread;
        }
        held_out.set(shown.axle, shown.held_out);
        evidence.set(shown.axle, shown.evidence);
    }
    let best = judged.best;
    let affirmed = judged.verdict == Verdict::Named;
    let mut effects: Vec<EffectReport> = (0..best.model.effects.len())
        .filter(|i| !best.model.effects[*i].0.kind.spec().is_general)
        .filter_map(|i| effect(judged, best, i, affirmed))
        .collect();
    effects.extend(delay(judged));
    let mut location = PerAxle::default();
    if judged.verdict == Verdict::Unnamed {
        // The axle shows, where a name does not.
        for (term, _) in &best.model.effects {
            let mismatch = Location {
                mismatch: true,
                ..Location::default()
            };
            location.set(axle_of(term), mismatch);
        }
    }
    let diagnosis = Diagnosis {
        verdict: judged.verdict,
        rule: Some(judged.judgement.rule),
        effects,
        alternatives: (judged.tied.iter())
            .map(|terms| terms.iter().map(name).collect())
            .filter(|_| judged.verdict == Verdict::Ambiguous)
            .collect(),
        extended: extended(judged, best),
        warnings: warnings(judged),
        location,
        held_out,
        windows: on(
            judged.record.other(),
            windows(spread, &judged.evidence.scores, judged.judgement),
        ),
        tried: tried(judged, spread),
        detectable: detectable(judged),
        switched_off: switched_off(judged),
        evidence,
        ..Diagnosis::without_verdict(String::new())
    };
    Diagnosis {
        sentence: words::sentence(&diagnosis),
        ..diagnosis
    }
}

/// Every set of effects that was fitted; `spread` is the standard deviation (m/s^2) of what is predicted.
fn tried(judged: &Judged, spread: f64) -> Vec<Tried> {
    let evidence = judged.evidence;
    let plain = evidence.cost(&[]);
    let of = |(s, fit): (usize, &Fit)| {
        let effects = (0..fit.model.effects.len()).filter_map(|i| effect(judged, fit, i, false));
        let effects: Vec<TriedEffect> = effects
            .map(|e| TriedEffect {
                id: e.id,
                axle: e.axle,
                parameters: e.parameters,
            })
            .collect();
        let set = &evidence.scores.sets[s];
        let gain = plain.and_then(|plain| finite(plain - evidence.charged[s]));
        let rms = finite(spread * set.mean(0).sqrt());
        Tried {
            effects,
            parameters: set.parameters,
            gain,
            held_out_rms_m: rms.map_or_else(PerAxle::default, |rms| on(judged.record.other(), rms)),
            why_not: why_not(judged, s, gain),
        }
    };
    let fits = evidence.fits.iter().enumerate();
    let all = fits
        .filter(|(_, fit)| !fit.model.effects.is_empty())
        .map(of);
    in_order(all.collect(), None)
}

/// Why a set of effects is not the answer, by what it gains beyond what its parameters cost.
fn why_not(judged: &Judged, s: usize, gain: Option<f64>) -> Option<String> {
    let terms = judged.evidence.fits[s].model.terms();
    let best = judged.best.model.terms();
    let gained = significant(gain.unwrap_or(0.0), 3);
    let named = |terms: &[Term]| -> String {
        let names: Vec<String> = terms
            .iter()
            .map(|t| t.kind.id().replace('_', " "))
            .collect();
        names.join(" with ")
    };
    let is_best = terms == best;
    Some(match judged.verdict {
        Verdict::Named if is_best => return None,
        Verdict::Ambiguous if is_best => "other sets explain the ride as well".to_owned(),
        Verdict::Ambiguous if judged.tied.contains(&terms) => {
            format!("explains the ride as well as {}", named(&best))
        }
        _ if !judged.evidence.scores.sets[s].is_physical => {
            "a value lies outside its physical range".to_owned()
        }
        Verdict::NothingMissing => {
            format!("gains {gained} in log likelihood beyond what its parameters cost, too little")
        }
        Verdict::Unnamed if is_best => "leaves more than noise, or may be another law".to_owned(),
        _ => format!(
            "gains {gained} in log likelihood, no more than {}",
            named(&best)
        ),
    })
}

fn on<T>(axle: Axle, value: T) -> PerAxle<T> {
    let mut found = PerAxle::default();
    found.set(axle, value);
    found
}

fn name(term: &Term) -> EffectName {
    EffectName {
        id: term.kind.id().to_owned(),
        axle: term.place,
    }
}

/// Where the values of effect `i` are in the covariance, and that in their units.
fn own_covariance(judged: &Judged, fit: &Fit, i: usize) -> (Vec<(usize, usize)>, DMatrix<f64>) {
    let (term, _) = &fit.model.effects[i];
    let scale = judged.scales.get(axle_of(term));
    let slots = fit.model.slots();
    let size = |slot: &Slot| match (slot, scale) {
        (Slot::Value(of, q), Some(scale)) if *of == i => {
            (term.kind.spec().parameters[*q].size)(scale)
        }
        _ => 1.0,
    };
    let sizes: Vec<f64> = slots.iter().map(size).collect();
    let fitted = slots
        .iter()
        .enumerate()
        .filter_map(|(at, slot)| match slot {
            Slot::Value(of, q) if *of == i => Some((at, *q)),
            _ => None,
        });
    let covariance = DMatrix::from_fn(slots.len(), slots.len(), |a, b| {
        let known = fit.covariance.get((a, b)).copied().unwrap_or(f64::INFINITY);
        known * sizes[a] * sizes[b]
    });
    (fitted.collect(), covariance)
}

fn effect(judged: &Judged, fit: &Fit, i: usize, affirmed: bool) -> Option<EffectReport> {
    let (term, values) = &fit.model.effects[i];
    let scale = judged.scales.get(axle_of(term))?;
    let spec = term.kind.spec();
    let (fitted, covariance) = own_covariance(judged, fit, i);
    let rate_hz = judged.record.rate_hz;
    let errors = propagated(spec, (values, scale), &fitted, &covariance);
    let parameters: Vec<_> = (spec.report)(values, scale)
        .into_iter()
        .zip(errors)
        .map(|(r, error)| {
            let error = error.map(|error| {
                error.hypot(unseen(rate_hz, term.kind, values, scale.w_rms) * r.value)
            });
            let error = identified(r.value, error, as_good_as_zero(&r.unit), &r.unit);
            let parameter = ParameterReport {
                value: r.value,
                std_error: error.as_ref().ok().copied(),
                not_identifiable: error.err(),
                unit: r.unit.into_owned(),
            };
            (r.name, parameter)
        })
        .collect();
    let support = (judged.evidence.terms.iter().position(|t| t == term))
        .map(|e| judged.judgement.support(&judged.evidence.scores, e));
    Some(EffectReport {
        id: term.kind.id().to_owned(),
        axle: term.place,
        sentence: sentence(term.place, (spec.noun, spec.words), &parameters, &[]),
        parameters: parameters
            .into_iter()
            .map(|(name, p)| (name.into_owned(), p))
            .collect(),
        p_value: None,
        separation: None,
        affirmed,
        support,
        adequate: affirmed,
        material: true,
    })
}

/// Share by which a damper's size is unsure: road above the logger's band shakes it unseen. Of friction, whose sign that rounds off,
/// also the shape is not known.
fn unseen(rate_hz: f64, kind: Kind, values: &Values, w_rms: f64) -> f64 {
    let rounded = match kind {
        Kind::CoulombFriction => policy::ROUNDED_OFF * (values[1] / (0.1 * w_rms)).min(1.0),
        _ => 0.0,
    };
    match kind.spec().family {
        Some(Family::Damper) => rounded.hypot(policy::SHAKEN * beyond(rate_hz)),
        _ => 0.0,
    }
}

/// How much of the road is beyond the logger's band, beside one of 100 Hz.
fn beyond(rate_hz: f64) -> f64 {
    (100.0 / rate_hz).min(1.0)
}

/// Damping (1/s) of the effects' dampers on an axle at its RMS rate.
fn equivalent(judged: &Judged, fit: &Fit, axle: Axle) -> f64 {
    let Some(scale) = judged.scales.get(axle) else {
        return 0.0;
    };
    let own = |(term, values): &&(Term, Values)| {
        axle_of(term) == axle && term.kind.spec().family == Some(Family::Damper) && values[0] != 0.0
    };
    let of = |(term, values): &(Term, Values)| match term.kind {
        // Where it sticks, what shakes it loose counts twice.
        Kind::CoulombFriction => 2.0 * values[0] / scale.w_rms,
        Kind::QuadraticDamping => 1.6 * values[0] * scale.w_rms,
        _ => scale.b,
    };
    fit.model.effects.iter().filter(own).map(of).sum::<f64>() / scale.mass
}

/// The delay of a sensor, as an effect.
fn delay(judged: &Judged) -> Option<EffectReport> {
    let late = judged.late?;
    let spec = Kind::SensorDelay.spec();
    let parameter = ParameterReport {
        value: late.delay_s,
        std_error: finite(late.std_error_s),
        not_identifiable: None,
        unit: "s".to_owned(),
    };
    let name = spec.parameters.first().map_or("delay", |p| p.name);
    let place = Place::from(late.axle);
    let named = [(name.into(), parameter.clone())];
    Some(EffectReport {
        id: spec.id.to_owned(),
        axle: place,
        sentence: sentence(place, (spec.noun, spec.words), &named, &[]),
        parameters: BTreeMap::from([(name.to_owned(), parameter)]),
        p_value: None,
        separation: None,
        affirmed: judged.verdict == Verdict::Named,
        support: None,
        adequate: judged.verdict == Verdict::Named,
        material: true,
    })
}

/// k and B of both axles with the effects.
fn extended(judged: &Judged, fit: &Fit) -> PerAxle<Estimate> {
    let mut found = PerAxle::default();
    let doubt = doubted(judged);
    for axle in Axle::BOTH {
        let Some(mass_kg) = judged.bike.mass(axle) else {
            continue;
        };
        let value = |q: usize| mass_kg * fit.model.base(axle)[q].exp();
        let slot = |q| {
            fit.model
                .slots()
                .iter()
                .position(|s| *s == Slot::Base(axle, q))
        };
        let error = |q: usize| {
            let at = slot(q)?;
            let of_fit = policy::SCATTER * value(q) * fit.covariance.get((at, at))?.max(0.0).sqrt();
            let shaken = match q {
                0 => 0.0,
                _ => {
                    policy::SHAKEN
                        * beyond(judged.record.rate_hz)
                        * mass_kg
                        * equivalent(judged, fit, axle)
                }
            };
            let others =
                (policy::LAW_ERRORS[q] * beside(&fit.model, axle)).hypot(of_ties(judged, axle, q));
            finite(of_fit.hypot(others * value(q)).hypot(shaken))
        };
        let by = [[value(0), 0.0], [0.0, value(1)], [0.0; 2]];
        let covariance = slot(0).zip(slot(1)).and_then(|(k, b)| {
            let at = [k, b];
            let of_fit = |p: usize, q: usize| fit.covariance.get((at[p], at[q])).copied();
            Estimate::propagated(by, |p, q| of_fit(p, q).unwrap_or(f64::NAN))
        });
        let estimate = Estimate {
            k_n_m: value(0),
            b_n_s_m: value(1),
            covariance,
            k_std_n_m: error(0),
            b_std_n_s_m: error(1),
            mass_kg,
            ..Estimate::default()
        };
        let reported = estimate
            .within_reach(1.0 / judged.record.rate_hz)
            .reportable();
        let reported = match &doubt {
            Some(why) => reported.withheld(why),
            None => reported,
        };
        if reported.is_finite() {
            found.set(axle, reported);
        }
    }
    found
}

/// Why k and B are not known where nothing is named.
fn doubted(judged: &Judged) -> Option<String> {
    let undetected = judged.found.best.model.terms();
    let term = (judged.found.doubt).or(undetected.into_iter().find(|t| is_linear(t.kind)))?;
    let (id, axle) = (term.kind.id().replace('_', " "), axle_of(&term));
    (judged.verdict == Verdict::NothingMissing).then(|| {
        format!(
            "without a road plain axles are hardly distinguished here from a {id} at the {axle} axle, with which k and B are others: \
             measure the road, or the travel of the {axle} suspension or tyre"
        )
    })
}

/// Times the errors of k and B that stand whatever the fit says.
fn beside(model: &Model, axle: Axle) -> f64 {
    let acts = |(term, _): &(Term, Values)| term.acts_on(axle);
    match model.effects.is_empty() {
        true => 1.0,
        false if model.effects.iter().any(acts) => policy::BESIDE_EFFECT,
        false => policy::BESIDE_OTHER,
    }
}

/// How far a number of an axle's (k/m, B/m, in logarithms) is from the same where another set of effects explains the ride as well.
fn of_ties(judged: &Judged, axle: Axle, q: usize) -> f64 {
    let own = judged.best.model.base(axle)[q];
    let fits = judged.evidence.fits.iter();
    let tied = fits.filter(|fit| judged.tied.contains(&fit.model.terms()));
    let off = tied.map(|fit| (fit.model.base(axle)[q] - own).abs());
    off.fold(0.0, f64::max)
}

fn warnings(judged: &Judged) -> Vec<String> {
    let mut said = vec![
        "The road was not measured: what both wheels do alike to it, a relaxing tyre above all, is absorbed and not shown.".to_owned(),
    ];
    if judged.late.is_some() {
        said.push("A delay shows only of one accelerometer against the other.".to_owned());
    }
    said
}

/// The smallest size of each effect that this ride would have shown beside what it has.
fn detectable(judged: &Judged) -> Vec<Detectable> {
    let one = |scored: &Scored| {
        let term = scored.term;
        let spec = term.kind.spec();
        let scale = judged.scales.get(axle_of(&term))?;
        let mut values = scored.unit;
        for a in spec.amplitudes {
            values[*a] *= policy::DETECTED.sqrt();
        }
        let reported = (spec.report)(&values, scale)
            .into_iter()
            .nth(spec.size_parameter)?;
        let absorbed = is_linear(term.kind);
        Some(Detectable {
            id: spec.id.to_owned(),
            axle: term.place,
            parameter: reported.name.into_owned(),
            smallest_detectable: finite(reported.value.abs()).filter(|_| !absorbed),
            stronger: spec.stronger,
            reason: absorbed.then(|| {
                "the road is unknown: most of it passes for another k and B of the axle".to_owned()
            }),
            unit: reported.unit.into_owned(),
        })
    };
    let mut traces: Vec<&Scored> = (judged.found.traces.iter())
        .filter(|s| !s.term.kind.spec().is_general)
        .collect();
    traces.sort_by_key(|s| s.term);
    traces.into_iter().filter_map(one).collect()
}

/// Effects that no ride without a road shows.
fn switched_off(judged: &Judged) -> Vec<SwitchedOff> {
    let looked_for = |kind: Kind| judged.candidates.iter().any(|t| t.kind == kind);
    let why = |kind: &Kind| match role(*kind) {
        Role::Not(why) => Some(why),
        Role::LookedFor if !looked_for(*kind) => match kind {
            Kind::PedallingForce => Some("no cadence channel, or no pedalling"),
            _ => Some("no wheel radius in the bike file"),
        },
        _ => None,
    };
    let named = ALL.iter().filter(|kind| !kind.spec().is_general);
    named
        .filter_map(|kind| {
            Some(SwitchedOff {
                id: kind.id().to_owned(),
                why: why(kind)?.to_owned(),
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use veloid_model::law::padded;

    /// A rate of 0.1 m/s RMS, over a tenth of which the sign changes.
    #[test]
    fn dampers_are_unsure_by_what_shakes_them_unseen() {
        let share = |kind, rate_hz, width| unseen(rate_hz, kind, &padded([30.0, width]), 0.1);
        assert_eq!(share(Kind::QuadraticDamping, 100.0, 0.0), policy::SHAKEN);
        assert_eq!(
            share(Kind::QuadraticDamping, 200.0, 0.0),
            0.5 * policy::SHAKEN
        );
        assert_eq!(share(Kind::CubicStiffness, 100.0, 0.0), 0.0);
        let rounded = policy::ROUNDED_OFF.hypot(policy::SHAKEN);
        assert!((share(Kind::CoulombFriction, 100.0, 0.01) - rounded).abs() < 1e-12);
        assert!((share(Kind::CoulombFriction, 100.0, 0.1) - rounded).abs() < 1e-12);
    }

    #[test]
    fn k_and_b_are_no_surer_than_filters_and_patches_let_them_be() {
        let [k, b] = policy::LAW_ERRORS;
        assert!(k < b && k > 1e-3 && policy::SCATTER >= 1.0);
        let plain = Model::new([8.0, 3.0], [7.0, 2.0]);
        let term = Term {
            kind: Kind::CubicStiffness,
            place: Place::Rear,
        };
        let model = plain.with(term, padded([1e9]));
        let of = Axle::BOTH.map(|axle| beside(&model, axle));
        assert_eq!(of, [policy::BESIDE_OTHER, policy::BESIDE_EFFECT]);
        assert_eq!(beside(&plain, Axle::Rear), 1.0);
    }
}
