//! What every page shares: the frame, the headers, and problems as a page.

use askama::Template;
use axum::extract::{FromRequestParts, Request};
use axum::http::{HeaderValue, StatusCode, header};
use axum::middleware::Next;
use axum::response::{Html, IntoResponse, Response};

use crate::api::extract;
use crate::api::problem::{Kind, Problem};

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

/// Scripts and style sheets from this server only, none of them inline. Style attributes are allowed:
/// plotly positions its labels by them.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; style-src-attr 'unsafe-inline'; img-src 'self' data: blob:; \
    connect-src 'self'; form-action 'self'; base-uri 'none'; frame-ancestors 'none'";

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

/// Query parameters of a page.
#[derive(FromRequestParts)]
#[from_request(via(extract::Query), rejection(Fault))]
pub struct Query<T>(pub T);

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

/// Sets the security headers, and refuses forms that another site sends.
pub async fn guard(request: Request, next: Next) -> Response {
    let site = request.headers().get("sec-fetch-site");
    let foreign = site.is_some_and(|site| site == "cross-site" || site == "same-site");
    let mut response = if foreign && !request.method().is_safe() {
        Fault(Problem::new(
            Kind::Foreign,
            "forms are only taken from this server's own pages",
        ))
        .into_response()
    } else {
        next.run(request).await
    };
    let headers = response.headers_mut();
    for (name, value) in [
        (header::CONTENT_SECURITY_POLICY, POLICY),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::REFERRER_POLICY, "same-origin"),
    ] {
        headers.insert(name, HeaderValue::from_static(value));
    }
    response
}
