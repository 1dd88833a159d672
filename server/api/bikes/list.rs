use axum::extract::{OriginalUri, State};
use axum::response::Response;
use serde::Deserialize;
use utoipa::IntoParams;

use super::view::BikeView;
use crate::api::App;
use crate::api::access::Caller;
use crate::api::extract::Query;
use crate::api::list::{Page, limit, without_cursor};
use crate::api::problem::Problem;
use crate::store::bike;

#[derive(Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub struct Params {
    /// Items per page; 50 by default.
    #[param(minimum = 1, maximum = 1000)]
    limit: Option<i64>,
    /// `next` of the previous page.
    cursor: Option<String>,
}

/// The fleet, by name.
#[utoipa::path(get, path = "/v1/bikes", operation_id = "list_bikes", tag = "fleet", params(Params),
    responses(
        (status = 200, description = "A page of bikes", body = Page<BikeView>),
        (status = 400, description = "Malformed query", body = Problem, content_type = "application/problem+json")))]
pub async fn list(
    State(server): App,
    caller: Caller,
    OriginalUri(uri): OriginalUri,
    Query(params): Query<Params>,
) -> Result<Response, Problem> {
    let after = params.cursor.unwrap_or_default();
    let limit = limit(params.limit)?;
    let rows = bike::page(&server.db, &caller.group, &after, limit + 1).await?;
    let cursor = |row: &bike::BikeRow| row.name.clone();
    let page = Page::cut(rows, limit, cursor, BikeView::from);
    Ok(page.respond(&without_cursor(&uri)))
}
