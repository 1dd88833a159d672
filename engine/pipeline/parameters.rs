//! The quantities that each axle's base model names, by the method that says most of the ride.

use std::collections::BTreeMap;

use crate::bicycle::Axle;
use crate::document::format_number::WIDE;
use crate::plant::{Of, Plant, PlantRef, Quantity};
use crate::report::diagnosis::Base;
use crate::report::{Estimate, Method, Report, ReportedParameter};
use crate::ride::{AxleRecord, Ride};

/// Why a mass has no standard error.
const WEIGHED: &str = "it is the bike file's";
/// Why a stiffness or a damping has none, where no method says more.
const UNSAID: &str = "the method gives it no standard error";

/// The parameters of a report, by `<axle>.<quantity>`.
pub fn parameters(ride: &Ride, report: &Report) -> BTreeMap<String, ReportedParameter> {
    let mut found = BTreeMap::new();
    for axle in Axle::BOTH {
        let of = |method: Method| Some((method, report.estimates(method).get(axle)?.clone()));
        let Some((method, estimate)) = Method::ALL.into_iter().find_map(of) else {
            continue;
        };
        let base = report.diagnosis.as_ref().map(|diagnosis| diagnosis.base);
        let plant = base_model(ride.axles.get(axle), base);
        for quantity in plant.quantities() {
            let key = format!("{axle}.{}", quantity.name);
            found.insert(key, reported(quantity, &estimate, method));
        }
    }
    found
}

/// The base model of an axle, without its spring where the diagnosis builds on none.
fn base_model(record: Option<&AxleRecord>, base: Option<Base>) -> &'static dyn Plant {
    let plant = record.map_or(PlantRef::default().0, AxleRecord::base_model);
    match base {
        Some(Base::Damper) => plant.without_spring().unwrap_or(plant),
        Some(Base::SpringAndDamper) | None => plant,
    }
}

fn reported(quantity: &Quantity, e: &Estimate, method: Method) -> ReportedParameter {
    let (value, std_error, why) = match quantity.of {
        Of::Stiffness => (e.k_n_m, e.k_std_n_m, e.k_not_identifiable.as_deref()),
        Of::Damping => (e.b_n_s_m, e.b_std_n_s_m, e.b_not_identifiable.as_deref()),
        Of::Mass => (e.mass_kg, e.mass_std_kg, Some(WEIGHED)),
    };
    let why = match std_error {
        Some(_) => None,
        None => Some(why.unwrap_or(UNSAID).to_owned()),
    };
    ReportedParameter {
        value,
        std_error,
        interval: std_error.map(|error| [value - WIDE * error, value + WIDE * error]),
        unit: quantity.unit.to_owned(),
        method,
        why,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::Axle as AxlePlant;

    #[test]
    fn an_interval_is_1_96_standard_errors_wide_and_a_missing_one_has_its_reason() {
        let estimate = Estimate {
            k_n_m: 60e3,
            k_std_n_m: Some(100.0),
            b_n_s_m: 500.0,
            b_not_identifiable: Some("it is noise".to_owned()),
            mass_kg: 23.0,
            ..Estimate::default()
        };
        let all: Vec<_> = (AxlePlant::MOVING.quantities().iter())
            .map(|q| reported(q, &estimate, Method::OutputError))
            .collect();
        let [stiffness, damping, mass] = &all[..] else {
            panic!("{all:?}");
        };
        assert_eq!(stiffness.interval, Some([60e3 - 196.0, 60e3 + 196.0]));
        assert_eq!((stiffness.unit.as_str(), &stiffness.why), ("N/m", &None));
        assert_eq!(
            (damping.interval, damping.why.as_deref()),
            (None, Some("it is noise"))
        );
        assert_eq!((mass.value, mass.why.as_deref()), (23.0, Some(WEIGHED)));
    }

    #[test]
    fn a_base_without_a_spring_has_no_stiffness() {
        let names = |base| -> Vec<&str> {
            let quantities = base_model(None, base).quantities();
            quantities.iter().map(|q| q.name).collect()
        };
        assert_eq!(names(Some(Base::Damper)), ["damping", "mass"]);
        for sprung in [None, Some(Base::SpringAndDamper)] {
            assert_eq!(names(sprung), ["stiffness", "damping", "mass"]);
        }
    }
}
