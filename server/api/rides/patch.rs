use axum::Json;
use axum::body::{Body, to_bytes};
use axum::extract::State;
use serde_json::{Map, Value};
use uuid::Uuid;

use super::view::{RideView, find, no_such_ride};
use crate::api::access::Caller;
use crate::api::extract::Path;
use crate::api::problem::{Kind, Problem};
use crate::api::{App, Server};
use crate::facts::{self, Facts};
use crate::store::audit;
use crate::store::deletion::{self, Of};
use crate::store::facts as stored;

/// Most that a patch may hold (bytes).
const MOST: usize = 64 << 10;

/// Changes the facts of a ride.
///
/// A merge patch (RFC 7396): each fact it names is replaced, null removes it, all others are unchanged. Trends and steps of the
/// bicycle are updated at once.
#[utoipa::path(patch, path = "/v1/rides/{id}", operation_id = "patch_ride", tag = "rides", params(("id" = Uuid, Path)),
    request_body(content((Facts = "application/merge-patch+json"), (Facts = "application/json"))),
    responses(
        (status = 200, description = "Changed", body = RideView),
        (status = 400, description = "Malformed request", body = Problem, content_type = "application/problem+json"),
        (status = 404, description = "No such ride, or it is deleted", body = Problem, content_type = "application/problem+json"),
        (status = 413, description = "Too large", body = Problem, content_type = "application/problem+json"),
        (status = 422, description = "A fact is not allowed", body = Problem, content_type = "application/problem+json")))]
pub async fn patch(
    State(server): App,
    caller: Caller,
    Path(id): Path<Uuid>,
    body: Body,
) -> Result<Json<RideView>, Problem> {
    let view = present(&server, &caller, id).await?;
    let body = to_bytes(body, MOST).await.map_err(|error| {
        Problem::new(
            Kind::TooLarge,
            format!("{error}: expected at most {MOST} bytes"),
        )
    })?;
    let text = std::str::from_utf8(&body)
        .map_err(|_| Problem::new(Kind::BadRequest, "the patch is not UTF-8"))?;
    let mut patch = Map::new();
    facts::from_json(&mut patch, text)?;
    change(&server, &caller, view, patch).await?;
    Ok(Json(find(&server, &caller.group, id).await?))
}

/// The caller's ride, unless it is deleted.
pub async fn present(server: &Server, caller: &Caller, id: Uuid) -> Result<RideView, Problem> {
    let view = find(server, &caller.group, id).await?;
    match view.deleted_at {
        None => Ok(view),
        Some(_) => Err(no_such_ride()),
    }
}

/// Changes what a patch names.
pub async fn change(
    server: &Server,
    caller: &Caller,
    ride: RideView,
    patch: Map<String, Value>,
) -> Result<(), Problem> {
    let (group, id) = (&caller.group, ride.id);
    let names: Vec<String> = patch.keys().cloned().collect();
    let mut tx = server.db.begin().await?;
    deletion::lock(&mut tx, group, Of::Ride(id)).await?;
    let known = stored::of_ride(&mut tx, id).await?.patched(patch)?;
    stored::put(&mut tx, id, &known).await?;
    let subject = format!("ride {id}: {}", names.join(", "));
    audit::note(&mut tx, group, caller.actor(), "change", &subject).await?;
    tx.commit().await?;
    for job in ride.jobs {
        server.hub.changed(job.id);
    }
    Ok(())
}
