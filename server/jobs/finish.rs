//! The end of a job that went well: report, verdict and the fleet's parameters in one transaction.

use serde_json::Value;
use tracing::{debug, info};
use uuid::Uuid;
use veloid_engine::bicycle::{Axle, PerAxle};
use veloid_engine::report::diagnosis::{Diagnosis, Verdict};
use veloid_engine::report::study::{StudyEffect, StudyReport};
use veloid_engine::report::{AxleResult, Estimate, Method, Report, ResultQuantity};

use super::fault::Fault;
use super::queue::Queue;
use super::stage::announce;
use crate::store::parameter::{self, Parameter};
use crate::store::{Tx, job, proposal, result};

/// Publishes the report of a running job; false for one that was cancelled meanwhile, for which it does nothing.
pub async fn finish(
    queue: &Queue,
    tx: &mut Tx,
    id: Uuid,
    group: &str,
    bike: &str,
    report: &Report,
) -> Result<bool, Fault> {
    let verdict = report.diagnosis.as_ref().and_then(verdict_name);
    if !job::succeed(tx, id, verdict.as_deref(), no_result(report).as_deref()).await? {
        return Ok(false);
    }
    // The report holds what the stages handed on.
    result::clear(tx, id).await?;
    result::put(tx, id, result::REPORT, report).await?;
    parameter::insert(tx, id, group, bike, verdict.as_deref(), &parameters(report)).await?;
    let next = report.diagnosis.as_ref().and_then(|d| d.next_ride.as_ref());
    proposal::put(tx, id, next).await?;
    queue.announce(tx, id).await?;
    Ok(true)
}

/// Publishes the report of a running study, as [`finish`] does of one ride.
pub async fn finish_study(
    queue: &Queue,
    tx: &mut Tx,
    (id, group, bike): (Uuid, &str, &str),
    report: &StudyReport,
) -> Result<bool, Fault> {
    let verdict = name_of(report.verdict);
    if !job::succeed(tx, id, verdict.as_deref(), None).await? {
        return Ok(false);
    }
    result::put(tx, id, result::REPORT, report).await?;
    let found = parameters_of_study(report);
    parameter::insert(tx, id, group, bike, verdict.as_deref(), &found).await?;
    announce(queue, tx, id).await?;
    Ok(true)
}

/// Stiffness and damping where the rides have them in common, and effects that are affirmed and of one size in all rides.
fn parameters_of_study(report: &StudyReport) -> Vec<Parameter> {
    let parameter = |axle, name: String, value, std_error, unit: &str| Parameter {
        method: parameter::STUDY,
        axle,
        name,
        value,
        std_error,
        unit: unit.to_owned(),
    };
    let mut found = Vec::new();
    for (axle, together) in report.axles.iter() {
        let Some(e) = &together.estimate else {
            continue;
        };
        let numbers = [
            ("k_n_m", e.k_n_m, e.k_std_n_m, &e.k_not_identifiable, "N/m"),
            (
                "b_n_s_m",
                e.b_n_s_m,
                e.b_std_n_s_m,
                &e.b_not_identifiable,
                "N s/m",
            ),
        ];
        let known = numbers.into_iter().filter(|(.., why, _)| why.is_none());
        found.extend(known.map(|(name, value, error, _, unit)| {
            parameter(axle.name(), name.to_owned(), value, error, unit)
        }));
    }
    let alpha = report.settings.alpha;
    let in_common = |found: &&StudyEffect| {
        found.effect.affirmed && found.differs_p_value.is_none_or(|p| p >= alpha)
    };
    for StudyEffect { effect, .. } in report.effects.iter().filter(in_common) {
        found.extend(effect.parameters.iter().map(|(name, p)| {
            let name = format!("{}.{name}", effect.id);
            parameter(effect.axle.name(), name, p.value, p.std_error, &p.unit)
        }));
    }
    found
}

/// Logs what [`finish`] came to, once it is committed.
pub fn finished(job: Uuid, is_published: bool, report: &Report) {
    let verdict = report.diagnosis.as_ref().and_then(verdict_name);
    match is_published {
        true => info!(%job, verdict, "job succeeded"),
        false => debug!(%job, "report dropped: the job was cancelled meanwhile"),
    }
}

/// Why no axle has stiffness or damping, if none has.
fn no_result(report: &Report) -> Option<String> {
    let of_axle = |(_, result): (Axle, &AxleResult)| {
        let quantities = result.iter().filter(|(name, _)| ["k", "B"].contains(name));
        let own = quantities.map(|(_, found)| (found.value.is_some(), found.why.clone()));
        own.collect::<Vec<_>>()
    };
    let found: Vec<(bool, Option<String>)> = report.result.iter().flat_map(of_axle).collect();
    if found.iter().any(|(is_known, _)| *is_known) {
        return None;
    }
    let verdict = report.diagnosis.as_ref();
    let verdict = verdict.filter(|d| d.verdict == Verdict::CannotTell && !d.sentence.is_empty());
    let why = verdict.map(|d| d.sentence.clone());
    why.or_else(|| found.into_iter().find_map(|(_, why)| why))
}

/// The verdict as the report spells it.
pub fn verdict_name(diagnosis: &Diagnosis) -> Option<String> {
    name_of(diagnosis.verdict)
}

fn name_of(verdict: Verdict) -> Option<String> {
    match serde_json::to_value(verdict) {
        Ok(Value::String(name)) => Some(name),
        _ => None,
    }
}

/// Every parameter that the report holds; of what the result withholds, no method's.
pub fn parameters(report: &Report) -> Vec<Parameter> {
    let mut found = of_result(report);
    for method in Method::ALL.into_iter().rev() {
        found.extend(of_estimates(
            method,
            &report.estimates(method),
            &report.result,
        ));
    }
    if let Some(diagnosis) = &report.diagnosis {
        let in_part = diagnosis.verdict == Verdict::NamedInPart;
        for effect in (diagnosis.effects.iter()).filter(|e| e.affirmed || !in_part) {
            let axle = effect.axle.name();
            found.extend(effect.parameters.iter().map(|(name, parameter)| Parameter {
                method: Method::Extended.name(),
                axle,
                name: format!("{}.{name}", effect.id),
                value: parameter.value,
                std_error: parameter.std_error,
                unit: parameter.unit.clone(),
            }));
        }
    }
    found
}

/// The one answer. `k`, `B` and `mass` have the names that they have by every method.
fn of_result(report: &Report) -> Vec<Parameter> {
    let on_axle = |(axle, result): (Axle, &AxleResult)| -> Vec<Parameter> {
        let parameter = |(name, quantity): (&str, &ResultQuantity)| {
            let is_given = name == "mass" && quantity.std_error.is_none();
            Some(Parameter {
                method: parameter::RESULT,
                axle: axle.name(),
                name: match name {
                    "k" => "k_n_m".to_owned(),
                    "B" => "b_n_s_m".to_owned(),
                    "mass" => "mass_kg".to_owned(),
                    other => other.to_owned(),
                },
                value: quantity.value.filter(|_| !is_given)?,
                std_error: quantity.std_error,
                unit: quantity.unit.clone(),
            })
        };
        result.iter().filter_map(parameter).collect()
    };
    report.result.iter().flat_map(on_axle).collect()
}

fn of_estimates(
    method: Method,
    estimates: &PerAxle<Estimate>,
    results: &PerAxle<AxleResult>,
) -> Vec<Parameter> {
    let on_axle = |(axle, e): (Axle, &Estimate)| {
        let withheld = |name| results.get(axle).and_then(|result| result.withheld(name));
        let parameter = |name: &str, value, std_error, unit: &str| Parameter {
            method: method.name(),
            axle: axle.name(),
            name: name.to_owned(),
            value,
            std_error,
            unit: unit.to_owned(),
        };
        let k = parameter("k_n_m", e.k_n_m, e.k_std_n_m, "N/m");
        let b = parameter("b_n_s_m", e.b_n_s_m, e.b_std_n_s_m, "N s/m");
        let mass = (e.mass_std_kg).map(|std| parameter("mass_kg", e.mass_kg, Some(std), "kg"));
        let stated = [("k", Some(k)), ("B", Some(b)), ("mass", mass)]
            .into_iter()
            .filter(|(name, _)| withheld(name).is_none());
        stated.filter_map(|(_, found)| found).collect::<Vec<_>>()
    };
    estimates.iter().flat_map(on_axle).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_estimate_gives_its_parameters_and_an_estimated_mass() {
        let estimates = PerAxle {
            front: Some(Estimate {
                k_n_m: 1.0,
                mass_kg: 23.0,
                mass_std_kg: Some(0.1),
                ..Estimate::default()
            }),
            rear: Some(Estimate::default()),
        };
        let found = of_estimates(Method::Swarm, &estimates, &PerAxle::default());
        let keys: Vec<_> = found.iter().map(|p| (p.axle, p.name.as_str())).collect();
        assert_eq!(
            keys,
            [
                ("front", "k_n_m"),
                ("front", "b_n_s_m"),
                ("front", "mass_kg"),
                ("rear", "k_n_m"),
                ("rear", "b_n_s_m"),
            ]
        );
    }
}
