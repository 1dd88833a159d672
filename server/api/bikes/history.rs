use axum::extract::{OriginalUri, State};
use axum::response::Response;

use super::existing;
use crate::api::App;
use crate::api::access::Caller;
use crate::api::extract::{Path, Query};
use crate::api::list::Page;
use crate::api::long_readers::Reader;
use crate::api::parameter_view::ParameterView;
use crate::api::parameters::{OfBike, Params, respond};
use crate::api::problem::Problem;

/// Everything that was identified about a bicycle, newest first.
#[utoipa::path(get, path = "/v1/bikes/{bike}/history", operation_id = "bike_history", tag = "fleet",
    params(("bike" = String, Path, min_length = 1), OfBike),
    responses(
        (status = 200, description = "A page of parameters", content(
            (Page<ParameterView> = "application/json"), (String = "text/csv"), (Vec<u8> = "application/vnd.apache.parquet"))),
        (status = 400, description = "Malformed query", body = Problem, content_type = "application/problem+json"),
        (status = 404, description = "No such bike", body = Problem, content_type = "application/problem+json"),
        (status = 501, description = "The server is built without Parquet", body = Problem, content_type = "application/problem+json")))]
pub async fn history(
    State(server): App,
    caller: Caller,
    reader: Reader,
    OriginalUri(uri): OriginalUri,
    Path(name): Path<String>,
    Query(mut params): Query<Params>,
) -> Result<Response, Problem> {
    existing(&server, &caller.group, &name).await?;
    params.bike = Some(name);
    respond(&server, (caller, reader), &uri, params).await
}
