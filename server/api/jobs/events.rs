use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;

use axum::extract::State;
use axum::http::HeaderMap;
use axum::response::sse::{Event, KeepAlive, Sse};
use futures_util::Stream;
use serde::Serialize;
use tokio::sync::broadcast::error::RecvError;
use utoipa::ToSchema;
use uuid::Uuid;

use super::view::{JobView, find};
use crate::api::access::Caller;
use crate::api::extract::Path;
use crate::api::problem::Problem;
use crate::api::{App, Server};
use crate::jobs::{HubEvent, Searched};
use crate::metrics::METRICS;
use crate::store::{job, trial};

/// How often the database is asked for what other processes did.
const LOOK: Duration = Duration::from_secs(1);
/// Wait that clients are asked to keep before they come back (ms).
const RETRY: Duration = Duration::from_secs(2);

/// `snapshot`: everything so far.
#[derive(Serialize, ToSchema)]
pub struct Snapshot {
    pub job: JobView,
    pub trials: Vec<Curve>,
    /// How far the search for missing physics is, where this server computes it.
    pub searched: Option<Searched>,
}

/// Best cost of one trial after each iteration so far.
#[derive(Serialize, ToSchema)]
pub struct Curve {
    pub trial: usize,
    pub best_cost: Vec<f64>,
    pub done: bool,
}

/// Events of a job, as they happen.
///
/// `snapshot` comes first and contains everything so far; then `iteration` for every iteration of a swarm, `searched` during
/// the search for missing physics, `stage` with the job whenever it has changed, and `done` with the finished job, which ends
/// the stream. The stream also ends when the caller's key becomes invalid. A client that reconnects with `Last-Event-ID`
/// receives the events it missed, or a snapshot if they are no longer available.
#[utoipa::path(get, path = "/v1/jobs/{id}/events", operation_id = "follow_job", tag = "jobs",
    params(("id" = Uuid, Path),
        ("Last-Event-ID" = Option<String>, Header, description = "Id of the last event received")),
    responses(
        (status = 200, description = "Server-sent events: snapshot, iteration, searched, stage, done", body = String, content_type = "text/event-stream"),
        (status = 404, description = "No such job", body = Problem, content_type = "application/problem+json")))]
pub async fn events(
    State(server): App,
    caller: Caller,
    Path(id): Path<Uuid>,
    headers: HeaderMap,
) -> Result<Sse<impl Stream<Item = Result<Event, Infallible>>>, Problem> {
    let last = headers
        .get("last-event-id")
        .and_then(|value| server.hub.parse_event_id(value.to_str().ok()?));
    find(&server.db, &caller.group, id).await?;
    let keep_alive = KeepAlive::new().interval(Duration::from_secs(15));
    Ok(Sse::new(stream(server, caller, id, last)).keep_alive(keep_alive))
}

fn stream(
    server: Arc<Server>,
    caller: Caller,
    id: Uuid,
    last: Option<u64>,
) -> impl Stream<Item = Result<Event, Infallible>> {
    async_stream::stream! {
        let _open = Open::new();
        let subscription = server.hub.subscribe(id, last);
        let mut receiver = subscription.receiver;
        let mut event_id = subscription.last_id;
        let Ok(mut view) = find(&server.db, &caller.group, id).await else { return };
        match subscription.missed {
            Some(missed) => for (event_id, iteration) in missed {
                yield Ok(event(&server, event_id, "iteration", &iteration));
            },
            None => {
                let Ok(trials) = curves(&server, id, &subscription.curves).await else { return };
                let snapshot = Snapshot { job: view.clone(), trials, searched: subscription.searched };
                yield Ok(event(&server, event_id, "snapshot", &snapshot).retry(RETRY));
            }
        }
        if last.is_some() && !view.state.is_final() {
            yield Ok(event(&server, event_id, "stage", &view));
        }
        let mut look = tokio::time::interval(LOOK);
        while !view.state.is_final() {
            let heard = tokio::select! {
                heard = receiver.recv() => heard,
                _ = look.tick() => Ok(HubEvent::Changed),
                () = server.stop.cancelled() => return,
            };
            match heard {
                Ok(HubEvent::Iteration { id, iteration }) => {
                    event_id = id;
                    yield Ok(event(&server, event_id, "iteration", &iteration));
                    continue;
                }
                Ok(HubEvent::Searched(searched)) => {
                    yield Ok(event(&server, event_id, "searched", &searched));
                    continue;
                }
                Ok(HubEvent::Changed) => {}
                // Too slow a listener, or the end: a listener that comes back gets a snapshot.
                Err(RecvError::Lagged(_)) => return,
                Err(RecvError::Closed) => tokio::time::sleep(LOOK).await,
            }
            match job::revision(&server.db, &caller.group, id).await {
                Ok(Some((revision, _))) if revision == view.revision => continue,
                Ok(Some(_)) => {}
                _ => return,
            }
            let Ok(now) = find(&server.db, &caller.group, id).await else { return };
            view = now;
            if !view.state.is_final() {
                yield Ok(event(&server, event_id, "stage", &view));
            }
        }
        // The row may be at its end before all that led to it was heard.
        while let Ok(heard) = receiver.try_recv() {
            if let HubEvent::Iteration { id, iteration } = heard {
                event_id = id;
                yield Ok(event(&server, event_id, "iteration", &iteration));
            }
        }
        yield Ok(event(&server, event_id, "done", &view));
    }
}

/// Curves of finished trials from the database, of running ones from this process.
async fn curves(
    server: &Server,
    id: Uuid,
    running: &std::collections::BTreeMap<usize, Vec<f64>>,
) -> sqlx::Result<Vec<Curve>> {
    let rows = trial::list(&server.db, id).await?;
    Ok(rows
        .into_iter()
        .map(|row| {
            let trial = row.trial_index as usize;
            let done = row.result.is_some();
            let best_cost = match row.result {
                Some(result) => result.0.best_cost,
                None => running.get(&trial).cloned().unwrap_or_default(),
            };
            Curve {
                trial,
                best_cost,
                done,
            }
        })
        .collect())
}

fn event<T: Serialize>(server: &Server, id: u64, name: &str, data: &T) -> Event {
    let text = serde_json::to_string(data).unwrap_or_else(|_| "null".to_owned());
    Event::default()
        .id(server.hub.event_id(id))
        .event(name)
        .data(text)
}

/// Counts open streams.
struct Open;

impl Open {
    fn new() -> Self {
        METRICS.listeners.change(1);
        Self
    }
}

impl Drop for Open {
    fn drop(&mut self) {
        METRICS.listeners.change(-1);
    }
}
