//! Uploads that were refused.

use std::sync::Arc;

use axum::extract::{OriginalUri, State};
use axum::response::Response;
use serde::Serialize;
use utoipa::ToSchema;
use uuid::Uuid;

use crate::api::access::Caller;
use crate::api::extract::Query;
use crate::api::list::{Older, Page, limit, without_cursor};
use crate::api::problem::{Kind, Problem};
use crate::api::{App, Server};
use crate::bicycle::Given;
use crate::store::refused::{self, NewRefusal, RefusedRow};
use crate::time;

/// An upload that was not taken, and what it said of its bicycle, for a form to show it again.
pub struct Refused {
    pub problem: Problem,
    pub bicycle: Given,
    /// Name of the ride, if its files had arrived.
    pub file: Option<String>,
}

/// A refused upload.
#[derive(Serialize, ToSchema)]
#[schema(as = RefusedUpload)]
pub struct RefusedView {
    pub id: Uuid,
    #[schema(format = DateTime)]
    pub refused_at: String,
    /// `key`, or `keyless` on a server without keys.
    pub actor: String,
    /// Id of the key.
    pub key: Option<Uuid>,
    /// Name of the file, if one had arrived.
    pub file: Option<String>,
    /// Name of the bicycle, if it was given.
    pub bike: Option<String>,
    /// The `type` of the problem that was answered.
    pub problem: String,
    /// HTTP status of the answer.
    pub status: i64,
    pub detail: String,
}

impl From<RefusedRow> for RefusedView {
    fn from(row: RefusedRow) -> Self {
        Self {
            id: row.id,
            refused_at: time::text(row.refused_at),
            actor: row.actor,
            key: row.key_id,
            file: row.file,
            bike: row.bike,
            problem: row.kind,
            status: row.status,
            detail: row.detail,
        }
    }
}

/// Uploads of the caller's group that were refused within the last seven days for what they held (status 400, 413 or 422), with
/// sender, time and reason; the newest 1000, newest first.
#[utoipa::path(get, path = "/v1/rides/refused", operation_id = "list_refused_uploads", tag = "rides", params(Older),
    responses(
        (status = 200, description = "A page of refused uploads", body = Page<RefusedView>),
        (status = 400, description = "Malformed query", body = Problem, content_type = "application/problem+json")))]
pub async fn list(
    State(server): App,
    caller: Caller,
    OriginalUri(uri): OriginalUri,
    Query(params): Query<Older>,
) -> Result<Response, Problem> {
    let limit = limit(params.limit)?;
    let rows = refused::page(&server.db, &caller.group, params.cursor, limit + 1).await?;
    let page = Page::cut(rows, limit, |row| row.id.to_string(), RefusedView::from);
    Ok(page.respond(&without_cursor(&uri)))
}

/// Stores a refusal, if the upload itself was the reason. The answer does not depend on it.
pub async fn note(server: &Arc<Server>, caller: &Caller, refused: &Refused) {
    let of_upload = [
        Kind::BadRequest,
        Kind::TooLarge,
        Kind::UnreadableRide,
        Kind::BadBike,
        Kind::BadOption,
        Kind::BadFact,
        Kind::IdempotencyKeyReused,
    ];
    let problem = &refused.problem;
    if !of_upload.contains(&problem.kind) {
        return;
    }
    let (bike, kind) = (refused.bicycle.name(), problem.kind.urn());
    let refusal = NewRefusal {
        group: &caller.group,
        actor: caller.actor(),
        file: refused.file.as_deref(),
        bike: bike.as_deref(),
        kind: &kind,
        status: problem.status.into(),
        // PostgreSQL stores no NUL.
        detail: &problem.detail.replace('\0', "\u{fffd}"),
    };
    let stored = async {
        let mut tx = server.db.begin_lax().await?;
        refused::insert(&mut tx, &refusal).await?;
        tx.commit().await
    };
    if let Err(error) = stored.await {
        tracing::warn!(%error, "a refused upload could not be listed");
    }
}
