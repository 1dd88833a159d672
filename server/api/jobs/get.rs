use std::time::Duration;

use axum::Json;
use axum::extract::State;
use axum::http::{HeaderMap, header};
use axum::response::Response;
use serde::Deserialize;
use tokio::sync::broadcast::Receiver;
use tokio::time::Instant;
use utoipa::IntoParams;
use uuid::Uuid;

use super::view::{JobView, find, no_such_job};
use crate::api::access::Caller;
use crate::api::extract::{Path, Query, etag, matches, not_modified, tagged};
use crate::api::problem::{Kind, Problem};
use crate::api::{App, Server};
use crate::jobs::HubEvent;
use crate::store::job;

/// Longest that a request is held (s).
const LONGEST: f64 = 60.0;
/// How often the database is asked for what other processes did.
const LOOK: Duration = Duration::from_millis(500);

#[derive(Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub struct Params {
    /// Wait at most this many seconds (up to 60) until the job differs from the ETag in `If-None-Match` or, without one, until
    /// it has ended.
    #[param(minimum = 0)]
    wait: Option<f64>,
}

/// State of a job.
#[utoipa::path(get, path = "/v1/jobs/{id}", operation_id = "get_job", tag = "jobs",
    params(("id" = Uuid, Path), Params,
        ("If-None-Match" = Option<String>, Header, description = "ETag of an earlier response")),
    responses(
        (status = 200, description = "The job", body = JobView, headers(("ETag" = String))),
        (status = 304, description = "Not changed"),
        (status = 400, description = "Malformed query", body = Problem, content_type = "application/problem+json"),
        (status = 404, description = "No such job", body = Problem, content_type = "application/problem+json")))]
pub async fn get(
    State(server): App,
    caller: Caller,
    Path(id): Path<Uuid>,
    Query(params): Query<Params>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let wait = params.wait.unwrap_or(0.0);
    if !(0.0..f64::INFINITY).contains(&wait) {
        let detail = format!("wait: {wait}, expected a number of seconds");
        return Err(Problem::new(Kind::BadRequest, detail));
    }
    let until = Instant::now() + Duration::from_secs_f64(wait.min(LONGEST));
    let revision = settled(&server, &caller.group, id, &headers, until).await?;
    let tag = etag(revision);
    if matches(&headers, &tag) {
        return Ok(not_modified(&tag));
    }
    let view: JobView = find(&server.db, &caller.group, id).await?;
    Ok(tagged(&etag(view.revision), Json(view)))
}

/// The revision once it is worth an answer, or when the time is up.
async fn settled(
    server: &Server,
    group: &str,
    id: Uuid,
    headers: &HeaderMap,
    until: Instant,
) -> Result<i64, Problem> {
    let conditional = headers.contains_key(header::IF_NONE_MATCH);
    let mut changes = server.hub.subscribe(id, None).receiver;
    loop {
        let (revision, is_final) = job::revision(&server.db, group, id)
            .await?
            .ok_or_else(no_such_job)?;
        let news = conditional && !matches(headers, &etag(revision));
        if news || is_final || Instant::now() >= until {
            return Ok(revision);
        }
        tokio::select! {
            () = changed(&mut changes) => {}
            () = tokio::time::sleep_until(until.min(Instant::now() + LOOK)) => {}
            () = server.stop.cancelled() => return Ok(revision),
        }
    }
}

/// Returns when the job's row may have changed; the swarm's iterations do not change it.
async fn changed(changes: &mut Receiver<HubEvent>) {
    while let Ok(HubEvent::Iteration { .. }) = changes.recv().await {}
}
