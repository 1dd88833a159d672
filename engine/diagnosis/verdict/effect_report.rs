//! An effect as it is reported: its parameters, each with a standard error or the reason why it has none.

use std::borrow::Cow;

use nalgebra::DMatrix;
use veloid_core::numerics::finite::{finite, std_error};
use veloid_model::dataset::Dataset;
use veloid_model::fit::{Fitted, Model, Slot, Term};
use veloid_model::law::{Reported, Scale, Spec, Values};
use veloid_report::diagnosis::{EffectReport, ParameterReport, Place};
use veloid_report::identifiable::identified;

/// One named effect. `separation` is what the model without it lacks in log likelihood, where that could be fitted.
pub fn effect(
    dataset: &Dataset,
    model: &Model,
    term: &Term,
    separation: Option<f64>,
    p_value: Option<f64>,
) -> Option<EffectReport> {
    reported(dataset, model, term, (separation, p_value), &[])
}

/// The same with standard errors of at least `least`.
pub fn reported(
    dataset: &Dataset,
    model: &Model,
    term: &Term,
    (separation, p_value): (Option<f64>, Option<f64>),
    least: &[f64],
) -> Option<EffectReport> {
    let fit = model.fits.iter().find(|f| f.unit.terms.contains(term))?;
    let at = fit.unit.terms.iter().position(|t| t == term)?;
    let scale = fit.unit.scale(dataset, at);
    let unreported: Vec<&str> = unlearned(dataset, fit)
        .filter(|(of, ..)| *of == term)
        .map(|(_, name, ..)| name)
        .collect();
    let parameters = parameters(dataset, fit, at, &unreported, least);
    let named = (term.kind.spec().noun, term.kind.words_on(scale));
    let sentence = sentence(term.place, named, &parameters, &unreported);
    Some(EffectReport {
        id: term.kind.id_on(scale).to_owned(),
        axle: term.place,
        parameters: parameters
            .into_iter()
            .map(|(name, p)| (name.into_owned(), p))
            .collect(),
        p_value,
        separation: separation.and_then(finite).map(|s| s.max(0.0)),
        affirmed: false,
        support: None,
        adequate: true,
        material: true,
        sentence,
    })
}

/// The parameters of the effect `at` of a fit, each with its standard error or the reason why it has none. `unreported`:
/// those that the ride says too little of.
fn parameters(
    dataset: &Dataset,
    fit: &Fitted,
    at: usize,
    unreported: &[&str],
    least: &[f64],
) -> Vec<(Cow<'static, str>, ParameterReport)> {
    let spec = fit.unit.terms[at].kind.spec();
    let scale = fit.unit.scale(dataset, at);
    let values = fit.point.values[at];
    let twin = twin(fit).map(|(_, _, values)| (spec.report)(&values, scale));
    let known = |i: usize, r: &Reported, error: Option<f64>| {
        let error = error.map(|error| least.get(i).map_or(error, |least| error.max(*least)));
        if unreported.contains(&&*r.name) {
            return Err(BEYOND_PRIOR.to_owned());
        }
        if !unreported.is_empty() {
            return Err(RESTS_ON_PRIOR.to_owned());
        }
        let differs = |twin: &Vec<Reported>| (twin[i].value - r.value).abs() > 1e-9 * r.value.abs();
        if twin.as_ref().is_some_and(differs) {
            return Err(HAS_TWIN.to_owned());
        }
        identified(r.value, error, as_good_as_zero(&r.unit), &r.unit)
    };
    let errors = standard_errors(dataset, fit, at, &values, scale);
    (spec.report)(&values, scale)
        .into_iter()
        .zip(errors)
        .enumerate()
        .map(|(i, (r, error))| {
            let error = known(i, &r, error);
            (
                r.name,
                ParameterReport {
                    value: r.value,
                    std_error: error.as_ref().ok().copied(),
                    not_identifiable: error.err(),
                    unit: r.unit.into_owned(),
                },
            )
        })
        .collect()
}

/// An effect with its size and place, as part of a sentence. Where the ride does not determine a parameter, or the law is the
/// user's own, the parameters follow the plain words.
pub fn sentence(
    place: Place,
    (noun, words): (&str, &str),
    parameters: &[(Cow<str>, ParameterReport)],
    unreported: &[&str],
) -> String {
    let place = match place {
        Place::Front => "at the front axle",
        Place::Rear => "at the rear axle",
        Place::Both => "at both axles",
    };
    if !noun.is_empty() && unreported.is_empty() {
        let sized = parameters.iter().fold(noun.to_owned(), |text, (name, p)| {
            text.replace(&format!("{{{name}}}"), &p.quantity(name).to_string())
        });
        return format!("{sized} {place}");
    }
    let listed: Vec<String> = (parameters.iter())
        .map(|(name, p)| {
            let plain = name.replace('_', " ");
            match unreported.contains(&&**name) {
                true => format!("{plain} as expected"),
                false => format!("{plain} {}", p.quantity(name)),
            }
        })
        .collect();
    format!("{place}, {words} ({})", listed.join(", "))
}

/// An angle's zero is a direction as any other: it is reported to within half a radian or not at all.
pub fn as_good_as_zero(unit: &str) -> f64 {
    match unit {
        "rad" => 1.0,
        _ => 0.0,
    }
}

const BEYOND_PRIOR: &str = "not determined beyond the value expected of any bicycle";
pub const HAS_TWIN: &str = "another value, with other values of the remaining parameters, explains the record exactly as well";
pub const RESTS_ON_PRIOR: &str =
    "depends on the expected value of another parameter that this ride does not determine";

/// Parameters of a fit's effects of which the ride says less than what was expected before it: term, name, expected value
/// and its deviation. What the ride says adds to what was expected, so that together they have half its variance
/// where both say as much.
pub fn unlearned<'f>(
    dataset: &Dataset,
    fit: &'f Fitted,
) -> impl Iterator<Item = (&'f Term, &'static str, f64, f64)> {
    let slots = fit.unit.slots(dataset);
    fit.unit
        .terms
        .iter()
        .enumerate()
        .flat_map(move |(i, term)| {
            let spec = term.kind.spec();
            let slots = slots.clone();
            let expected = spec.expected.iter().filter(move |(q, _, deviation)| {
                let slot = slots.iter().position(|s| *s == Slot::Value(i, *q));
                slot.is_none_or(|s| !(fit.covariance[(s, s)] < 0.5 * deviation * deviation))
            });
            expected.map(move |(q, value, deviation)| {
                (term, spec.parameters[*q].name, *value, *deviation)
            })
        })
}

/// Standard errors of the reported parameters.
pub fn standard_errors(
    dataset: &Dataset,
    fit: &Fitted,
    at: usize,
    values: &Values,
    scale: &Scale,
) -> Vec<Option<f64>> {
    let slots = fit.unit.slots(dataset);
    let fitted: Vec<(usize, usize)> = slots
        .iter()
        .enumerate()
        .filter_map(|(i, s)| match s {
            Slot::Value(term, q) if *term == at => Some((i, *q)),
            _ => None,
        })
        .collect();
    let spec = fit.unit.terms[at].kind.spec();
    propagated(spec, (values, scale), &fitted, &fit.covariance)
}

/// Standard errors of what is reported of an effect, by the delta method; `fitted` are its parameters, each with its place in the covariance.
pub fn propagated(
    spec: &Spec,
    (values, scale): (&Values, &Scale),
    fitted: &[(usize, usize)],
    covariance: &DMatrix<f64>,
) -> Vec<Option<f64>> {
    let base = (spec.report)(values, scale);
    let derivatives: Vec<Vec<f64>> = fitted
        .iter()
        .map(|(_, q)| {
            let step = 1e-6
                * (spec.parameters[*q].size)(scale)
                    .abs()
                    .max(values[*q].abs());
            let mut moved = *values;
            moved[*q] += step;
            (spec.report)(&moved, scale)
                .iter()
                .zip(&base)
                .map(|(a, b)| (a.value - b.value) / step)
                .collect()
        })
        .collect();
    (0..base.len())
        .map(|r| {
            let mut variance = 0.0;
            for (a, (i, _)) in fitted.iter().enumerate() {
                for (b, (j, _)) in fitted.iter().enumerate() {
                    let (x, y) = (derivatives[a][r], derivatives[b][r]);
                    if x != 0.0 && y != 0.0 {
                        variance += x * y * covariance[(*i, *j)];
                    }
                }
            }
            std_error(variance)
        })
        .collect()
}

/// What moves the axle of a fit in the same way: the effect that has such a twin, k/m and B/m, and its values.
pub fn twin(fit: &Fitted) -> Option<(&Term, [f64; 2], Values)> {
    let ([term], [values], [base]) = (
        &fit.unit.terms[..],
        &fit.point.values[..],
        &fit.point.base[..],
    ) else {
        return None;
    };
    let (other, values) = (term.kind.spec().twin?)([base.kappa, base.beta], values);
    Some((term, other, values))
}
