use axum::Json;
use axum::extract::State;

use super::view::WebhookView;
use crate::api::App;
use crate::api::access::Caller;
use crate::api::problem::Problem;
use crate::store::webhook;

/// The group's webhooks, oldest first, with the outcome of their last deliveries.
#[utoipa::path(get, path = "/v1/webhooks", operation_id = "list_webhooks", tag = "operations",
    responses((status = 200, description = "All webhooks, without their secrets", body = Vec<WebhookView>)))]
pub async fn list(State(server): App, caller: Caller) -> Result<Json<Vec<WebhookView>>, Problem> {
    let rows = webhook::of_group(&server.db, &caller.group).await?;
    Ok(Json(rows.into_iter().map(WebhookView::from).collect()))
}
