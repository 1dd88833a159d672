use axum::extract::State;
use axum::http::StatusCode;
use uuid::Uuid;

use crate::api::App;
use crate::api::access::Caller;
use crate::api::extract::Path;
use crate::api::problem::Problem;
use crate::store::{audit, webhook};

/// Deletes a webhook; pending deliveries to it are dropped.
#[utoipa::path(delete, path = "/v1/webhooks/{id}", operation_id = "delete_webhook", tag = "operations", params(("id" = Uuid, Path)),
    responses(
        (status = 204, description = "Deleted"),
        (status = 404, description = "No such webhook", body = Problem, content_type = "application/problem+json")))]
pub async fn delete(
    State(server): App,
    caller: Caller,
    Path(id): Path<Uuid>,
) -> Result<StatusCode, Problem> {
    let mut tx = server.db.begin().await?;
    if !webhook::delete(&mut tx, &caller.group, id).await? {
        return Err(Problem::not_found("the webhook"));
    }
    audit::note(
        &mut tx,
        &caller.group,
        caller.actor(),
        "delete webhook",
        &id.to_string(),
    )
    .await?;
    tx.commit().await?;
    Ok(StatusCode::NO_CONTENT)
}
