use axum::Json;
use axum::extract::State;
use serde::Serialize;
use utoipa::ToSchema;
use uuid::Uuid;

use crate::api::access::Caller;
use crate::api::extract::Path;
use crate::api::jobs::view::JobView;
use crate::api::list::MOST;
use crate::api::problem::Problem;
use crate::api::{App, time};
use crate::store::ride::TOLD;
use crate::store::{job, ride};

/// An uploaded ride.
#[derive(Serialize, ToSchema)]
pub struct RideView {
    pub id: Uuid,
    /// Name of the file as its sender calls it.
    pub name: String,
    /// Null, as the file's address, of a ride that `veloid seed` made up.
    pub sha256: Option<String>,
    pub bytes: i64,
    #[schema(format = DateTime)]
    pub uploaded_at: String,
    /// Address of the bytes.
    pub file: Option<String>,
    /// Its identifications, newest first.
    pub jobs: Vec<JobView>,
}

/// An uploaded ride and its identifications.
#[utoipa::path(get, path = "/v1/rides/{id}", operation_id = "get_ride", tag = "rides", params(("id" = Uuid, Path)),
    responses(
        (status = 200, description = "The ride", body = RideView),
        (status = 404, description = "No such ride", body = Problem, content_type = "application/problem+json")))]
pub async fn get(
    State(server): App,
    caller: Caller,
    Path(id): Path<Uuid>,
) -> Result<Json<RideView>, Problem> {
    let ride = ride::find(&server.db, &caller.group, id)
        .await?
        .ok_or_else(|| Problem::not_found("the ride"))?;
    let filter = job::Filter {
        group: &caller.group,
        ride: Some(id),
        ..job::Filter::default()
    };
    let jobs = job::page(&server.db, &filter, MOST).await?;
    let filed = ride.sha256 != TOLD;
    Ok(Json(RideView {
        file: filed.then(|| format!("/v1/rides/{id}/file")),
        id,
        name: ride.name,
        sha256: filed.then_some(ride.sha256),
        bytes: ride.bytes,
        uploaded_at: time::text(ride.uploaded_at),
        jobs: jobs.into_iter().map(JobView::from).collect(),
    }))
}
