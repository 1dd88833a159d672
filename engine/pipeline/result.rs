//! The one answer per axle and quantity.

use crate::bicycle::{Axle, PerAxle};
use crate::document::format_number::WIDE;
use crate::plant::{Axle as AxlePlant, Of, Plant, Quantity};
use crate::report::diagnosis::{Base, Verdict};
use crate::report::{AxleResult, Estimate, LatentRoad, Method, Report, ResultQuantity};
use crate::ride::Ride;
use crate::uncertainty::identifiable::NO_VERDICT;
use crate::uncertainty::laser::misleading;

/// Why a mass has no standard error.
const GIVEN: &str = "given in the bike file";
/// Why a quantity has no value where no method says more.
const NO_ESTIMATE: &str = "no method determined it from this record";
/// Why there is no interval where something without a name acts.
const UNNAMED: &str = "an effect missing from the model acts on this axle, and an interval would not include its influence";

/// The result of every axle that the ride records.
pub fn result(ride: &Ride, report: &Report) -> PerAxle<AxleResult> {
    let mut found = PerAxle::default();
    for axle in Axle::BOTH {
        let record = ride.axles.get(axle);
        let sensed = ride.sensors.iter().any(|sensor| sensor.axle == axle);
        if record.is_some() || sensed {
            let plant = record.map_or(&AxlePlant::MOVING as &dyn Plant, |r| r.base_model());
            found.set(axle, of_axle(report, axle, plant));
        }
    }
    found
}

/// The result that a stored report contains, or, of a report that an earlier version stored without one, what its
/// methods give.
pub fn result_of(report: &Report) -> PerAxle<AxleResult> {
    if report.result.iter().next().is_some() {
        return report.result.clone();
    }
    let estimates = report.estimates(best_method(report));
    estimates.filter_map(|axle, estimate| {
        let plant: &dyn Plant = match estimate.mass_kg > 0.0 {
            true => &AxlePlant::MOVING,
            false => &AxlePlant::DRIVEN,
        };
        Some(of_axle(report, axle, plant))
    })
}

/// The road's own method where no other has an estimate or the recorded road misleads; else the model with the effects that
/// the verdict names, or output error.
pub fn best_method(report: &Report) -> Method {
    let names = |verdict| {
        matches!(
            verdict,
            Verdict::Named | Verdict::NamedInPart | Verdict::Ambiguous
        )
    };
    if without_road(report).is_some() {
        return Method::LatentRoad;
    }
    match &report.diagnosis {
        Some(d) if names(d.verdict) && !d.effects.is_empty() => Method::Extended,
        _ => Method::OutputError,
    }
}

/// What identifies the ride without a road, where nothing else does or the recorded road misleads.
fn without_road(report: &Report) -> Option<&LatentRoad> {
    let misleads = || {
        misleading(
            &report.ride.clocks,
            &report.output_error,
            &report.laser_error,
        )
    };
    (report.latent_road.as_ref())
        .filter(|found| report.has_no_road() || found.reason.is_none() && misleads().is_some())
}

fn of_axle(report: &Report, axle: Axle, plant: &dyn Plant) -> AxleResult {
    let method = best_method(report);
    let found = report.estimates(method).get(axle).cloned();
    let withheld = withheld(report, method);
    let base = report.diagnosis.as_ref().map(|diagnosis| diagnosis.base);
    let unexplained = method == Method::OutputError && unnamed_on(report, axle);
    let one = |quantity: &Quantity| {
        let reported = match (&found, &withheld) {
            (Some(estimate), None) => estimated(quantity, estimate, method, unexplained),
            (Some(e), Some(_)) if quantity.of == Of::Mass && e.mass_std_kg.is_none() => {
                estimated(quantity, e, method, unexplained)
            }
            (None, Some(_)) if given(report, axle, quantity).is_some() => ResultQuantity {
                value: given(report, axle, quantity),
                ..without_value(quantity, method, GIVEN)
            },
            (_, Some(why)) => without_value(quantity, method, why),
            (None, None) => without_value(quantity, method, NO_ESTIMATE),
        };
        (quantity.name.to_owned(), reported)
    };
    quantities(plant, base).iter().map(one).collect()
}

/// What is reported of a base model, of one without its spring where the diagnosis builds on none.
fn quantities(plant: &dyn Plant, base: Option<Base>) -> &'static [Quantity] {
    match base {
        Some(Base::Damper) => plant.without_spring().unwrap_or(plant).quantities(),
        Some(Base::SpringAndDamper) | None => plant.quantities(),
    }
}

/// The mass that the bike file gives.
fn given(report: &Report, axle: Axle, quantity: &Quantity) -> Option<f64> {
    report.bike.mass(axle).filter(|_| quantity.of == Of::Mass)
}

/// Why nothing is reported of the ride.
fn withheld(report: &Report, method: Method) -> Option<String> {
    if method == Method::LatentRoad {
        return report.latent_road.as_ref().and_then(|l| l.reason.clone());
    }
    let verdict = report.diagnosis.as_ref().map(|d| d.verdict);
    (verdict == Some(Verdict::CannotTell)).then(|| NO_VERDICT.to_owned())
}

/// Whether something without a name acts on the axle.
fn unnamed_on(report: &Report, axle: Axle) -> bool {
    report.diagnosis.as_ref().is_some_and(|d| {
        let mismatch = d.location.get(axle).is_some_and(|place| place.mismatch);
        d.verdict == Verdict::Unnamed && mismatch
    })
}

fn estimated(
    quantity: &Quantity,
    e: &Estimate,
    method: Method,
    unexplained: bool,
) -> ResultQuantity {
    let (value, std_error, why) = match quantity.of {
        Of::Stiffness => (e.k_n_m, e.k_std_n_m, &e.k_not_identifiable),
        Of::Damping => (e.b_n_s_m, e.b_std_n_s_m, &e.b_not_identifiable),
        Of::Mass if e.mass_std_kg.is_none() => {
            return ResultQuantity {
                value: Some(e.mass_kg),
                ..without_value(quantity, method, GIVEN)
            };
        }
        Of::Mass => (e.mass_kg, e.mass_std_kg, &None),
    };
    match std_error {
        None => without_value(quantity, method, why.as_deref().unwrap_or(NO_ESTIMATE)),
        Some(_) if unexplained => ResultQuantity {
            value: Some(value),
            ..without_value(quantity, method, UNNAMED)
        },
        Some(error) => ResultQuantity {
            value: Some(value),
            std_error: Some(error),
            interval: Some([value - WIDE * error, value + WIDE * error]),
            unit: quantity.unit.to_owned(),
            method,
            why: None,
        },
    }
}

fn without_value(quantity: &Quantity, method: Method, why: &str) -> ResultQuantity {
    ResultQuantity {
        value: None,
        std_error: None,
        interval: None,
        unit: quantity.unit.to_owned(),
        method,
        why: Some(why.to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_interval_is_1_96_standard_errors_wide_and_what_has_none_has_its_reason() {
        let estimate = Estimate {
            k_n_m: 60e3,
            k_std_n_m: Some(100.0),
            b_n_s_m: 500.0,
            b_not_identifiable: Some("it is noise".to_owned()),
            mass_kg: 23.0,
            ..Estimate::default()
        };
        let of = |unexplained| -> Vec<ResultQuantity> {
            let quantities = AxlePlant::MOVING.quantities().iter();
            quantities
                .map(|q| estimated(q, &estimate, Method::OutputError, unexplained))
                .collect()
        };
        let [k, b, mass] = &of(false)[..] else {
            panic!("{:?}", of(false));
        };
        assert_eq!(k.interval, Some([60e3 - 196.0, 60e3 + 196.0]));
        assert_eq!((k.unit.as_str(), &k.why), ("N/m", &None));
        assert_eq!((b.value, b.why.as_deref()), (None, Some("it is noise")));
        assert_eq!((mass.value, mass.why.as_deref()), (Some(23.0), Some(GIVEN)));

        let k = &of(true)[0];
        assert_eq!((k.value, k.std_error), (Some(60e3), None));
        assert_eq!(k.why.as_deref(), Some(UNNAMED));
    }

    #[test]
    fn a_base_without_a_spring_has_no_stiffness() {
        let names = |base| -> Vec<&str> {
            let quantities = quantities(&AxlePlant::MOVING, base).iter();
            quantities.map(|q| q.name).collect()
        };
        assert_eq!(names(Some(Base::Damper)), ["B", "mass"]);
        for sprung in [None, Some(Base::SpringAndDamper)] {
            assert_eq!(names(sprung), ["k", "B", "mass"]);
        }
    }
}
