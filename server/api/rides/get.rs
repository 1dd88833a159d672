use axum::Json;
use axum::extract::State;
use uuid::Uuid;

use super::view::{RideView, find};
use crate::api::App;
use crate::api::access::Caller;
use crate::api::extract::Path;
use crate::api::problem::Problem;

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
    Ok(Json(find(&server, &caller.group, id).await?))
}
