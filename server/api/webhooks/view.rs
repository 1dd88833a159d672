use serde::Serialize;
use utoipa::ToSchema;
use uuid::Uuid;

use crate::store::webhook::WebhookRow;
use crate::time;

/// A webhook: its address and events.
#[derive(Serialize, ToSchema)]
#[schema(as = Webhook)]
pub struct WebhookView {
    pub id: Uuid,
    pub url: String,
    pub events: Vec<String>,
    #[schema(format = DateTime)]
    pub created_at: String,
    /// Outcome of the last delivery attempt, in words.
    pub outcome: Option<String>,
    #[schema(format = DateTime)]
    pub tried_at: Option<String>,
    /// Secret for checking signatures; reported only once, on creation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub secret: Option<String>,
}

impl From<WebhookRow> for WebhookView {
    fn from(row: WebhookRow) -> Self {
        Self {
            id: row.id,
            url: row.url,
            events: row.events.split(' ').map(str::to_owned).collect(),
            created_at: time::text(row.created_at),
            outcome: row.outcome,
            tried_at: row.tried_at.map(time::text),
            secret: None,
        }
    }
}
