use axum::extract::State;
use axum::http::StatusCode;

use crate::api::App;
use crate::api::access::Caller;
use crate::api::extract::Path;
use crate::api::problem::Problem;
use crate::api::rides::delete::remove;
use crate::store::deletion::Of;

/// Deletes a bicycle and the jobs of all its rides.
///
/// Works like the deletion of a ride; a ride that was also identified for another bicycle remains with that one.
#[utoipa::path(delete, path = "/v1/bikes/{bike}", operation_id = "delete_bike", tag = "fleet", params(("bike" = String, Path, min_length = 1)),
    responses(
        (status = 204, description = "Deleted; `POST /v1/bikes/{bike}/restore` restores it during the days of grace"),
        (status = 404, description = "No such bike", body = Problem, content_type = "application/problem+json")))]
pub async fn delete(
    State(server): App,
    caller: Caller,
    Path(name): Path<String>,
) -> Result<StatusCode, Problem> {
    let missing = || Problem::not_found("the bike");
    // No name holds a NUL, and PostgreSQL refuses to be asked for one.
    if name.contains('\0') {
        return Err(missing());
    }
    remove(&server, &caller, Of::Bike(&name), missing).await?;
    Ok(StatusCode::NO_CONTENT)
}
