//! Verdicts with the names of the effects.

use super::words;
use crate::api::jobs::view::JobView;
use crate::store::{Db, parameter};

/// Jobs with their verdicts in words.
pub async fn with_verdicts(
    db: &Db,
    jobs: Vec<JobView>,
) -> sqlx::Result<Vec<(JobView, Option<String>)>> {
    let named = |job: &&JobView| {
        job.verdict
            .as_deref()
            .is_some_and(|v| v.starts_with("named"))
    };
    let ids: Vec<_> = jobs.iter().filter(named).map(|job| job.id).collect();
    let effects = parameter::effects(db, &ids).await?;
    let with_verdicts = |job: JobView| {
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
        let verdict = job.verdict.as_deref().map(words::plain);
        let verdict = verdict.map(|verdict| match names.is_empty() {
            true => verdict,
            false => format!("{verdict}: {}", names.join(", ")),
        });
        (job, verdict)
    };
    Ok(jobs.into_iter().map(with_verdicts).collect())
}
