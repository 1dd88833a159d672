//! Whether the server lives and can work, and its figures.

use std::time::Duration;

use axum::extract::State;
use axum::http::{HeaderMap, header};
use axum::response::IntoResponse;

use super::problem::{Kind, Problem};
use super::signs::NotReady;
use super::{App, Server};
use crate::metrics::METRICS;
use crate::store::{job, worker};

/// A disk that takes nothing for so long is full or gone.
const PATIENCE: Duration = Duration::from_secs(3);

/// Whether uploads could be kept and computed.
async fn look(server: &Server) -> Result<(), NotReady> {
    let checked = server.db.condition().check();
    checked.map_err(|fault| NotReady::known(fault.what(), fault))?;
    let answered = server.db.ping().await;
    answered.map_err(|error| NotReady::new("the database cannot be read", error))?;
    let kept = tokio::time::timeout(PATIENCE, server.files.has_room()).await;
    let kept = kept.unwrap_or(Err(std::io::ErrorKind::TimedOut.into()));
    kept.map_err(|error| NotReady::new("uploads cannot be stored", error.kind()))
}

/// The process is alive.
#[utoipa::path(get, path = "/healthz", tag = "operations",
    responses((status = 200, description = "Alive", body = String, content_type = "text/plain")))]
pub async fn healthz() -> &'static str {
    "ok\n"
}

/// The server accepts uploads: the database answers and is intact, it and the store of raw files are this server's, there is
/// space for files, and the server is not shutting down.
#[utoipa::path(get, path = "/readyz", tag = "operations",
    responses(
        (status = 200, description = "Ready", body = String, content_type = "text/plain"),
        (status = 503, description = "Not ready", body = Problem, content_type = "application/problem+json")))]
pub async fn readyz(State(server): App, headers: HeaderMap) -> Result<&'static str, Problem> {
    if server.stop.is_cancelled() {
        return Err(Problem::new(Kind::Unavailable, "shutting down"));
    }
    match server.signs.fresh(look(&server)).await {
        Ok(()) => Ok("ready\n"),
        Err(why) if server.access.is_operator(&server.db, &headers).await => {
            Err(why.to_operators())
        }
        Err(why) => Err(why.to_strangers()),
    }
}

/// Metrics for Prometheus.
#[utoipa::path(get, path = "/metrics", tag = "operations",
    responses((status = 200, description = "Prometheus text format", body = String, content_type = "text/plain")))]
pub async fn metrics(State(server): App) -> Result<impl IntoResponse, Problem> {
    let counts = job::counts(&server.db).await?;
    for state in ["queued", "running", "succeeded", "failed", "cancelled"] {
        let count = counts
            .iter()
            .find(|(s, _)| s == state)
            .map_or(0, |(_, n)| *n);
        METRICS.jobs.set(count, [("state", state.into())]);
    }
    METRICS.workers.set(worker::count(&server.db).await?, []);
    let version = [("version", env!("CARGO_PKG_VERSION").into())];
    METRICS.build.set(1, version);
    let kind = "text/plain; version=0.0.4; charset=utf-8";
    Ok(([(header::CONTENT_TYPE, kind)], METRICS.render()))
}
