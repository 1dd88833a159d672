use axum::extract::{OriginalUri, State};
use axum::response::Response;
use serde::Deserialize;
use utoipa::IntoParams;
use uuid::Uuid;
use veloid_engine::report::diagnosis::Verdict;

use super::search::SearchParams;
use super::view::JobView;
use crate::api::App;
use crate::api::access::Caller;
use crate::api::extract::Query;
use crate::api::list::{Page, limit, without_cursor};
use crate::api::names;
use crate::api::problem::Problem;
use crate::store::job::{self, State as JobState};
use crate::time;

#[derive(Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub struct Params {
    /// Only jobs in this state.
    state: Option<JobState>,
    /// Only jobs of this bike.
    bike: Option<String>,
    /// Only jobs with this verdict.
    #[param(schema_with = names::verdicts)]
    verdict: Option<String>,
    /// Only jobs of this ride.
    ride: Option<Uuid>,
    /// Only jobs of rides with this tag.
    tag: Option<String>,
    /// Only jobs of rides whose name contains this text, ignoring case.
    name: Option<String>,
    /// Only jobs in which this effect was named.
    #[param(schema_with = names::effects)]
    effect: Option<String>,
    /// Ridden from this time on, inclusive (RFC 3339); uploaded, where it is not known when it was ridden. A day, such as
    /// 2026-09-01, counts whole (UTC).
    #[param(schema_with = time::schema)]
    from: Option<String>,
    /// Ridden before this time, exclusive (RFC 3339). A day counts whole. Not earlier than `from`.
    #[param(schema_with = time::schema)]
    to: Option<String>,
    /// Jobs that are deleted but not yet erased, instead of those that are not deleted.
    deleted: Option<bool>,
    /// Items per page; 50 by default.
    #[param(minimum = 1, maximum = 1000)]
    limit: Option<i64>,
    /// `next` of the previous page.
    cursor: Option<Uuid>,
}

/// Jobs, newest first.
#[utoipa::path(get, path = "/v1/jobs", operation_id = "list_jobs", tag = "jobs", params(Params, SearchParams),
    responses(
        (status = 200, description = "A page of jobs", body = Page<JobView>),
        (status = 400, description = "Malformed query", body = Problem, content_type = "application/problem+json")))]
pub async fn list(
    State(server): App,
    caller: Caller,
    OriginalUri(uri): OriginalUri,
    Query(params): Query<Params>,
    Query(search): Query<SearchParams>,
) -> Result<Response, Problem> {
    names::one_of("verdict", params.verdict.as_deref(), &Verdict::NAMES)?;
    names::one_of("effect", params.effect.as_deref(), &names::EFFECTS)?;
    let (from_ms, to_ms) = time::span(params.from.as_deref(), params.to.as_deref())?;
    let filter = job::Filter {
        group: &caller.group,
        state: params.state,
        bike: params.bike.as_deref(),
        verdict: params.verdict.as_deref(),
        ride: params.ride,
        of_one_ride: false,
        deleted: params.deleted.unwrap_or_default(),
        tag: params.tag.as_deref(),
        name: params.name.as_deref().filter(|name| !name.is_empty()),
        effect: params.effect.as_deref(),
        search: search.search()?,
        from_ms,
        to_ms,
        before: params.cursor,
    };
    let limit = limit(params.limit)?;
    let rows = job::page(&server.db, &filter, limit + 1).await?;
    let page = Page::cut(rows, limit, |row| row.id.to_string(), JobView::from);
    Ok(page.respond(&without_cursor(&uri)))
}
