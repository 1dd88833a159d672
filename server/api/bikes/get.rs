use axum::Json;
use axum::extract::State;

use super::existing;
use super::view::BikeView;
use crate::api::App;
use crate::api::access::Caller;
use crate::api::extract::Path;
use crate::api::problem::Problem;

/// One bicycle of the fleet.
#[utoipa::path(get, path = "/v1/bikes/{bike}", operation_id = "get_bike", tag = "fleet", params(("bike" = String, Path, min_length = 1)),
    responses(
        (status = 200, description = "The bike", body = BikeView),
        (status = 404, description = "No such bike", body = Problem, content_type = "application/problem+json")))]
pub async fn get(
    State(server): App,
    caller: Caller,
    Path(name): Path<String>,
) -> Result<Json<BikeView>, Problem> {
    let row = existing(&server, &caller.group, &name).await?;
    Ok(Json(BikeView::from(row)))
}
