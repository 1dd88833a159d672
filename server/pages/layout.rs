//! What every page shares: the frame, and problems as a page.

use askama::Template;
use axum::extract::{FromRequestParts, Request};
use axum::http::request::Parts;
use axum::http::{HeaderValue, header};
use axum::middleware::Next;
use axum::response::{Html, IntoResponse, Response};
use serde::de::DeserializeOwned;

use crate::api::problem::Problem;
use crate::api::{extract, known};

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
        let own = without_theme(parts.uri.query().unwrap_or_default());
        Ok(Self(extract::Query::read(&own)?.0))
    }
}

/// Refuses a query on a page that takes none, but for its theme: a name that nobody hears looks as if it were heard.
pub async fn takes_no_query(request: Request, next: Next) -> Response {
    let own = without_theme(request.uri().query().unwrap_or_default());
    match known::only(&[], &own) {
        Ok(()) => next.run(request).await,
        Err(problem) => Fault(problem).into_response(),
    }
}

fn without_theme(query: &str) -> String {
    let own = query.split('&').filter(|pair| !pair.starts_with("theme="));
    own.collect::<Vec<_>>().join("&")
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
        let page = ProblemPage { problem: self.0 };
        let text = page.render();
        let response = page.problem.into_response();
        let Ok(text) = text else { return response };
        let (mut head, _) = response.into_parts();
        let html = HeaderValue::from_static("text/html; charset=utf-8");
        head.headers.insert(header::CONTENT_TYPE, html);
        Response::from_parts(head, text.into())
    }
}
