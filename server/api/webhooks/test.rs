use axum::Json;
use axum::extract::State;
use serde::Serialize;
use utoipa::ToSchema;
use uuid::Uuid;

use crate::api::App;
use crate::api::access::Caller;
use crate::api::extract::Path;
use crate::api::problem::Problem;
use crate::store::{now_ms, webhook};
use crate::webhooks::{self, Message, Notification, Secret, send};

/// Outcome of a test message.
#[derive(Serialize, ToSchema)]
pub struct Tested {
    pub delivered: bool,
    /// Status of the response, or the error.
    pub outcome: String,
}

/// Sends a message of the type `test` now, once.
#[utoipa::path(post, path = "/v1/webhooks/{id}/test", operation_id = "test_webhook", tag = "operations", params(("id" = Uuid, Path)),
    responses(
        (status = 200, description = "Outcome", body = Tested),
        (status = 404, description = "No such webhook", body = Problem, content_type = "application/problem+json"),
        (status = 501, description = "The server is built without webhooks", body = Problem, content_type = "application/problem+json")))]
pub async fn test(
    State(server): App,
    caller: Caller,
    Path(id): Path<Uuid>,
) -> Result<Json<Tested>, Problem> {
    webhooks::built()?;
    let row = webhook::find(&server.db, &caller.group, id).await?;
    let row = row.ok_or_else(|| Problem::not_found("the webhook"))?;
    let now = now_ms();
    let (id, body) = (
        format!("msg_{}", Uuid::now_v7().simple()),
        Notification::test(now).body(),
    );
    let message = Message {
        id: &id,
        body: &body,
        timestamp: now / 1000,
    };
    let sent = send(
        &server.targets,
        &row.url,
        &Secret::stored(row.secret),
        &message,
    )
    .await;
    Ok(Json(Tested {
        delivered: sent.is_ok(),
        outcome: sent.map_or_else(|error| error.to_string(), |status| status.to_string()),
    }))
}
