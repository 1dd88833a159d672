//! Holds what is stored of a job against what it says of itself and against its report.

use std::collections::BTreeMap;

use uuid::Uuid;
use veloid_engine::report::Report;

use crate::jobs::{parameters, verdict_name};
use crate::store::Db;
use crate::store::job::{self, JobRow, Stage, State};
use crate::store::parameter::Parameter;
use crate::store::result::{self, DocumentError};
use crate::store::scrub::{self, StoredParameter, readable};
use crate::store::trial::{self, TrialRow};

const VERSION: &str = env!("CARGO_PKG_VERSION");

/// What is wrong with a job's rows. Read again while they change, since a server may be at work on them.
pub async fn faults(db: &Db, id: Uuid) -> sqlx::Result<Vec<String>> {
    loop {
        let job = match readable(job::load(db, id).await)? {
            Ok(Some(job)) => job,
            // Erased meanwhile, or its ride is missing, which is a fault by itself.
            Ok(None) => return Ok(Vec::new()),
            Err(fault) => return Ok(vec![fault]),
        };
        let found = of_job(db, &job).await?;
        let after = readable(job::load(db, id).await)?;
        let same = |after: &JobRow| after.revision == job.revision;
        if found.is_empty() || after.is_ok_and(|after| after.as_ref().is_some_and(same)) {
            return Ok(found);
        }
    }
}

async fn of_job(db: &Db, job: &JobRow) -> sqlx::Result<Vec<String>> {
    let trials = match readable(trial::list(db, job.id).await)? {
        Ok(trials) => trials,
        Err(fault) => return Ok(vec![format!("a trial: {fault}")]),
    };
    let mut found = of_trials(job, &trials);
    let bike = job.request.bike.bike.trim();
    if !bike.is_empty() && bike != job.bike {
        found.push(format!("its bike file is not of {}", job.bike));
    }
    if job.summary.sha256 != job.sha256 {
        found.push("its ride is another one".to_owned());
    }
    let fleet = scrub::parameters(db, job.id).await?;
    if job.state == State::Succeeded {
        found.extend(of_report(db, job, &trials, &fleet).await?);
        return Ok(found);
    }
    if !fleet.is_empty() {
        let (state, count) = (job.state.name(), fleet.len());
        found.push(format!(
            "it is {state}, but {count} parameters of it are in the fleet"
        ));
    }
    if !job.state.is_final() {
        for name in handed_on(job.stage) {
            match result::find(db, job.id, name).await {
                Ok(Some(_)) => {}
                Ok(None) => found.push(format!("`{name}` of an earlier stage is missing")),
                Err(DocumentError::Database(error)) => return Err(error),
                Err(error) => found.push(error.to_string()),
            }
        }
    }
    Ok(found)
}

/// What the stages before this one left for it.
fn handed_on(stage: Stage) -> &'static [&'static str] {
    match stage {
        Stage::Observe => &[],
        Stage::Trial | Stage::Conclude => &[result::OBSERVED],
        Stage::Diagnose => &[result::OBSERVED, result::CONCLUSION],
    }
}

/// Trials are there from the second stage on, with consecutive seeds.
fn of_trials(job: &JobRow, trials: &[TrialRow]) -> Vec<String> {
    let mut found = Vec::new();
    let settings = &job.request.options.settings;
    if settings.trials as i64 != job.trials_total {
        let (asked, total) = (settings.trials, job.trials_total);
        found.push(format!("{asked} trials were asked for, it states {total}"));
    }
    let expected = match job.stage {
        Stage::Observe => 0,
        _ => job.trials_total,
    };
    if trials.len() as i64 != expected {
        found.push(format!("{} of {expected} trials are there", trials.len()));
    }
    let seed = settings.seed.cast_signed();
    for trial in trials {
        if trial.seed != seed.wrapping_add(trial.trial_index) {
            found.push(format!("trial {} has another seed", trial.trial_index));
        }
    }
    let done = trials.iter().filter(|trial| trial.result.is_some()).count();
    // Those that ended after the job are not counted.
    let is_counted = !matches!(job.state, State::Failed | State::Cancelled);
    if is_counted && done as i64 != job.trials_done {
        let counted = job.trials_done;
        found.push(format!(
            "{done} trials have a result, {counted} were counted"
        ));
    }
    found
}

async fn of_report(
    db: &Db,
    job: &JobRow,
    trials: &[TrialRow],
    fleet: &[StoredParameter],
) -> sqlx::Result<Vec<String>> {
    const AGAIN: &str = "upload its ride with `again` to identify it again";
    if job.study.is_some() {
        return Ok(Vec::new());
    }
    let stored = match result::find(db, job.id, result::REPORT).await {
        Ok(Some(stored)) => stored,
        Ok(None) => return Ok(vec![format!("it succeeded and has no report; {AGAIN}")]),
        Err(DocumentError::Database(error)) => return Err(error),
        Err(error) => return Ok(vec![format!("{error}; {AGAIN}")]),
    };
    Ok(match stored.parse::<Report>() {
        // Other versions may have read, counted and named otherwise.
        Ok(report) if stored.is_checked && report.veloid == VERSION => {
            against(job, trials, fleet, &report)
        }
        Ok(_) => Vec::new(),
        Err(error) => vec![format!("{error}; {AGAIN}")],
    })
}

/// What of the rows is not what the report says.
fn against(
    job: &JobRow,
    trials: &[TrialRow],
    fleet: &[StoredParameter],
    report: &Report,
) -> Vec<String> {
    let verdict = report.diagnosis.as_ref().and_then(verdict_name);
    let mut found: Vec<String> = [
        ("ride summary", report.ride == job.summary.0),
        ("bike file", report.bike == job.request.bike),
        ("settings", report.settings == job.request.options.settings),
        ("verdict", verdict == job.verdict),
    ]
    .into_iter()
    .filter(|(_, same)| !same)
    .map(|(what, _)| format!("its {what} and its report's differ"))
    .collect();
    for (trial, reported) in trials.iter().zip(&report.swarm.trials) {
        if trial
            .result
            .as_ref()
            .is_none_or(|result| result.0 != *reported)
        {
            let index = trial.trial_index;
            found.push(format!("trial {index} and its report's differ"));
        }
    }
    found.extend(of_fleet(job, fleet, &parameters(report)));
    found
}

fn of_fleet(job: &JobRow, fleet: &[StoredParameter], reported: &[Parameter]) -> Vec<String> {
    let mut found = Vec::new();
    let mut stored: BTreeMap<(&str, &str, &str), &StoredParameter> = fleet
        .iter()
        .map(|row| {
            (
                (row.method.as_str(), row.axle.as_str(), row.name.as_str()),
                row,
            )
        })
        .collect();
    for parameter in reported {
        let key = (parameter.method, parameter.axle, parameter.name.as_str());
        let what = format!("parameter {} {} by {}", key.1, key.2, key.0);
        let Some(row) = stored.remove(&key) else {
            found.push(format!("{what} is missing from the fleet"));
            continue;
        };
        let kept = (row.value, row.std_error, row.unit.as_str());
        let meant = (
            parameter.value,
            parameter.std_error,
            parameter.unit.as_str(),
        );
        if kept != meant {
            let said = |(value, error, unit)| format!("{} {unit}", with_error(value, error));
            let (kept, meant) = (said(kept), said(meant));
            found.push(format!(
                "{what} is {kept} in the fleet, {meant} in the report"
            ));
        }
        let of = (&row.bike, &row.group_name, &row.verdict);
        if of != (&job.bike, &job.group_name, &job.verdict) || row.version != VERSION {
            found.push(format!(
                "{what} is kept for another bike, group, verdict or version"
            ));
        }
    }
    let more = stored.into_keys();
    found.extend(more.map(|(method, axle, name)| {
        format!("parameter {axle} {name} by {method} is in the fleet, not in the report")
    }));
    found
}

fn with_error(value: f64, error: Option<f64>) -> String {
    match error {
        Some(error) => format!("{value} ± {error}"),
        None => value.to_string(),
    }
}
