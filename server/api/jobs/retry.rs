use axum::Json;
use axum::extract::State;
use axum::http::{StatusCode, header};
use axum::response::IntoResponse;
use uuid::Uuid;

use super::view::{JobView, find};
use crate::api::App;
use crate::api::access::Caller;
use crate::api::extract::Path;
use crate::api::problem::{Kind, Problem};
use crate::jobs::{LONG, QUICK, begin_anew};
use crate::store::job;

/// Starts a failed or cancelled job again.
#[utoipa::path(post, path = "/v1/jobs/{id}/retry", operation_id = "retry_job", tag = "jobs", params(("id" = Uuid, Path)),
    responses(
        (status = 202, description = "Queued again", body = JobView, headers(("Location" = String))),
        (status = 404, description = "No such job", body = Problem, content_type = "application/problem+json"),
        (status = 409, description = "The job has neither failed nor been cancelled", body = Problem, content_type = "application/problem+json"),
        (status = 503, description = "The queue is full", body = Problem, content_type = "application/problem+json", headers(("Retry-After" = u32)))))]
pub async fn retry(
    State(server): App,
    caller: Caller,
    Path(id): Path<Uuid>,
) -> Result<impl IntoResponse, Problem> {
    let before = find(&server.db, &caller.group, id).await?;
    let mut tx = server.db.begin().await?;
    caller.may_queue(&mut tx).await?;
    let ended = [job::State::Failed, job::State::Cancelled];
    if !begin_anew(&server.queue, &mut tx, id, ended).await? {
        return Err(Problem::new(
            Kind::WrongState,
            format!(
                "the job is {}, only failed and cancelled jobs can be retried",
                before.state.name()
            ),
        ));
    }
    tx.commit().await?;
    tracing::info!(job = %id, before = before.state.name(), "job restarted on request");
    for name in [QUICK, LONG] {
        server.queue.wake(name);
    }
    let view: JobView = find(&server.db, &caller.group, id).await?;
    let location = [(header::LOCATION, view.links.job.clone())];
    Ok((StatusCode::ACCEPTED, location, Json(view)))
}
