//! Who did what, and when.

use axum::extract::{OriginalUri, State};
use axum::response::Response;
use serde::Serialize;
use utoipa::ToSchema;
use uuid::Uuid;

use super::App;
use super::access::Caller;
use super::extract::Query;
use super::list::{Older, Page, limit, without_cursor};
use super::problem::Problem;
use crate::store::audit::{self, AuditRow};
use crate::time;

/// A recorded action.
#[derive(Serialize, ToSchema)]
#[schema(as = Deed)]
pub struct DeedView {
    pub id: Uuid,
    #[schema(format = DateTime)]
    pub done_at: String,
    /// `key`, `keyless` (a server without keys), `server` (automatically) or `command` (the operator's).
    pub actor: String,
    /// Id of the key.
    pub key: Option<Uuid>,
    /// `delete`, `restore`, `erase`, or `change` of a ride's facts.
    pub action: String,
    /// The object of the action, in words.
    pub subject: String,
}

impl From<AuditRow> for DeedView {
    fn from(row: AuditRow) -> Self {
        Self {
            id: row.id,
            done_at: time::text(row.done_at),
            actor: row.actor,
            key: row.key_id,
            action: row.action,
            subject: row.subject,
        }
    }
}

/// Deletions, restorations, erasures and changes in the caller's group, with actor and time; newest first.
#[utoipa::path(get, path = "/v1/audit", operation_id = "list_audit", tag = "operations", params(Older),
    responses(
        (status = 200, description = "A page of recorded actions", body = Page<DeedView>),
        (status = 400, description = "Malformed query", body = Problem, content_type = "application/problem+json")))]
pub async fn list(
    State(server): App,
    caller: Caller,
    OriginalUri(uri): OriginalUri,
    Query(params): Query<Older>,
) -> Result<Response, Problem> {
    let limit = limit(params.limit)?;
    let rows = audit::page(&server.db, &caller.group, params.cursor, limit + 1).await?;
    let page = Page::cut(rows, limit, |row| row.id.to_string(), DeedView::from);
    Ok(page.respond(&without_cursor(&uri)))
}
