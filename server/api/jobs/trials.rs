use axum::Json;
use axum::extract::State;
use serde::Serialize;
use utoipa::ToSchema;
use uuid::Uuid;
use veloid_engine::report::Trial;

use super::view::no_such_job;
use crate::api::App;
use crate::api::access::Caller;
use crate::api::extract::Path;
use crate::api::problem::Problem;
use crate::store::{job, trial};
use crate::time;

/// One swarm of a job.
#[derive(Serialize, ToSchema)]
pub struct TrialView {
    pub index: i64,
    pub seed: u64,
    #[schema(format = DateTime)]
    pub finished_at: Option<String>,
    /// Curves and parameters, once the trial is done.
    pub result: Option<Trial>,
}

#[derive(Serialize, ToSchema)]
pub struct TrialList {
    pub items: Vec<TrialView>,
}

/// The swarm trials of a job, one per seed; none before least squares are available.
#[utoipa::path(get, path = "/v1/jobs/{id}/trials", operation_id = "list_trials", tag = "jobs", params(("id" = Uuid, Path)),
    responses(
        (status = 200, description = "The trials, in the order of their seeds", body = TrialList),
        (status = 404, description = "No such job", body = Problem, content_type = "application/problem+json")))]
pub async fn trials(
    State(server): App,
    caller: Caller,
    Path(id): Path<Uuid>,
) -> Result<Json<TrialList>, Problem> {
    job::revision(&server.db, &caller.group, id)
        .await?
        .ok_or_else(no_such_job)?;
    let rows = trial::list(&server.db, id).await?;
    let items = rows
        .into_iter()
        .map(|row| TrialView {
            index: row.trial_index,
            seed: row.seed.cast_unsigned(),
            finished_at: row.finished_at.map(time::text),
            result: row.result.map(|json| json.0),
        })
        .collect();
    Ok(Json(TrialList { items }))
}
