use axum::Json;
use axum::extract::State;
use axum::http::header;
use axum::response::{IntoResponse, Response};
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};
use uuid::Uuid;
use veloid_engine::bicycle::PerAxle;
use veloid_engine::report::diagnosis::EffectReport;
use veloid_engine::report::{Estimate, Report};

use super::matlab;
use super::report::published;
use super::view::no_such_job;
use crate::api::App;
use crate::api::access::Caller;
use crate::api::extract::{Path, Query};
use crate::api::problem::Problem;
use crate::store::job;

const EQUATION: &str = "m z'' = k (u - z) + B (u' - z') + F; where a rig prescribes the deflection d (mass 0): F = k d + B d' + constant";

#[derive(Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub struct Params {
    #[param(inline)]
    format: Option<ModelFormat>,
}

/// `json` unless asked otherwise.
#[derive(Clone, Copy, Default, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum ModelFormat {
    #[default]
    Json,
    Matlab,
}

/// The identified model, to simulate with.
#[derive(Serialize, ToSchema)]
pub struct IdentifiedModel {
    /// Version of veloid that identified it.
    pub veloid: String,
    pub bike: String,
    /// Equation of each axle; u road, z displacement, F applied force, all up; on a rig F is what was measured.
    #[schema(value_type = String)]
    pub equation: &'static str,
    /// Output error: the plain model at its best.
    pub plain: PerAxle<Estimate>,
    /// Stiffness and damping with the effects in the model.
    pub extended: Option<PerAxle<Estimate>>,
    /// What is added to the plain model; docs/method.md has the laws.
    pub effects: Vec<EffectReport>,
}

/// The identified model, as JSON or as a MATLAB script that simulates the plain model along the ride.
#[utoipa::path(get, path = "/v1/jobs/{id}/model", operation_id = "get_model", tag = "jobs", params(("id" = Uuid, Path), Params),
    responses(
        (status = 200, description = "The model", content((IdentifiedModel = "application/json"), (String = "text/x-matlab"))),
        (status = 400, description = "Malformed query", body = Problem, content_type = "application/problem+json"),
        (status = 404, description = "No such job", body = Problem, content_type = "application/problem+json"),
        (status = 409, description = "The job has no report (yet)", body = Problem, content_type = "application/problem+json")))]
pub async fn model(
    State(server): App,
    caller: Caller,
    Path(id): Path<Uuid>,
    Query(params): Query<Params>,
) -> Result<Response, Problem> {
    let job = job::find(&server.db, &caller.group, id)
        .await?
        .ok_or_else(no_such_job)?;
    let text = published(&server.db, id).await?;
    let report: Report = serde_json::from_str(&text).map_err(Problem::internal)?;
    match params.format.unwrap_or_default() {
        ModelFormat::Json => Ok(Json(IdentifiedModel::of(report)).into_response()),
        ModelFormat::Matlab => {
            let headers = [
                (header::CONTENT_TYPE, "text/x-matlab; charset=utf-8"),
                (
                    header::CONTENT_DISPOSITION,
                    "attachment; filename=\"veloid_model.m\"",
                ),
            ];
            Ok((headers, matlab::script(&report, &job.ride_name)).into_response())
        }
    }
}

impl IdentifiedModel {
    fn of(report: Report) -> Self {
        let plain = match &report.latent_road {
            Some(latent) if report.has_no_road() => latent.axles(),
            _ => report.output_error,
        };
        let (extended, effects) = match report.diagnosis {
            Some(d) if !d.effects.is_empty() => (Some(d.extended), d.effects),
            _ => (None, Vec::new()),
        };
        Self {
            veloid: report.veloid,
            bike: report.bike.bike,
            equation: EQUATION,
            plain,
            extended,
            effects,
        }
    }
}
