use axum::Json;
use axum::extract::State;
use uuid::Uuid;

use super::view::{JobView, find};
use crate::api::App;
use crate::api::access::Caller;
use crate::api::extract::Path;
use crate::api::problem::{Kind, Problem};
use crate::crash;
use crate::jobs::give_up;
use crate::store::job::State as JobState;

/// Cancels a job: waiting stages are not started, a running one stops within a swarm iteration.
#[utoipa::path(delete, path = "/v1/jobs/{id}", operation_id = "cancel_job", tag = "jobs", params(("id" = Uuid, Path)),
    responses(
        (status = 200, description = "Cancelled, now or earlier", body = JobView),
        (status = 404, description = "No such job", body = Problem, content_type = "application/problem+json"),
        (status = 409, description = "The job has succeeded or failed", body = Problem, content_type = "application/problem+json")))]
pub async fn cancel(
    State(server): App,
    caller: Caller,
    Path(id): Path<Uuid>,
) -> Result<Json<JobView>, Problem> {
    find(&server.db, &caller.group, id).await?;
    let mut tx = server.db.begin().await?;
    let cancelled = give_up(&server.queue, &mut tx, id, None).await?;
    tx.commit().await?;
    crash::point("after_cancel");
    if cancelled {
        server.hub.close(id);
    }
    let view = find(&server.db, &caller.group, id).await?;
    match view.state {
        JobState::Cancelled => Ok(Json(view)),
        state => Err(Problem::new(
            Kind::WrongState,
            format!("the job has {}, it cannot be cancelled", state.name()),
        )),
    }
}
