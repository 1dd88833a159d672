use axum::Json;
use axum::extract::State;

use crate::api::App;
use crate::api::access::Caller;
use crate::api::extract::Path;
use crate::api::problem::Problem;
use crate::fleet::{self, BikeHistory};
use crate::store::bike;

/// Rides that are looked at.
pub const RIDES: i64 = 500;

/// History of a bicycle's stiffness and damping over its latest 500 rides.
///
/// Pooled over the rides, with their scatter, a trend and a test for a step.
#[utoipa::path(get, path = "/v1/bikes/{bike}/course", operation_id = "bike_course", tag = "fleet", params(("bike" = String, Path, min_length = 1)),
    responses(
        (status = 200, description = "One history per axle and parameter", body = BikeHistory),
        (status = 404, description = "No such bike", body = Problem, content_type = "application/problem+json")))]
pub async fn course(
    State(server): App,
    caller: Caller,
    Path(name): Path<String>,
) -> Result<Json<BikeHistory>, Problem> {
    if bike::find(&server.db, &caller.group, &name)
        .await?
        .is_none()
    {
        return Err(Problem::not_found("the bike"));
    }
    let history = fleet::history(&server.db, &caller.group, &name, RIDES).await?;
    Ok(Json(history))
}
