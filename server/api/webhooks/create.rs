use axum::Json;
use axum::body::Bytes;
use axum::extract::State;
use axum::http::StatusCode;
use serde::Deserialize;
use utoipa::ToSchema;
use uuid::Uuid;

use super::view::WebhookView;
use crate::api::App;
use crate::api::access::Caller;
use crate::api::names::{self, one_of};
use crate::api::problem::{Kind, Problem};
use crate::store::webhook::{self, WebhookRow};
use crate::store::{audit, now_ms};
use crate::webhooks::{self, Event, Secret};

/// Most webhooks of a group.
const MOST: i64 = 20;

/// A webhook to create.
#[derive(Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct NewWebhook {
    /// An https address with a host that the operator allows by `--webhook-allow`.
    #[schema(
        pattern = r"^https?://([a-z0-9]([a-z0-9]|-[a-z0-9])*\.)*[a-z]([a-z0-9]|-[a-z0-9])*(:[0-9]{1,4})?(/[A-Za-z0-9._~/%?&=-]*)?$",
        max_length = 2000
    )]
    pub url: String,
    /// By default all events: `job.succeeded`, `job.failed`, `job.cancelled`, `bike.drifts`, `bike.stepped`,
    /// `bike.new_physics`.
    #[serde(default)]
    #[schema(schema_with = names::events)]
    pub events: Vec<String>,
}

/// Creates a webhook.
///
/// Messages are signed by the scheme of standard-webhooks: HMAC-SHA256 over `webhook-id.webhook-timestamp.body` with the
/// secret, which only this answer contains. A message not answered by 200 to 299 is sent again after 5 s, 5 min, 30 min, 2 h
/// and so on, for three days.
#[utoipa::path(post, path = "/v1/webhooks", operation_id = "create_webhook", tag = "operations", request_body = NewWebhook,
    responses(
        (status = 201, description = "Created; the secret is returned only here", body = WebhookView),
        (status = 400, description = "Invalid address or unknown event", body = Problem, content_type = "application/problem+json"),
        (status = 501, description = "The server is built without webhooks", body = Problem, content_type = "application/problem+json")))]
pub async fn create(
    State(server): App,
    caller: Caller,
    body: Bytes,
) -> Result<(StatusCode, Json<WebhookView>), Problem> {
    webhooks::built()?;
    let new: NewWebhook =
        serde_json::from_slice(&body).map_err(|error| bad(format!("the body: {error}")))?;
    let url = server
        .targets
        .check(&new.url)
        .map_err(|error| match error.is_forbidden() {
            true => Problem::new(Kind::Forbidden, error.to_string()),
            false => bad(error.to_string()),
        })?;
    let known = Event::names();
    for event in &new.events {
        one_of("events", Some(event), &known)?;
    }
    let asked = |name: &&str| new.events.is_empty() || new.events.iter().any(|event| event == name);
    let events: Vec<&str> = known.iter().copied().filter(|name| asked(name)).collect();
    let secret = Secret::draw().map_err(Problem::internal)?;
    let row = WebhookRow {
        id: Uuid::now_v7(),
        url: url.to_string(),
        events: events.join(" "),
        secret: secret.text().to_owned(),
        created_at: now_ms(),
        outcome: None,
        tried_at: None,
    };
    let mut tx = server.db.begin().await?;
    if webhook::count(&mut tx, &caller.group).await? >= MOST {
        return Err(Problem::new(
            Kind::TooMany,
            format!("the group has {MOST} webhooks, the limit"),
        ));
    }
    webhook::insert(&mut tx, &caller.group, &row).await?;
    let subject = format!("{} {}", row.id, url.host_str().unwrap_or_default());
    audit::note(
        &mut tx,
        &caller.group,
        caller.actor(),
        "create webhook",
        &subject,
    )
    .await?;
    tx.commit().await?;
    let secret = Some(row.secret.clone());
    Ok((
        StatusCode::CREATED,
        Json(WebhookView {
            secret,
            ..row.into()
        }),
    ))
}

fn bad(detail: String) -> Problem {
    Problem::new(Kind::BadRequest, detail)
}
