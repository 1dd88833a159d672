use axum::Json;
use axum::extract::State;

use super::view::BikeView;
use crate::api::App;
use crate::api::access::Caller;
use crate::api::extract::Path;
use crate::api::problem::Problem;
use crate::erasure;
use crate::store::bike;

/// Restores a deleted bicycle with the jobs that were deleted with it and are not erased.
#[utoipa::path(post, path = "/v1/bikes/{bike}/restore", operation_id = "restore_bike", tag = "fleet", params(("bike" = String, Path, min_length = 1)),
    responses(
        (status = 200, description = "Restored", body = BikeView),
        (status = 404, description = "No deleted bike of this name", body = Problem, content_type = "application/problem+json")))]
pub async fn restore(
    State(server): App,
    caller: Caller,
    Path(name): Path<String>,
) -> Result<Json<BikeView>, Problem> {
    let missing = || Problem::not_found("a deleted bike of this name");
    if name.contains('\0') {
        return Err(missing());
    }
    let mut tx = server.db.begin().await?;
    if !erasure::restore_bike(&mut tx, &caller.group, &name, caller.actor()).await? {
        return Err(missing());
    }
    tx.commit().await?;
    let row = bike::find(&server.db, &caller.group, &name).await?;
    Ok(Json(BikeView::from(row.ok_or_else(missing)?)))
}
