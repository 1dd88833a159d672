use axum::Json;
use axum::extract::State;
use axum::http::HeaderMap;
use axum::response::Response;
use serde::Deserialize;
use utoipa::IntoParams;
use uuid::Uuid;
use veloid_engine::replay::{Quantity, Window};

use super::report::published;
use super::view::no_such_job;
use crate::api::App;
use crate::api::access::Caller;
use crate::api::extract::{Path, Query, etag, matches, not_modified, tagged};
use crate::api::problem::{Kind, Problem};
use crate::jobs::{Drawing, Purpose};
use crate::store::job;

const POINTS: usize = 2000;
const MOST_POINTS: usize = 100_000;

#[derive(Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub struct Params {
    /// Start of the part to show (s); by default the start of the ride.
    t0: Option<f64>,
    /// End of the part to show (s), not before `t0`; by default the end of the ride.
    t1: Option<f64>,
    /// Approximate number of values per curve, 2000 by default; longer curves are thinned to the smallest and largest value of
    /// each stretch.
    #[param(minimum = 2, maximum = 100_000)]
    points: Option<usize>,
    /// `displacement` by default.
    quantity: Option<Quantity>,
}

/// Measured and simulated motion of both axles, and the residual.
#[utoipa::path(get, path = "/v1/jobs/{id}/series", operation_id = "get_series", tag = "jobs", params(("id" = Uuid, Path), Params),
    responses(
        (status = 200, description = "Curves by axle and name", body = Window),
        (status = 304, description = "Not changed"),
        (status = 400, description = "Malformed query", body = Problem, content_type = "application/problem+json"),
        (status = 404, description = "No such job", body = Problem, content_type = "application/problem+json"),
        (status = 410, description = "The ride's stored file is missing or was altered", body = Problem, content_type = "application/problem+json"),
        (status = 409, description = "The job has no report (yet)", body = Problem, content_type = "application/problem+json"),
        (status = 413, description = "The series needs more memory than a job may use", body = Problem, content_type = "application/problem+json"),
        (status = 422, description = "Computing the series takes too long or crashes its process", body = Problem, content_type = "application/problem+json"),
        (status = 500, description = "The stored report cannot be read", body = Problem, content_type = "application/problem+json"),
        (status = 501, description = "The server is built without spreadsheets", body = Problem, content_type = "application/problem+json"),
        (status = 503, description = "Too many requests of the group wait for files to be read, or the process was killed from outside; try again", body = Problem, content_type = "application/problem+json")))]
pub async fn series(
    State(server): App,
    caller: Caller,
    Path(id): Path<Uuid>,
    Query(params): Query<Params>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let points = params.points.unwrap_or(POINTS);
    if !(2..=MOST_POINTS).contains(&points) {
        let detail = format!("points: {points}, expected 2 to {MOST_POINTS}");
        return Err(Problem::new(Kind::BadRequest, detail));
    }
    let end = |name: &str, t: Option<f64>| match t {
        Some(t) if !t.is_finite() => {
            let detail = format!("{name}: {t}, expected a number of seconds");
            Err(Problem::new(Kind::BadRequest, detail))
        }
        _ => Ok(t),
    };
    let (t0, t1) = (end("t0", params.t0)?, end("t1", params.t1)?);
    if let (Some(t0), Some(t1)) = (t0, t1)
        && t0 > t1
    {
        let detail = format!("t0: {t0} s is later than t1: {t1} s");
        return Err(Problem::new(Kind::BadRequest, detail));
    }
    let job = job::find(&server.db, &caller.group, id)
        .await?
        .ok_or_else(no_such_job)?;
    let tag = etag(job.revision);
    if matches(&headers, &tag) {
        return Ok(not_modified(&tag));
    }
    let drawing = Drawing {
        job: job.id,
        revision: job.revision,
        report: published(&server.db, job.id, job.study.is_some())
            .await?
            .text,
        quantity: params.quantity.unwrap_or_default(),
        t0,
        t1,
        points,
    };
    let (reader, files) = server.rides.open(&job, Purpose::Request).await?;
    let sources = files.iter().map(|(source, _)| source.clone()).collect();
    let window: Window = reader.window(sources, job.request.0, drawing).await?;
    Ok(tagged(&tag, Json(window)))
}
