use axum::Json;
use axum::extract::State;
use uuid::Uuid;

use super::view::{RideView, find, no_such_ride};
use crate::api::access::Caller;
use crate::api::extract::Path;
use crate::api::problem::Problem;
use crate::api::{App, Server};
use crate::crash;
use crate::erasure;
use crate::store::deletion::Of;

/// Deletes a ride with its jobs, their results and its file.
///
/// Jobs that have not ended are cancelled first. Lists, the fleet and pooled values exclude the ride at once. It can be
/// restored during the days of grace; then it is erased: its rows, and the file unless another ride has the same bytes.
#[utoipa::path(delete, path = "/v1/rides/{id}", operation_id = "delete_ride", tag = "rides", params(("id" = Uuid, Path)),
    responses(
        (status = 200, description = "Deleted, now or earlier", body = RideView),
        (status = 404, description = "No such ride", body = Problem, content_type = "application/problem+json")))]
pub async fn delete(
    State(server): App,
    caller: Caller,
    Path(id): Path<Uuid>,
) -> Result<Json<RideView>, Problem> {
    remove(&server, &caller, Of::Ride(id), no_such_ride).await?;
    Ok(Json(find(&server, &caller.group, id).await?))
}

/// Deletes what belongs to a ride or a bike of the caller's group.
pub async fn remove(
    server: &Server,
    caller: &Caller,
    of: Of<'_>,
    missing: fn() -> Problem,
) -> Result<(), Problem> {
    let mut tx = server.db.begin().await?;
    let cancelled =
        erasure::delete(&server.queue, &mut tx, &caller.group, of, caller.actor()).await?;
    let cancelled = cancelled.ok_or_else(missing)?;
    tx.commit().await?;
    crash::point("after_delete");
    for job in cancelled {
        server.hub.close(job);
    }
    Ok(())
}
