use axum::Json;
use axum::extract::State;
use axum::http::header;
use axum::response::{IntoResponse, Response};
use serde::Deserialize;
use utoipa::IntoParams;
use uuid::Uuid;
use veloid_engine::report::Report;

use super::report::published;
use super::view::no_such_job;
use crate::api::App;
use crate::api::access::Caller;
use crate::api::extract::{Path, Query};
use crate::api::problem::Problem;
use crate::export::{self, Format, IdentifiedModel};
use crate::jobs::Purpose;
use crate::store::job;

#[derive(Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub struct Params {
    /// `json` unless asked otherwise.
    #[param(inline)]
    format: Option<Format>,
}

/// The identified model with its effects, as JSON or as a script for MATLAB, Octave or Python that simulates it along the ride, and the ride for
/// such a script.
#[utoipa::path(get, path = "/v1/jobs/{id}/model", operation_id = "get_model", tag = "jobs", params(("id" = Uuid, Path), Params),
    responses(
        (status = 200, description = "The model", content((IdentifiedModel = "application/json"), (String = "text/x-matlab"), (String = "text/x-python"), (String = "text/csv"))),
        (status = 400, description = "Malformed query", body = Problem, content_type = "application/problem+json"),
        (status = 404, description = "No such job", body = Problem, content_type = "application/problem+json"),
        (status = 409, description = "The job has no report (yet), or its report no model that a script could simulate", body = Problem, content_type = "application/problem+json"),
        (status = 410, description = "The ride's stored file is missing or was altered", body = Problem, content_type = "application/problem+json"),
        (status = 413, description = "It takes more memory than a job may have", body = Problem, content_type = "application/problem+json"),
        (status = 422, description = "Reading the ride takes too long, or ends the process that does it", body = Problem, content_type = "application/problem+json"),
        (status = 500, description = "The stored report cannot be read", body = Problem, content_type = "application/problem+json"),
        (status = 501, description = "The server is built without spreadsheets", body = Problem, content_type = "application/problem+json"),
        (status = 503, description = "Too many requests of the group wait for files to be read, or that process was ended from outside; try again", body = Problem, content_type = "application/problem+json")))]
pub async fn model(
    State(server): App,
    caller: Caller,
    Path(id): Path<Uuid>,
    Query(params): Query<Params>,
) -> Result<Response, Problem> {
    let job = job::find(&server.db, &caller.group, id)
        .await?
        .ok_or_else(no_such_job)?;
    let report: Report = published(&server.db, id, job.study.is_some())
        .await?
        .parse()?;
    let format = params.format.unwrap_or_default();
    let body = match format {
        Format::Json => return Ok(Json(IdentifiedModel::of(report)).into_response()),
        Format::Matlab => export::matlab(&report, &job.ride_name)?,
        Format::Python => export::python(&report, &job.ride_name)?,
        Format::Csv => {
            let (reader, files) = server.rides.open(&job, Purpose::Request).await?;
            let sources = files.iter().map(|(source, _)| source.clone()).collect();
            let ride = reader.ride(sources, job.request.0).await?;
            let written = tokio::task::spawn_blocking(move || export::table(&ride));
            written.await.map_err(Problem::internal)?
        }
    };
    let [kind, name] = format.media();
    let disposition = format!("attachment; filename=\"{name}\"");
    let headers = [
        (header::CONTENT_TYPE, kind.to_owned()),
        (header::CONTENT_DISPOSITION, disposition),
    ];
    Ok((headers, body).into_response())
}
