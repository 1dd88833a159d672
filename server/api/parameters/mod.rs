//! Every identified parameter of every ride, as JSON, CSV or Parquet.

mod columns;
mod csv;
mod document;
#[cfg(feature = "parquet")]
mod parquet;
mod query;
mod stream;

use std::sync::Arc;

use axum::body::Body;
use axum::extract::{OriginalUri, State};
use axum::http::{Uri, header};
use axum::response::Response;
use tokio::task::spawn_blocking;

pub use self::query::{MOST, OfBike, Params, cursor, rows};

use self::document::{Document, kind};
use self::stream::{Long, PIECE};
use super::access::Caller;
use super::extract::Query;
use super::list::{Page, limit_to, next_link, without_cursor};
use super::long_readers::{LongReaders, Reader};
use super::parameter_view::ParameterView;
use super::problem::Problem;
use super::{App, Server};
use crate::store::parameter::{self, ParameterRow};

/// Every identified parameter of every ride, newest first.
#[utoipa::path(get, path = "/v1/parameters", operation_id = "list_parameters", tag = "fleet", params(Params),
    responses(
        (status = 200, description = "A page of parameters; `Link` names the next one", content(
            (Page<ParameterView> = "application/json"), (String = "text/csv"), (Vec<u8> = "application/vnd.apache.parquet"))),
        (status = 400, description = "Malformed query", body = Problem, content_type = "application/problem+json"),
        (status = 501, description = "The server is built without Parquet", body = Problem, content_type = "application/problem+json")))]
pub async fn list(
    State(server): App,
    caller: Caller,
    reader: Reader,
    OriginalUri(uri): OriginalUri,
    Query(params): Query<Params>,
) -> Result<Response, Problem> {
    respond(&server, (caller, reader), &uri, params).await
}

/// The page that the parameters ask for: made at once if it is short, else as it is taken.
pub async fn respond(
    server: &Arc<Server>,
    (caller, reader): (Caller, Reader),
    uri: &Uri,
    params: Params,
) -> Result<Response, Problem> {
    let limit = limit_to(params.limit, MOST)?;
    let format = params.format.unwrap_or_default();
    let first = rows(server, &caller.group, &params, limit.min(PIECE)).await?;
    let (next, body) = match limit > PIECE && first.len() as i64 > PIECE {
        true => {
            let list = long(server, (caller, reader), params, limit).await?;
            let (document, begin) = Document::begin(format)?;
            (list.next.clone(), list.body(document, begin, first))
        }
        false => short(format, Page::cut(first, limit, cursor, |row| row)).await?,
    };
    let mut response = Response::new(body);
    let headers = response.headers_mut();
    let (kind, attachment) = kind(format);
    headers.insert(header::CONTENT_TYPE, kind);
    for (name, value) in [
        (header::CONTENT_DISPOSITION, attachment),
        (
            header::LINK,
            next_link(&without_cursor(uri), next.as_deref()),
        ),
    ] {
        headers.extend(value.map(|value| (name, value)));
    }
    Ok(response)
}

/// A list that needs a place among its key's readers. Where it ends is settled before it begins, for the header says so.
async fn long(
    server: &Arc<Server>,
    (caller, reader): (Caller, Reader),
    params: Params,
    limit: i64,
) -> Result<Long, Problem> {
    let seat = LongReaders::admit(&server.long_readers, reader)?;
    let filter = params.filter(&caller.group)?;
    let last = parameter::last_of(&server.db, &filter, limit).await?;
    Ok(Long {
        next: last.as_ref().map(query::of_key),
        through: last,
        server: Arc::clone(server),
        caller,
        params,
        seat,
    })
}

/// A whole list, and what its `next` says.
async fn short(
    format: query::Format,
    page: Page<ParameterRow>,
) -> Result<(Option<String>, Body), Problem> {
    let next = page.next.clone();
    let whole = move || {
        let (mut document, mut whole) = Document::begin(format)?;
        whole.extend(document.rows(page.items)?);
        whole.extend(document.end(page.next.as_deref())?);
        Ok::<_, document::DocumentError>(whole)
    };
    let whole = spawn_blocking(whole).await??;
    Ok((next, Body::from(whole)))
}
