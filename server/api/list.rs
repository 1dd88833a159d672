//! Pages of lists: newest first, with an opaque cursor to the next one.

use axum::Json;
use axum::http::{HeaderValue, header};
use axum::response::{IntoResponse, Response};
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};
use uuid::Uuid;

use super::problem::{Kind, Problem};

const DEFAULT: i64 = 50;
pub const MOST: i64 = 1000;

/// One page of a list.
#[derive(Serialize, ToSchema)]
pub struct Page<T> {
    pub items: Vec<T>,
    /// Pass this as `cursor` for the next page; absent on the last page.
    pub next: Option<String>,
}

/// A page of a list whose cursor is the id of the last item before it.
#[derive(Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub struct Older {
    /// Items per page; 50 by default.
    #[param(minimum = 1, maximum = 1000)]
    pub limit: Option<i64>,
    /// `next` of the previous page.
    pub cursor: Option<Uuid>,
}

/// The number of items to send: as asked, from 1 to 1000.
pub fn limit(asked: Option<i64>) -> Result<i64, Problem> {
    limit_to(asked, MOST)
}

/// The number of items to send: as asked, from 1 to `most`.
pub fn limit_to(asked: Option<i64>, most: i64) -> Result<i64, Problem> {
    match asked.unwrap_or(DEFAULT) {
        limit if (1..=most).contains(&limit) => Ok(limit),
        limit => Err(Problem::new(
            Kind::BadRequest,
            format!("limit: {limit}, expected 1 to {most}"),
        )),
    }
}

/// `Link: <...>; rel="next"`; `address` holds the query without the cursor.
pub fn next_link(address: &str, next: Option<&str>) -> Option<HeaderValue> {
    let mark = if address.contains('?') { '&' } else { '?' };
    let next: String = form_urlencoded::byte_serialize(next?.as_bytes()).collect();
    HeaderValue::from_str(&format!("<{address}{mark}cursor={next}>; rel=\"next\"")).ok()
}

impl<T> Page<T> {
    /// Cuts a list, for which one item too many was asked, to a page.
    pub fn cut<R>(
        mut rows: Vec<R>,
        limit: i64,
        cursor: impl Fn(&R) -> String,
        item: impl Fn(R) -> T,
    ) -> Self {
        let more = rows.len() as i64 > limit;
        rows.truncate(limit as usize);
        Self {
            next: rows.last().filter(|_| more).map(cursor),
            items: rows.into_iter().map(item).collect(),
        }
    }
}

impl<T: Serialize> Page<T> {
    /// The page with `Link: <...>; rel="next"`; `address` holds the query without the cursor.
    pub fn respond(self, address: &str) -> Response {
        let link = next_link(address, self.next.as_deref());
        let mut response = Json(self).into_response();
        if let Some(link) = link {
            response.headers_mut().insert(header::LINK, link);
        }
        response
    }
}

/// The request's address without its cursor.
pub fn without_cursor(uri: &axum::http::Uri) -> String {
    let query: Vec<&str> = uri
        .query()
        .unwrap_or_default()
        .split('&')
        .filter(|pair| !pair.is_empty() && !pair.starts_with("cursor="))
        .collect();
    if query.is_empty() {
        uri.path().to_owned()
    } else {
        format!("{}?{}", uri.path(), query.join("&"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_names_the_next_one_only_when_there_is_more() {
        let page = |rows: Vec<i64>| Page::cut(rows, 2, i64::to_string, |row| row * 10);
        let first = page(vec![5, 4, 3]);
        assert_eq!((first.items, first.next), (vec![50, 40], Some("4".into())));
        let last = page(vec![2, 1]);
        assert_eq!((last.items, last.next), (vec![20, 10], None));
    }

    #[test]
    fn the_next_address_keeps_the_filters() {
        let uri = "/v1/jobs?state=failed&cursor=x&limit=2".parse();
        assert_eq!(
            uri.map(|uri| without_cursor(&uri)).ok().as_deref(),
            Some("/v1/jobs?state=failed&limit=2")
        );
    }
}
