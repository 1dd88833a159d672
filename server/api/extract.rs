//! axum's extractors with our problems, and conditional requests.

use axum::extract::FromRequestParts;
use axum::http::request::Parts;
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};

use super::problem::{Kind, Problem};
use serde::de::DeserializeOwned;

/// Path parameters; what does not parse is not found.
#[derive(FromRequestParts)]
#[from_request(via(axum::extract::Path), rejection(Problem))]
pub struct Path<T>(pub T);

/// Query parameters.
pub struct Query<T>(pub T);

impl<T: DeserializeOwned, S: Sync> FromRequestParts<S> for Query<T> {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, Problem> {
        Self::read(parts.uri.query().unwrap_or_default())
    }
}

impl<T: DeserializeOwned> Query<T> {
    /// A NUL becomes the replacement character: no text in the database holds either, and PostgreSQL
    /// takes no NUL in a parameter.
    pub fn read(query: &str) -> Result<Self, Problem> {
        let query = query.replace("%00", "%EF%BF%BD");
        let uri = format!("/?{query}").parse().map_err(|_| bad_query())?;
        Ok(Self(axum::extract::Query::try_from_uri(&uri)?.0))
    }
}

fn bad_query() -> Problem {
    Problem::new(Kind::BadRequest, "the query is malformed")
}

/// The ETag of a revision.
pub fn etag(revision: i64) -> String {
    format!("\"{revision}\"")
}

/// Whether the client already has what this ETag names.
pub fn matches(headers: &HeaderMap, etag: &str) -> bool {
    headers
        .get(header::IF_NONE_MATCH)
        .and_then(|value| value.to_str().ok())
        .is_some_and(|value| {
            value
                .split(',')
                .map(|tag| tag.trim().trim_start_matches("W/"))
                .any(|tag| tag == etag || tag == "*")
        })
}

/// Adds the ETag and asks caches to come back with it.
pub fn tagged(etag: &str, response: impl IntoResponse) -> Response {
    let mut response = response.into_response();
    let headers = response.headers_mut();
    if let Ok(value) = HeaderValue::from_str(etag) {
        headers.insert(header::ETAG, value);
    }
    headers.insert(
        header::CACHE_CONTROL,
        HeaderValue::from_static("private, no-cache"),
    );
    response
}

pub fn not_modified(etag: &str) -> Response {
    tagged(etag, StatusCode::NOT_MODIFIED)
}
