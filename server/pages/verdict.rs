//! Jobs as lists show them: with the verdict in words, stiffness and damping.

use uuid::Uuid;
use veloid_engine::document::format_number::Number;

use super::words;
use crate::api::jobs::view::JobView;
use crate::store::parameter::JobResult;
use crate::store::{Db, parameter};

pub struct Listed {
    pub job: JobView,
    /// With the names of the effects.
    pub verdict: Option<String>,
    pub k: Vec<OnAxle>,
    pub b: Vec<OnAxle>,
}

/// A quantity of one axle, in the unit of its column.
pub struct OnAxle {
    pub axle: String,
    pub number: Number,
}

/// Adds what the jobs found.
pub async fn listed(db: &Db, jobs: Vec<JobView>) -> sqlx::Result<Vec<Listed>> {
    let ids: Vec<Uuid> = (jobs.iter())
        .filter(|job| {
            job.verdict
                .as_deref()
                .is_some_and(|v| v.starts_with("named"))
        })
        .map(|job| job.id)
        .collect();
    let effects = parameter::effects(db, &ids).await?;
    let all: Vec<Uuid> = jobs.iter().map(|job| job.id).collect();
    let mut results = parameter::results(db, &all).await?;
    results.sort_by(|a, b| a.axle.cmp(&b.axle));
    let listed = |job: JobView| Listed {
        verdict: verdict(&job, &effects),
        k: of_job(&results, job.id, "k_n_m"),
        b: of_job(&results, job.id, "b_n_s_m"),
        job,
    };
    Ok(jobs.into_iter().map(listed).collect())
}

fn verdict(job: &JobView, effects: &[(Uuid, String, String)]) -> Option<String> {
    let own = effects.iter().filter(|(id, ..)| *id == job.id);
    let mut names: Vec<String> = own
        .map(|(_, axle, name)| {
            let effect = words::plain(name.split('.').next().unwrap_or(name));
            match axle.as_str() {
                "both" => effect,
                axle => format!("{effect} ({axle})"),
            }
        })
        .collect();
    names.sort();
    names.dedup();
    let verdict = words::plain(job.verdict.as_deref()?);
    Some(match names.is_empty() {
        true => verdict,
        false => format!("{verdict}: {}", names.join(", ")),
    })
}

fn of_job(results: &[JobResult], job: Uuid, name: &str) -> Vec<OnAxle> {
    let own = (results.iter()).filter(|result| result.job_id == job && result.name == name);
    own.map(|result| OnAxle {
        axle: result.axle.clone(),
        number: Number::measured(result.value, result.std_error),
    })
    .collect()
}
