use axum::extract::State;
use axum::http::{HeaderMap, header};
use axum::response::{IntoResponse, Response};
use uuid::Uuid;
use veloid_engine::report::Report;

use super::view::no_such_job;
use crate::api::App;
use crate::api::access::Caller;
use crate::api::extract::{Path, etag, matches, not_modified, tagged};
use crate::api::problem::{Kind, Problem};
use crate::store::result::Document;
use crate::store::{Db, job, result};

/// The report, as `veloid identify --json` writes it, number for number; of a study a `StudyReport`, as `veloid study --json` writes it.
#[utoipa::path(get, path = "/v1/jobs/{id}/report", operation_id = "get_report", tag = "jobs", params(("id" = Uuid, Path)),
    responses(
        (status = 200, description = "The report", body = Report),
        (status = 304, description = "Not changed"),
        (status = 404, description = "No such job", body = Problem, content_type = "application/problem+json"),
        (status = 409, description = "The job has no report (yet)", body = Problem, content_type = "application/problem+json"),
        (status = 500, description = "The stored report cannot be read", body = Problem, content_type = "application/problem+json")))]
pub async fn report(
    State(server): App,
    caller: Caller,
    Path(id): Path<Uuid>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let (revision, _) = job::revision(&server.db, &caller.group, id)
        .await?
        .ok_or_else(no_such_job)?;
    let tag = etag(revision);
    if matches(&headers, &tag) {
        return Ok(not_modified(&tag));
    }
    let Document { text, .. } = stored(&server.db, id).await?;
    let json = [(header::CONTENT_TYPE, "application/json")];
    Ok(tagged(&tag, (json, text).into_response()))
}

/// The report on one ride, or the problem that the job has none (yet).
pub async fn published(db: &Db, job: Uuid, is_study: bool) -> Result<Document, Problem> {
    if is_study {
        let detail = "the job identifies several rides as one: it has a report, but neither a model nor curves";
        return Err(Problem::new(Kind::WrongState, detail));
    }
    stored(db, job).await
}

/// The job's report, of one ride or of several.
pub async fn stored(db: &Db, job: Uuid) -> Result<Document, Problem> {
    let report = result::find(db, job, result::REPORT).await?;
    report.ok_or_else(|| {
        Problem::new(
            Kind::NotFinished,
            "the report is available once the job has succeeded; until then the job contains the least-squares estimate",
        )
    })
}
