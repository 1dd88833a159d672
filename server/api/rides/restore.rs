use axum::Json;
use axum::extract::State;
use uuid::Uuid;

use super::view::{RideView, find};
use crate::api::App;
use crate::api::access::Caller;
use crate::api::extract::Path;
use crate::api::problem::{Kind, Problem};
use crate::erasure;

/// Restores a deleted ride with its jobs, as long as it is not erased; cancelled jobs remain cancelled.
#[utoipa::path(post, path = "/v1/rides/{id}/restore", operation_id = "restore_ride", tag = "rides", params(("id" = Uuid, Path)),
    responses(
        (status = 200, description = "Restored", body = RideView),
        (status = 404, description = "No such ride, or it is erased", body = Problem, content_type = "application/problem+json"),
        (status = 409, description = "The ride is not deleted", body = Problem, content_type = "application/problem+json")))]
pub async fn restore(
    State(server): App,
    caller: Caller,
    Path(id): Path<Uuid>,
) -> Result<Json<RideView>, Problem> {
    find(&server, &caller.group, id).await?;
    let mut tx = server.db.begin().await?;
    if !erasure::restore_ride(&mut tx, &caller.group, id, caller.actor()).await? {
        return Err(Problem::new(Kind::WrongState, "the ride is not deleted"));
    }
    tx.commit().await?;
    Ok(Json(find(&server, &caller.group, id).await?))
}
