//! Whether the server lives and can work, and its figures.

use std::sync::PoisonError;
use std::time::{Duration, Instant};

use axum::extract::State;
use axum::http::header;
use axum::response::IntoResponse;
use tokio::sync::Mutex;

use super::problem::{Kind, Problem};
use super::{App, Server};
use crate::store::{job, worker};

/// How long an answer of /readyz holds: who asks more often learns no more, and costs nothing.
const HOLDS: Duration = Duration::from_secs(1);
/// A disk that takes nothing for so long is full or gone.
const PATIENCE: Duration = Duration::from_secs(3);

/// Whether the server can work, as it was when it was looked at last.
#[derive(Default)]
pub struct Signs {
    last: Mutex<Option<(Instant, Result<(), Problem>)>>,
    /// What is wrong with the database's file.
    corrupt: std::sync::Mutex<Option<String>>,
}

impl Signs {
    /// Notes what is wrong with the database's file, or that nothing is.
    pub fn note(&self, fault: Option<String>) {
        *self.corrupt.lock().unwrap_or_else(PoisonError::into_inner) = fault;
    }

    fn corrupt(&self) -> Option<String> {
        self.corrupt
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .clone()
    }
}

/// Whether uploads could be kept and computed.
async fn look(server: &Server) -> Result<(), Problem> {
    let not_ready = |why: String| Problem::new(Kind::Unavailable, why);
    if let Some(fault) = server.signs.corrupt() {
        return Err(not_ready(format!("the database is damaged: {fault}")));
    }
    let answered = server.db.ping().await;
    answered.map_err(|error| not_ready(format!("the database cannot be read: {error}")))?;
    let kept = tokio::time::timeout(PATIENCE, server.files.has_room()).await;
    let kept = kept.unwrap_or(Err(std::io::ErrorKind::TimedOut.into()));
    kept.map_err(|error| not_ready(format!("uploads cannot be stored: {}", error.kind())))
}

/// The process is alive.
#[utoipa::path(get, path = "/healthz", tag = "operations",
    responses((status = 200, description = "Alive", body = String, content_type = "text/plain")))]
pub async fn healthz() -> &'static str {
    "ok\n"
}

/// The server can take uploads: the database answers and is whole, there is room for files, and it is not shutting down.
#[utoipa::path(get, path = "/readyz", tag = "operations",
    responses(
        (status = 200, description = "Ready", body = String, content_type = "text/plain"),
        (status = 503, description = "Not ready", body = Problem, content_type = "application/problem+json")))]
pub async fn readyz(State(server): App) -> Result<&'static str, Problem> {
    if server.stop.is_cancelled() {
        return Err(Problem::new(Kind::Unavailable, "shutting down"));
    }
    let mut last = server.signs.last.lock().await;
    let outcome = match &*last {
        Some((at, outcome)) if at.elapsed() < HOLDS => outcome.clone(),
        _ => {
            let outcome = look(&server).await;
            *last = Some((Instant::now(), outcome.clone()));
            outcome
        }
    };
    outcome.map(|()| "ready\n")
}

/// Figures for Prometheus.
#[utoipa::path(get, path = "/metrics", tag = "operations",
    responses((status = 200, description = "Prometheus text format", body = String, content_type = "text/plain")))]
pub async fn metrics(State(server): App) -> Result<impl IntoResponse, Problem> {
    let counts = job::counts(&server.db).await?;
    for state in ["queued", "running", "succeeded", "failed", "cancelled"] {
        let count = counts
            .iter()
            .find(|(s, _)| s == state)
            .map_or(0, |(_, n)| *n);
        metrics::gauge!("veloid_jobs", "state" => state).set(count as f64);
    }
    metrics::gauge!("veloid_workers").set(worker::count(&server.db).await? as f64);
    metrics::gauge!("veloid_build_info", "version" => env!("CARGO_PKG_VERSION")).set(1.0);
    let kind = "text/plain; version=0.0.4; charset=utf-8";
    Ok(([(header::CONTENT_TYPE, kind)], server.metrics.render()))
}
