//! The one answer per axle and quantity.

use veloid_core::bicycle::{Axle, PerAxle};
use veloid_core::document::format_number::WIDE;
use veloid_core::plant::{Axle as AxlePlant, Of, Plant, Quantity};
use veloid_inside::Oscillator;
use veloid_methods::uncertainty::laser::misleading;
use veloid_report::diagnosis::{Base, Verdict};
use veloid_report::dynamics::{Dynamics, StepInput};
use veloid_report::identifiable::NO_VERDICT;
use veloid_report::{AxleResult, Estimate, Method, Report, ResultQuantity, at_limit};
use veloid_ride::Ride;

/// Why a mass has no standard error.
const GIVEN: &str = "given in the bike file";
/// Why a quantity has no value where no method says more.
const NO_ESTIMATE: &str = "no method determined it from this record";
/// Why a natural frequency or damping ratio has no interval.
const NO_CORRELATION: &str = "the method gives no covariance of k and B";
/// Why there is none.
const NO_SPRING: &str = "k is not above zero";
/// Why there is no interval where something without a name acts.
const UNNAMED: &str = "an effect missing from the model acts on this axle, and an interval would not include its influence";

/// Why there is none by the road's own method, which knows the road from plain models of both axles.
const OTHER_AXLE: &str = "an effect missing from the model acts on the other axle, on which the estimate without a road rests, and an interval \
    would not include its influence";

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
    let mut found = PerAxle::default();
    for axle in Axle::BOTH {
        if let Some(estimate) = report.estimates(best_method(report, axle)).get(axle) {
            let plant: &dyn Plant = match estimate.mass_kg > 0.0 {
                true => &AxlePlant::MOVING,
                false => &AxlePlant::DRIVEN,
            };
            found.set(axle, of_axle(report, axle, plant));
        }
    }
    found
}

/// The road's own method where no other has an estimate of the axle or the recorded road misleads; else the model with the
/// effects that the verdict names, or output error.
fn best_method(report: &Report, axle: Axle) -> Method {
    let is_unrecorded = report.output_error.get(axle).is_none() && report.latent_road.is_some();
    if road_misleads(report) {
        return Method::LatentRoad;
    }
    match &report.diagnosis {
        Some(d) if is_unrecorded && d.extended.get(axle).is_none() => Method::LatentRoad,
        Some(d) if d.verdict.names_effects() && !d.effects.is_empty() => Method::Extended,
        _ if is_unrecorded => Method::LatentRoad,
        _ => Method::OutputError,
    }
}

/// Whether the recorded road misleads, and the ride is identified without it.
fn road_misleads(report: &Report) -> bool {
    let misleads = || {
        misleading(
            &report.ride.clocks,
            &report.output_error,
            &report.laser_error,
        )
    };
    let identified = (report.latent_road.as_ref()).is_some_and(|found| found.reason.is_none());
    identified && !report.has_no_road() && misleads().is_some()
}

fn of_axle(report: &Report, axle: Axle, plant: &dyn Plant) -> AxleResult {
    let method = best_method(report, axle);
    let found = report.estimates(method).get(axle).cloned();
    let withheld = withheld(report, method);
    let base = report.diagnosis.as_ref().map(|diagnosis| diagnosis.base);
    let unexplained = unexplained(report, axle, method);
    let bike = report.settings.limited(&report.bike).unwrap_or_default();
    let of = |estimate| Found {
        method,
        estimate,
        unexplained,
        heavier: heavier(report, axle),
    };
    let one = |quantity: &Quantity| {
        let limit = bike.limit(axle, quantity.of);
        if let Some(held) = found
            .as_ref()
            .and_then(|e| held(quantity, e, method, limit))
        {
            return (quantity.name.to_owned(), held);
        }
        let reported = match (&found, &withheld) {
            (Some(e), None) => of(e).quantity(quantity),
            (Some(e), Some(_)) if quantity.of == Of::Mass && e.mass_std_kg.is_none() => {
                of(e).quantity(quantity)
            }
            (None, _) if given(report, axle, quantity).is_some() => ResultQuantity {
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

/// Why nothing is reported by a method.
fn withheld(report: &Report, method: Method) -> Option<String> {
    // Without a road there is no verdict to wait for.
    let stands_alone = report.has_no_road() || road_misleads(report);
    let unknown = report.latent_road.as_ref().and_then(|l| l.reason.clone());
    match method {
        Method::LatentRoad if stands_alone || unknown.is_some() => unknown,
        _ => {
            let verdict = report.diagnosis.as_ref().map(|d| d.verdict);
            (verdict == Some(Verdict::CannotTell)).then(|| NO_VERDICT.to_owned())
        }
    }
}

/// Why an estimate of an axle by a method has no interval: something that is not in its model acts on an axle that it rests on.
fn unexplained(report: &Report, axle: Axle, method: Method) -> Option<&'static str> {
    let diagnosis = report.diagnosis.as_ref()?;
    let mut places = diagnosis.location.iter().filter(|(_, l)| l.mismatch);
    match method {
        Method::OutputError if diagnosis.verdict == Verdict::Unnamed => {
            places.any(|(at, _)| at == axle).then_some(UNNAMED)
        }
        Method::LatentRoad => places.next().map(|_| OTHER_AXLE),
        _ => None,
    }
}

/// A quantity that the user has fixed, or bounded where it lies.
fn held(
    quantity: &Quantity,
    e: &Estimate,
    method: Method,
    limit: Option<[f64; 2]>,
) -> Option<ResultQuantity> {
    let value = match quantity.of {
        Of::Stiffness => e.k_n_m,
        Of::Damping => e.b_n_s_m,
        Of::Mass | Of::NaturalFrequency | Of::DampingRatio => return None,
    };
    let why = at_limit(value, limit, quantity.unit)?;
    Some(ResultQuantity {
        value: Some(value),
        ..without_value(quantity, method, &why)
    })
}

/// What a method found on an axle.
struct Found<'a> {
    method: Method,
    estimate: &'a Estimate,
    /// Why nothing of it has an interval.
    unexplained: Option<&'a str>,
    /// How far k, B and m move together when the mass is a standard deviation larger.
    heavier: [f64; 3],
}

/// A value with its standard error or why it has none; or why there is no value.
type Stated = Result<(f64, Result<f64, String>), String>;

impl Found<'_> {
    fn quantity(&self, quantity: &Quantity) -> ResultQuantity {
        let stated = match quantity.of {
            Of::Stiffness => self.stiffness(),
            Of::Damping => self.damping(),
            Of::Mass => Ok(self.mass()),
            Of::NaturalFrequency => self.natural_frequency(),
            Of::DampingRatio => self.damping_ratio(),
        };
        let (value, std_error) = match stated {
            Ok(stated) => stated,
            Err(why) => return without_value(quantity, self.method, &why),
        };
        let unexplained = || self.unexplained.map_or(Ok(()), |why| Err(why.to_owned()));
        match std_error.and_then(|error| unexplained().map(|()| error)) {
            Err(why) => ResultQuantity {
                value: Some(value),
                ..without_value(quantity, self.method, &why)
            },
            Ok(error) => ResultQuantity {
                value: Some(value),
                std_error: Some(error),
                interval: Some([value - WIDE * error, value + WIDE * error]),
                unit: quantity.unit.to_owned(),
                method: self.method,
                why: None,
            },
        }
    }

    fn stiffness(&self) -> Stated {
        let e = self.estimate;
        let error = e.k_std_n_m.ok_or_else(|| because(&e.k_not_identifiable))?;
        match e.k_n_m + WIDE * error < 0.0 {
            true => Err(negative(e, error)),
            false => Ok((e.k_n_m, Ok(error))),
        }
    }

    fn damping(&self) -> Stated {
        let e = self.estimate;
        let error = e
            .b_std_n_s_m
            .ok_or_else(|| because(&e.b_not_identifiable))?;
        Ok((e.b_n_s_m, Ok(error)))
    }

    fn mass(&self) -> (f64, Result<f64, String>) {
        let e = self.estimate;
        (e.mass_kg, e.mass_std_kg.ok_or_else(|| GIVEN.to_owned()))
    }

    fn natural_frequency(&self) -> Stated {
        let _ = self.stiffness()?;
        let (hz, error) = self.oscillator()?.natural_frequency_hz();
        Ok((hz, error.ok_or_else(|| NO_CORRELATION.to_owned())))
    }

    fn damping_ratio(&self) -> Stated {
        let _ = self.stiffness().and(self.damping())?;
        let (ratio, error) = self.oscillator()?.damping_ratio();
        Ok((ratio, error.ok_or_else(|| NO_CORRELATION.to_owned())))
    }

    fn oscillator(&self) -> Result<Oscillator, String> {
        Oscillator::of(self.estimate, self.heavier).ok_or_else(|| NO_SPRING.to_owned())
    }
}

fn because(why: &Option<String>) -> String {
    why.clone().unwrap_or_else(|| NO_ESTIMATE.to_owned())
}

/// How far k, B and m move together when the mass of the bike file is a standard deviation larger.
fn heavier(report: &Report, axle: Axle) -> [f64; 3] {
    match (report.mass_error.get(axle), report.bike.mass_std(axle)) {
        (Some(by), Some(std)) => [by.k_n_m, by.b_n_s_m, std],
        _ => [0.0; 3],
    }
}

/// What each of these axles' k, B and m make.
pub fn dynamics(ride: &Ride, report: &Report) -> PerAxle<Dynamics> {
    report.result.map(|axle, _| {
        let method = best_method(report, axle);
        let found = report.estimates(method).get(axle).cloned();
        let record = ride.axles.get(axle);
        let input = match record.is_some_and(|r| !r.has_road() && r.force.is_some()) {
            true => StepInput::Force,
            false => StepInput::Road,
        };
        let effects = report.diagnosis.iter().flat_map(|d| &d.effects);
        let has_effects = effects.into_iter().any(|e| e.axle.acts_on(axle));
        match (found, withheld(report, method)) {
            (Some(e), None) => veloid_inside::dynamics(
                &e,
                method,
                input,
                has_effects && method == Method::Extended,
            ),
            (_, why) => {
                veloid_inside::without_dynamics(method, why.as_deref().unwrap_or(NO_ESTIMATE))
            }
        }
    })
}

/// Why a stiffness that its interval holds below zero is none.
fn negative(e: &Estimate, error: f64) -> String {
    let k = veloid_core::document::format_number::Quantity::new(e.k_n_m, Some(error), "N/m");
    let why = match e.mass_kg > 0.0 {
        true => {
            "no axle comes back to where it rests without a spring: check the signs of its channels"
        }
        false => {
            "where a rig prescribes the motion k is the slope of the force, and a mass that moves along or a late force sensor \
             lowers it: subtract the force of the mass, and record both channels on one clock"
        }
    };
    format!("{k} is negative, which no spring is; {why}")
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
            covariance: Some([[1e4, 0.0, 0.0], [0.0; 3], [0.0; 3]]),
            ..Estimate::default()
        };
        let of = |unexplained| -> Vec<ResultQuantity> {
            let quantities = AxlePlant::MOVING.quantities().iter();
            quantities
                .map(|q| {
                    let found = Found {
                        method: Method::OutputError,
                        estimate: &estimate,
                        unexplained,
                        heavier: [0.0; 3],
                    };
                    found.quantity(q)
                })
                .collect()
        };
        let [k, b, mass, hz, ratio] = &of(None)[..] else {
            panic!("{:?}", of(None));
        };
        assert_eq!(k.interval, Some([60e3 - 196.0, 60e3 + 196.0]));
        assert_eq!((k.unit.as_str(), &k.why), ("N/m", &None));
        assert_eq!((b.value, b.why.as_deref()), (None, Some("it is noise")));
        assert_eq!((mass.value, mass.why.as_deref()), (Some(23.0), Some(GIVEN)));
        // Without B there is no ratio, and a natural frequency all the same.
        let expected = (60e3_f64 / 23.0).sqrt() / std::f64::consts::TAU;
        assert!((hz.value.unwrap_or_default() - expected).abs() < 1e-9);
        assert!((hz.std_error.unwrap_or_default() - 0.5 * expected / 600.0).abs() < 1e-9);
        assert_eq!(
            (ratio.value, ratio.why.as_deref()),
            (None, Some("it is noise"))
        );

        let k = &of(Some(UNNAMED))[0];
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
            assert_eq!(
                names(sprung),
                ["k", "B", "mass", "natural_frequency", "damping_ratio"]
            );
        }
    }
}
