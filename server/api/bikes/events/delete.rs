use axum::extract::State;
use axum::http::StatusCode;
use uuid::Uuid;

use crate::api::App;
use crate::api::access::Caller;
use crate::api::extract::Path;
use crate::api::problem::Problem;
use crate::store::{audit, bike_event};

/// Deletes an event of a bicycle for good.
#[utoipa::path(delete, path = "/v1/bikes/{bike}/events/{id}", operation_id = "delete_bike_event", tag = "fleet",
    params(("bike" = String, Path, min_length = 1), ("id" = Uuid, Path)),
    responses(
        (status = 204, description = "Deleted"),
        (status = 404, description = "No such event of this bike", body = Problem, content_type = "application/problem+json")))]
pub async fn delete(
    State(server): App,
    caller: Caller,
    Path((bike, id)): Path<(String, Uuid)>,
) -> Result<StatusCode, Problem> {
    let missing = || Problem::not_found("the event");
    if bike.contains('\0') {
        return Err(missing());
    }
    let mut tx = server.db.begin().await?;
    if !bike_event::delete(&mut tx, &caller.group, &bike, id).await? {
        return Err(missing());
    }
    let subject = format!("event {id} of bike {bike}");
    audit::note(&mut tx, &caller.group, caller.actor(), "delete", &subject).await?;
    tx.commit().await?;
    Ok(StatusCode::NO_CONTENT)
}
