//! Numbers of the model beside those of the same model fitted to the ride.

use std::borrow::Cow;

use veloid_core::bicycle::Axle;
use veloid_core::numerics::statistics::normal_tail;
use veloid_model::dataset::Dataset;
use veloid_model::fit::estimate::estimate;
use veloid_model::fit::{Model, Term};
use veloid_model::law::Reported;
use veloid_report::IdentifiedModel;
use veloid_report::diagnosis::{EffectReport, Place};
use veloid_report::model_on_ride::ParameterOnRide;

use crate::verdict::effect_report::standard_errors;

/// Standard error on the ride, as a share of the larger value, beyond which the ride says nothing of a number.
const MOST: f64 = 0.5;

/// A number with its standard error.
type Known = (f64, Option<f64>);

/// Every number of an axle, in the model as it was simulated (`carried`) and on the ride (`refitted`), each a track of its dataset.
pub fn parameters(
    document: &IdentifiedModel,
    dataset: &Dataset,
    [carried, refitted]: [&Model; 2],
    track: usize,
    alpha: f64,
) -> Vec<ParameterOnRide> {
    let axle = dataset.tracks[track].axle;
    let mut found = base(document, dataset, [carried, refitted], track);
    for term in refitted.terms.iter().filter(|term| term.acts_on(axle)) {
        let [model, ride] = [carried, refitted].map(|model| values(dataset, model, term));
        let known = reported(document, term.id(dataset), axle);
        for (model, ride) in model.iter().zip(ride) {
            let error = known.and_then(|e| e.parameters.get(&*model.name)?.std_error);
            let name = format!("{}.{}", term.id(dataset), model.name);
            let model = (model.value, error);
            found.push(compared(&name, &ride.unit, model, (ride.value, ride.error)));
        }
    }
    judge(&mut found, alpha);
    found
}

fn base(
    document: &IdentifiedModel,
    dataset: &Dataset,
    [carried, refitted]: [&Model; 2],
    track: usize,
) -> Vec<ParameterOnRide> {
    let result = document.result.get(dataset.tracks[track].axle);
    let error = |name: &str| result.and_then(|result| result.get(name)?.std_error);
    let [model, ride] = [carried, refitted].map(|model| estimate(dataset, model, track));
    let mut found = Vec::new();
    if dataset.tracks[track].plant.has_spring() {
        let ride = (ride.k_n_m, ride.k_std_n_m);
        found.push(compared("k", "N/m", (model.k_n_m, error("k")), ride));
    }
    let ride = (ride.b_n_s_m, ride.b_std_n_s_m);
    found.push(compared("B", "N s/m", (model.b_n_s_m, error("B")), ride));
    found
}

/// A parameter of an effect as reports name it.
struct Value {
    name: Cow<'static, str>,
    unit: Cow<'static, str>,
    value: f64,
    error: Option<f64>,
}

fn values(dataset: &Dataset, model: &Model, term: &Term) -> Vec<Value> {
    let fit = model.fits.iter().find(|fit| fit.unit.terms.contains(term));
    let at = fit.and_then(|fit| fit.unit.terms.iter().position(|t| t == term));
    let Some((fit, at)) = fit.zip(at) else {
        return Vec::new();
    };
    let (scale, values) = (fit.unit.scale(dataset, at), &fit.point.values[at]);
    let errors = standard_errors(dataset, fit, at, values, scale);
    let reported = (term.kind.spec().report)(values, scale);
    let value = |(r, error): (Reported, Option<f64>)| Value {
        name: r.name,
        unit: r.unit,
        value: r.value,
        error,
    };
    reported.into_iter().zip(errors).map(value).collect()
}

/// The effect as the document reports it, with its standard errors.
fn reported<'d>(document: &'d IdentifiedModel, id: &str, axle: Axle) -> Option<&'d EffectReport> {
    let of_axle = [Place::Both, Place::from(axle)];
    let mut effects = document.effects.iter();
    effects.find(|e| e.id == id && of_axle.contains(&e.axle))
}

fn compared(name: &str, unit: &str, model: Known, ride: Known) -> ParameterOnRide {
    let size = model.0.abs().max(ride.0.abs());
    let ride_std_error = ride.1.filter(|error| *error <= MOST * size);
    let error = model.1.zip(ride_std_error).map(|(a, b)| a.hypot(b));
    let difference = error.filter(|e| *e > 0.0).map(|e| (ride.0 - model.0) / e);
    ParameterOnRide {
        name: name.to_owned(),
        unit: unit.to_owned(),
        model: model.0,
        model_std_error: model.1,
        ride: ride.0,
        ride_std_error,
        difference_in_errors: difference,
        differs: None,
    }
}

/// Says which numbers differ by more than chance does in one of so many comparisons, `alpha` for all together.
fn judge(parameters: &mut [ParameterOnRide], alpha: f64) {
    let count = (parameters.iter())
        .filter(|p| p.difference_in_errors.is_some())
        .count();
    for parameter in parameters {
        let chance = |z: f64| 2.0 * normal_tail(z.abs());
        let differs = |z: f64| chance(z) < alpha / count.max(1) as f64;
        parameter.differs = parameter.difference_in_errors.map(differs);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_differ_beyond_chance_among_so_many() {
        let at = |z: f64| compared("k", "N/m", (100.0, Some(3.0)), (100.0 + 5.0 * z, Some(4.0)));
        // One comparison at 1 % allows 2.58 standard errors, four allow 3.02.
        for (count, most) in [(1, 2.576), (4, 3.023)] {
            let mut all = vec![at(0.0); count];
            for (z, differs) in [
                (most - 0.01, false),
                (most + 0.01, true),
                (-most - 0.01, true),
            ] {
                all[0] = at(z);
                judge(&mut all, 0.01);
                assert_eq!(all[0].differs, Some(differs), "{z} of {count}");
            }
        }
        let mut unknown = [compared("k", "N/m", (100.0, None), (120.0, Some(4.0)))];
        judge(&mut unknown, 0.01);
        assert_eq!(unknown[0].differs, None);
    }

    #[test]
    fn a_ride_that_determines_no_number_is_not_compared() {
        let error =
            |share: f64| compared("k", "N/m", (100.0, Some(1.0)), (2.0, Some(100.0 * share)));
        assert!(error(0.99 * MOST).difference_in_errors.is_some());
        let unknown = error(1.01 * MOST);
        assert_eq!(
            (unknown.ride_std_error, unknown.difference_in_errors),
            (None, None)
        );
    }
}
