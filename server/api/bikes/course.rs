use axum::Json;
use axum::extract::State;

use super::existing;
use crate::api::App;
use crate::api::access::Caller;
use crate::api::extract::Path;
use crate::api::problem::Problem;
use crate::fleet::{self, BikeHistory};

/// History of a bicycle's stiffness and damping over its latest 200 rides, each by its newest job.
///
/// Pooled over the rides since the latest change, with steps, drifts and the level today.
#[utoipa::path(get, path = "/v1/bikes/{bike}/course", operation_id = "bike_course", tag = "fleet", params(("bike" = String, Path, min_length = 1)),
    responses(
        (status = 200, description = "One history per axle and parameter", body = BikeHistory),
        (status = 404, description = "No such bike", body = Problem, content_type = "application/problem+json")))]
pub async fn course(
    State(server): App,
    caller: Caller,
    Path(name): Path<String>,
) -> Result<Json<BikeHistory>, Problem> {
    existing(&server, &caller.group, &name).await?;
    let history = fleet::history(&server.db, &caller.group, &name).await?;
    Ok(Json(history))
}
