//! A job's model on another ride.

use axum::Json;
use axum::body::Bytes;
use axum::extract::State;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use uuid::Uuid;
use veloid_engine::report::{IdentifiedModel, ModelOnRide, Report};

use super::access::Caller;
use super::jobs::report::published;
use super::jobs::view::no_such_job;
use super::problem::{Kind, Problem};
use super::rides::view::no_such_ride;
use super::{App, Server};
use crate::jobs::Purpose;
use crate::store::job;

/// A model and a ride to compare it with.
#[derive(Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct NewValidation {
    /// Id of the job whose model it is.
    pub model: Uuid,
    /// Id of the ride; it is read with the bicycle and the options of its newest job.
    pub ride: Uuid,
}

/// A job's model on another ride.
#[derive(Serialize, ToSchema)]
pub struct RideValidation {
    /// Id of the job whose model it is.
    pub model: Uuid,
    /// Id of the ride.
    pub ride: Uuid,
    /// Name of the ride's file.
    pub name: String,
    #[serde(flatten)]
    pub found: ModelOnRide,
}

/// Compares a job's model with another ride.
///
/// The model is simulated along the ride, from a start that is fitted to its first second; then its numbers are fitted to the ride, which shows
/// whether they differ by more than their intervals allow. Nothing is stored.
#[utoipa::path(post, path = "/v1/validations", operation_id = "validate_model", tag = "jobs", request_body = NewValidation,
    responses(
        (status = 200, description = "How well the model predicts the ride, and what differs", body = RideValidation),
        (status = 400, description = "Malformed body", body = Problem, content_type = "application/problem+json"),
        (status = 404, description = "No such job or ride", body = Problem, content_type = "application/problem+json"),
        (status = 409, description = "The job has no report (yet)", body = Problem, content_type = "application/problem+json"),
        (status = 410, description = "The ride's stored file is missing or was altered", body = Problem, content_type = "application/problem+json"),
        (status = 413, description = "It takes more memory than a job may have", body = Problem, content_type = "application/problem+json"),
        (status = 422, description = "Model and ride cannot be compared, or it takes too long", body = Problem, content_type = "application/problem+json"),
        (status = 500, description = "The stored report cannot be read", body = Problem, content_type = "application/problem+json"),
        (status = 501, description = "The server is built without spreadsheets", body = Problem, content_type = "application/problem+json"),
        (status = 503, description = "Too many requests of the group wait for files to be read, or that process was ended from outside; try again", body = Problem, content_type = "application/problem+json")))]
pub async fn create(
    State(server): App,
    caller: Caller,
    body: Bytes,
) -> Result<Json<RideValidation>, Problem> {
    let new: NewValidation = serde_json::from_slice(&body).map_err(|error| {
        Problem::new(
            Kind::BadRequest,
            format!(
                "the body: {error}; expected {{\"model\": JOB, \"ride\": RIDE}} with their ids"
            ),
        )
    })?;
    Ok(Json(validation(&server, &caller.group, &new).await?))
}

/// The comparison of a group's model with one of its rides.
pub async fn validation(
    server: &Server,
    group: &str,
    new: &NewValidation,
) -> Result<RideValidation, Problem> {
    let model = job::find(&server.db, group, new.model).await?;
    let model = model.ok_or_else(no_such_job)?;
    if let state @ (job::State::Failed | job::State::Cancelled) = model.state {
        let detail = format!("the job is {}: it has no model", state.name());
        return Err(Problem::new(Kind::NotFinished, detail));
    }
    let report: Report = published(&server.db, new.model, model.study.is_some())
        .await?
        .parse()?;
    let filter = job::Filter {
        group,
        ride: Some(new.ride),
        of_one_ride: true,
        ..job::Filter::default()
    };
    let newest = job::page(&server.db, &filter, 1).await?.into_iter().next();
    let job = newest.ok_or_else(no_such_ride)?;
    let (reader, files) = server.rides.open(&job, Purpose::Request).await?;
    let sources = files.iter().map(|(source, _)| source.clone()).collect();
    let model = IdentifiedModel::of(report);
    let found = reader.comparison(sources, job.request.0, model).await?;
    Ok(RideValidation {
        model: new.model,
        ride: new.ride,
        name: job.ride_name,
        found,
    })
}
