//! One log line and one measurement per request.

use std::time::Instant;

use axum::extract::{MatchedPath, Request};
use axum::http::Method;
use axum::middleware::Next;
use axum::response::Response;

use crate::metrics::{Label, METRICS};
use crate::shorten::shortened;

pub async fn measure(matched: Option<MatchedPath>, request: Request, next: Next) -> Response {
    let method = name(request.method());
    let path = shortened(request.uri().path()).into_owned();
    let begin = Instant::now();
    let response = next.run(request).await;
    let duration = begin.elapsed();
    let status = response.status().as_u16();
    tracing::info!(
        method,
        path,
        status,
        duration_ms = duration.as_millis(),
        "request"
    );
    let labels = [
        ("route", matched.map_or("none".into(), Label::from)),
        ("method", method.into()),
        ("status", Label::Status(status)),
    ];
    METRICS.requests.record(duration.as_secs_f64(), labels);
    response
}

/// The methods that this server has; clients may make up others, of any length.
fn name(method: &Method) -> &'static str {
    match *method {
        Method::GET => "GET",
        Method::HEAD => "HEAD",
        Method::POST => "POST",
        Method::PATCH => "PATCH",
        Method::DELETE => "DELETE",
        _ => "other",
    }
}
