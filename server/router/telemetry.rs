//! One log line and one measurement per request.

use std::time::Instant;

use axum::extract::{MatchedPath, Request};
use axum::middleware::Next;
use axum::response::Response;

use crate::metrics::METRICS;

pub async fn measure(matched: Option<MatchedPath>, request: Request, next: Next) -> Response {
    let method = request.method().to_string();
    let path = request.uri().path().to_owned();
    // The pattern, not the address: labels must not grow with the ids.
    let route = matched.map_or_else(|| "none".to_owned(), |path| path.as_str().to_owned());
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
    let status = status.to_string();
    let labels = [("route", &*route), ("method", &method), ("status", &status)];
    METRICS.requests.record(duration.as_secs_f64(), labels);
    response
}
