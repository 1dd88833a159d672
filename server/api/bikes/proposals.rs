use axum::Json;
use axum::extract::State;

use super::existing;
use crate::api::App;
use crate::api::access::Caller;
use crate::api::extract::Path;
use crate::api::problem::Problem;
use crate::fleet::{self, ProposedRide};

/// Rides that the reports of a bicycle's rides propose, the latest ride's first, and whether a study has settled what was open.
///
/// A later ride that is as proposed (speed and roughness are compared) is identified as one with the ride that asked, by itself, unless the
/// server runs with `--study-after 0`.
#[utoipa::path(get, path = "/v1/bikes/{bike}/proposals", operation_id = "list_proposed_rides", tag = "fleet", params(("bike" = String, Path, min_length = 1)),
    responses(
        (status = 200, description = "The latest, at most 50", body = Vec<ProposedRide>),
        (status = 404, description = "No such bike", body = Problem, content_type = "application/problem+json")))]
pub async fn list(
    State(server): App,
    caller: Caller,
    Path(name): Path<String>,
) -> Result<Json<Vec<ProposedRide>>, Problem> {
    existing(&server, &caller.group, &name).await?;
    let found = fleet::proposals(&server.db, &caller.group, &name).await?;
    Ok(Json(found))
}
