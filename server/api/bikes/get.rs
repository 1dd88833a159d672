use axum::Json;
use axum::extract::State;

use super::view::BikeView;
use crate::api::App;
use crate::api::access::Caller;
use crate::api::extract::Path;
use crate::api::problem::Problem;
use crate::store::bike;

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
    let row = bike::find(&server.db, &caller.group, &name).await?;
    let row = row.ok_or_else(|| Problem::not_found("the bike"))?;
    Ok(Json(BikeView::from(row)))
}
