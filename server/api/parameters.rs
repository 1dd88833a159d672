//! Every identified parameter of every ride, as JSON, CSV or Parquet.

use std::sync::Arc;
use std::time::Duration;

use axum::body::Body;
use axum::extract::{OriginalUri, State};
use axum::http::{Uri, header};
use axum::response::{IntoResponse, Response};
use futures_util::StreamExt;
use serde::Deserialize;
use tokio::sync::OwnedSemaphorePermit;
use tokio::task::spawn_blocking;
use utoipa::openapi::path::{Parameter, ParameterIn};
use utoipa::{IntoParams, ToSchema};
use uuid::Uuid;
use veloid_engine::report::diagnosis::Verdict;

use super::access::Caller;
use super::extract::Query;
use super::list::{Page, limit_to, next_link, without_cursor};
use super::names::{EFFECTS, PARAMETERS};
use super::parameter_view::ParameterView;
use super::problem::{Kind, Problem};
use super::{App, Server, names, parquet, time};
use crate::store::parameter::{self, AXLES, Filter, Key, METHODS, ParameterRow};

#[derive(Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct Params {
    /// Only of this bike.
    pub bike: Option<String>,
    /// Only by this method.
    #[param(schema_with = names::methods)]
    pub method: Option<String>,
    /// Only of this axle.
    #[param(schema_with = names::axles)]
    pub axle: Option<String>,
    /// Only this parameter: of the bicycle, or `effect.parameter`; also of a law of one's own that a stored result names.
    #[param(schema_with = names::parameters)]
    pub name: Option<String>,
    /// Only parameters of this effect; also of a law of one's own that a stored result names.
    #[param(schema_with = names::effects)]
    pub effect: Option<String>,
    /// Only of jobs with this verdict.
    #[param(schema_with = names::verdicts)]
    pub verdict: Option<String>,
    /// Only of this job.
    pub job: Option<Uuid>,
    /// Identified from this time on, inclusive (RFC 3339). A day, such as 2026-09-01, counts whole, from its
    /// beginning (UTC).
    #[param(schema_with = time::schema)]
    pub from: Option<String>,
    /// Identified before this time, exclusive (RFC 3339). A day, such as 2026-09-30, counts whole, to its end
    /// (UTC). Not earlier than `from`.
    #[param(schema_with = time::schema)]
    pub to: Option<String>,
    #[param(inline)]
    pub format: Option<Format>,
    /// Items per page: 50 unless asked otherwise.
    #[param(minimum = 1, maximum = 100_000)]
    pub limit: Option<i64>,
    /// `next` of the page before.
    #[param(
        pattern = "^[0-9a-f]{8}-[0-9a-f]{4}-[0-9a-f]{4}-[0-9a-f]{4}-[0-9a-f]{12}/[a-z_]+/[a-z]+/.+$"
    )]
    pub cursor: Option<String>,
}

/// The same where the address names the bike.
pub struct OfBike;

impl IntoParams for OfBike {
    fn into_params(place: impl Fn() -> Option<ParameterIn>) -> Vec<Parameter> {
        let mut all = Params::into_params(place);
        all.retain(|parameter| parameter.name != "bike");
        all
    }
}

/// `json` unless asked otherwise.
#[derive(Clone, Copy, Default, PartialEq, Eq, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Format {
    #[default]
    Json,
    Csv,
    Parquet,
}

/// Every identified parameter of every ride, newest first.
#[utoipa::path(get, path = "/v1/parameters", operation_id = "list_parameters", tag = "fleet", params(Params),
    responses(
        (status = 200, description = "A page of parameters; `Link` names the next one", content(
            (Page<ParameterView> = "application/json"), (String = "text/csv"), (Vec<u8> = "application/vnd.apache.parquet"))),
        (status = 400, description = "Malformed query", body = Problem, content_type = "application/problem+json")))]
pub async fn list(
    State(server): App,
    caller: Caller,
    OriginalUri(uri): OriginalUri,
    Query(params): Query<Params>,
) -> Result<Response, Problem> {
    respond(&server, &caller.group, &uri, &params).await
}

/// Most rows of one answer.
pub const MOST: i64 = 100_000;
/// Rows up to which a list is made at once.
const SHORT: i64 = 1000;
/// Longest wait for leave to make a longer one.
const PATIENCE: Duration = Duration::from_secs(10);

/// The page that the parameters ask for.
pub async fn respond(
    server: &Server,
    group: &str,
    uri: &Uri,
    params: &Params,
) -> Result<Response, Problem> {
    let limit = limit_to(params.limit, MOST)?;
    let Some(permit) = leave(server, limit).await? else {
        return page(server, group, uri, params, limit).await;
    };
    let response = page(server, group, uri, params, limit).await?;
    // Until the last byte is on its way: what is sent slowly lies in memory too.
    Ok(response.map(|body| {
        let kept = body.into_data_stream().inspect(move |_| {
            let _ = &permit;
        });
        Body::from_stream(kept)
    }))
}

/// Leave to make a list, where it is so long that it needs one.
async fn leave(server: &Server, limit: i64) -> Result<Option<OwnedSemaphorePermit>, Problem> {
    if limit <= SHORT {
        return Ok(None);
    }
    let permit = Arc::clone(&server.exports).acquire_owned();
    match tokio::time::timeout(PATIENCE, permit).await {
        Ok(permit) => Ok(Some(permit.map_err(Problem::internal)?)),
        Err(_) => {
            let detail = "others are fetching long lists; try again, or fetch shorter ones";
            Err(Problem::new(Kind::Unavailable, detail).retry_after(PATIENCE))
        }
    }
}

async fn page(
    server: &Server,
    group: &str,
    uri: &Uri,
    params: &Params,
    limit: i64,
) -> Result<Response, Problem> {
    let rows = rows(server, group, params, limit).await?;
    let next = Page::cut(rows, limit, cursor, |row| row);
    let address = without_cursor(uri);
    let after = next.next.clone();
    let (kind, name, body) = match params.format.unwrap_or_default() {
        Format::Json => {
            let address = address.clone();
            let respond = move || {
                let items = next.items.into_iter().map(ParameterView::from).collect();
                let page: Page<ParameterView> = Page {
                    items,
                    next: next.next,
                };
                page.respond(&address)
            };
            return Ok(spawn_blocking(respond).await?);
        }
        Format::Csv => {
            let csv = move || {
                let items: Vec<_> = next.items.into_iter().map(ParameterView::from).collect();
                to_csv(&items).into_bytes()
            };
            let csv = spawn_blocking(csv).await?;
            ("text/csv; charset=utf-8", "parameters.csv", csv)
        }
        Format::Parquet => {
            let rows = next.items;
            let file = spawn_blocking(move || parquet::file(rows)).await?;
            let file = file.map_err(Problem::internal)?;
            ("application/vnd.apache.parquet", "parameters.parquet", file)
        }
    };
    let attachment = format!("attachment; filename=\"{name}\"");
    let headers = [
        (header::CONTENT_TYPE, kind.to_owned()),
        (header::CONTENT_DISPOSITION, attachment),
    ];
    let mut response = (headers, body).into_response();
    if let Some(link) = next_link(&address, after.as_deref()) {
        response.headers_mut().insert(header::LINK, link);
    }
    Ok(response)
}

impl Params {
    /// Refuses a parameter or an effect that neither the library knows nor any stored result names.
    async fn known(&self, server: &Server, group: &str) -> Result<(), Problem> {
        let (name, effect) = (self.name.as_deref(), self.effect.as_deref());
        let of_library = names::one_of("name", name, &PARAMETERS)
            .and_then(|()| names::one_of("effect", effect, &EFFECTS));
        let Err(unknown) = of_library else {
            return Ok(());
        };
        let any = Filter {
            group,
            name,
            effect,
            ..Filter::default()
        };
        match parameter::page(&server.db, &any, 1).await?.is_empty() {
            true => Err(unknown),
            false => Ok(()),
        }
    }

    /// What is asked of the store.
    pub fn filter<'a>(&'a self, group: &'a str) -> Result<Filter<'a>, Problem> {
        let (method, axle, name) = (&self.method, &self.axle, &self.name);
        let (effect, verdict) = (&self.effect, &self.verdict);
        names::one_of("method", method.as_deref(), &METHODS)?;
        names::one_of("axle", axle.as_deref(), &AXLES)?;
        names::one_of("verdict", verdict.as_deref(), &Verdict::NAMES)?;
        let (from_ms, to_ms) = time::span(self.from.as_deref(), self.to.as_deref())?;
        let after = self.cursor.as_deref();
        Ok(Filter {
            group,
            bike: self.bike.as_deref(),
            method: method.as_deref(),
            axle: axle.as_deref(),
            name: name.as_deref(),
            effect: effect.as_deref(),
            verdict: verdict.as_deref(),
            job: self.job,
            from_ms,
            to_ms,
            after: after.map(parse_cursor).transpose()?,
        })
    }
}

/// The rows that the parameters ask for, and one more where there are more.
pub async fn rows(
    server: &Server,
    group: &str,
    params: &Params,
    limit: i64,
) -> Result<Vec<ParameterRow>, Problem> {
    params.known(server, group).await?;
    let filter = params.filter(group)?;
    Ok(parameter::page(&server.db, &filter, limit + 1).await?)
}

pub fn cursor(row: &ParameterRow) -> String {
    format!("{}/{}/{}/{}", row.job_id, row.method, row.axle, row.name)
}

fn parse_cursor(cursor: &str) -> Result<Key, Problem> {
    key(cursor).ok_or_else(|| {
        let detail = "cursor: expected the `next` of an earlier page";
        Problem::new(Kind::BadRequest, detail)
    })
}

fn key(cursor: &str) -> Option<Key> {
    let mut parts = cursor.splitn(4, '/');
    Some(Key {
        job_id: parts.next()?.parse().ok()?,
        method: parts.next()?.to_owned(),
        axle: parts.next()?.to_owned(),
        name: parts.next()?.to_owned(),
    })
}

fn to_csv(items: &[ParameterView]) -> String {
    let mut csv =
        "job,bike,identified_at,method,axle,name,value,std_error,unit,verdict,version,made_up,\
         ridden_at,pressure_front_bar,pressure_rear_bar,temperature_c,rider,rider_mass_kg,tyres,road,\
         tags,notes,further\n"
            .to_owned();
    let number = |value: Option<f64>| value.map(|value| value.to_string()).unwrap_or_default();
    let text = |value: Option<&str>| value.map(cell).unwrap_or_default();
    for item in items {
        let facts = &item.facts;
        let cells = [
            item.job.to_string(),
            cell(&item.bike),
            item.identified_at.clone(),
            item.method.clone(),
            item.axle.clone(),
            cell(&item.name),
            item.value.to_string(),
            number(item.std_error),
            cell(&item.unit),
            item.verdict.clone().unwrap_or_default(),
            item.version.clone(),
            item.made_up.to_string(),
            text(facts.ridden_at.as_deref()),
            number(facts.pressure_front_bar),
            number(facts.pressure_rear_bar),
            number(facts.temperature_c),
            text(facts.rider.as_deref()),
            number(facts.rider_mass_kg),
            text(facts.tyres.as_deref()),
            text(facts.road.as_deref()),
            text(item.tags().as_deref()),
            text(facts.notes.as_deref()),
            text(item.further().as_deref()),
        ];
        csv.push_str(&cells.join(","));
        csv.push('\n');
    }
    csv
}

/// A text cell, quoted where it must be, and never a formula to a spreadsheet.
fn cell(text: &str) -> String {
    let guard = if text.starts_with(['=', '+', '-', '@', '\t', '\r']) {
        "'"
    } else {
        ""
    };
    if guard.is_empty() && !text.contains([',', '"', '\n', '\r']) {
        return text.to_owned();
    }
    format!("\"{guard}{}\"", text.replace('"', "\"\""))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn only_cursors_are_cursors() {
        let id = Uuid::now_v7();
        let known = Key {
            job_id: id,
            method: "extended".into(),
            axle: "front".into(),
            name: "a/b".into(),
        };
        assert_eq!(key(&format!("{id}/extended/front/a/b")), Some(known));
        for bad in ["", "zz", "x/extended/front/a", &format!("{id}/front/a")] {
            assert_eq!(key(bad), None, "{bad}");
        }
    }

    proptest! {
        #[test]
        fn any_text_is_a_cursor_or_none(text in "\\PC{0,80}", parts in "[0-9a-f-]{30,38}(/[a-z_.]{0,9}){0,5}") {
            for text in [text, parts] {
                if let Some(known) = key(&text) {
                    let again = format!("{}/{}/{}/{}", known.job_id, known.method, known.axle, known.name);
                    prop_assert_eq!(key(&again), Some(known));
                }
            }
        }

        #[test]
        fn every_cursor_is_read_back(id in any::<u128>(), axle in "front|rear|both", name in "[a-z_./]{1,30}") {
            let known = Key {
                job_id: Uuid::from_u128(id),
                method: "extended".to_owned(),
                axle,
                name,
            };
            let text = format!("{}/{}/{}/{}", known.job_id, known.method, known.axle, known.name);
            prop_assert_eq!(key(&text), Some(known));
        }
    }

    #[test]
    fn text_cells_are_quoted_and_no_formulas() {
        assert_eq!(cell("lab-7"), "lab-7");
        assert_eq!(cell("a,\"b\""), "\"a,\"\"b\"\"\"");
        assert_eq!(cell("=HYPERLINK(1)"), "\"'=HYPERLINK(1)\"");
    }
}
