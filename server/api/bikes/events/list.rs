use axum::Json;
use axum::extract::State;

use crate::api::App;
use crate::api::access::Caller;
use crate::api::bikes::existing;
use crate::api::extract::Path;
use crate::api::problem::Problem;
use crate::fleet::BikeEvent;
use crate::store::bike_event;

/// What was done to a bicycle, oldest first.
#[utoipa::path(get, path = "/v1/bikes/{bike}/events", operation_id = "list_bike_events", tag = "fleet", params(("bike" = String, Path, min_length = 1)),
    responses(
        (status = 200, description = "All of its events, at most 500", body = Vec<BikeEvent>),
        (status = 404, description = "No such bike", body = Problem, content_type = "application/problem+json")))]
pub async fn list(
    State(server): App,
    caller: Caller,
    Path(name): Path<String>,
) -> Result<Json<Vec<BikeEvent>>, Problem> {
    existing(&server, &caller.group, &name).await?;
    let rows = bike_event::of_bike(&server.db, &caller.group, &name).await?;
    Ok(Json(rows.into_iter().map(BikeEvent::from).collect()))
}
