//! What every page shares: the frame, and problems as a page.

use askama::Template;
use axum::extract::FromRequestParts;
use axum::http::StatusCode;
use axum::http::request::Parts;
use axum::response::{Html, IntoResponse, Response};
use serde::de::DeserializeOwned;

use crate::api::extract;
use crate::api::problem::Problem;

/// The menu: name and address.
const MENU: [(&str, &str); 4] = [
    ("Upload", "/"),
    ("Jobs", "/jobs"),
    ("Fleet", "/bikes"),
    ("Parameters", "/parameters"),
];

/// The menu on the page at this address: name, address and whether it is this one.
pub fn menu(here: &str) -> impl Iterator<Item = (&'static str, &'static str, bool)> {
    MENU.into_iter()
        .map(move |(name, path)| (name, path, path == here))
}

/// Renders a page.
pub fn html(page: &impl Template) -> Result<Html<String>, Fault> {
    Ok(Html(page.render().map_err(Problem::internal)?))
}

/// A problem, shown as a page.
pub struct Fault(pub Problem);

impl<E: Into<Problem>> From<E> for Fault {
    fn from(error: E) -> Self {
        Self(error.into())
    }
}

/// Path parameters of a page.
#[derive(FromRequestParts)]
#[from_request(via(axum::extract::Path), rejection(Fault))]
pub struct Path<T>(pub T);

/// Query parameters of a page; `theme` is every page's and `web/theme.js` reads it.
pub struct Query<T>(pub T);

impl<T: DeserializeOwned, S: Sync> FromRequestParts<S> for Query<T> {
    type Rejection = Fault;

    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, Fault> {
        let query = parts.uri.query().unwrap_or_default();
        let own = query.split('&').filter(|pair| !pair.starts_with("theme="));
        let own = own.collect::<Vec<_>>().join("&");
        Ok(Self(extract::Query::read(&own)?.0))
    }
}

/// What stands in a field of a form, unless it is blank.
pub fn filled(field: Option<String>) -> Option<String> {
    field
        .map(|text| text.trim().to_owned())
        .filter(|text| !text.is_empty())
}

#[derive(Template)]
#[template(path = "problem.html")]
struct ProblemPage {
    problem: Problem,
}

impl ProblemPage {
    fn here(&self) -> &'static str {
        ""
    }
}

impl IntoResponse for Fault {
    fn into_response(self) -> Response {
        let status = StatusCode::from_u16(self.0.status).unwrap_or_default();
        let page = ProblemPage { problem: self.0 };
        match page.render() {
            Ok(text) => (status, Html(text)).into_response(),
            Err(_) => page.problem.into_response(),
        }
    }
}
