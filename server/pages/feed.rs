//! Finished jobs as an Atom feed (RFC 4287).

use askama::Template;
use axum::extract::State;
use axum::http::header;
use axum::response::{IntoResponse, Response};
use veloid_engine::seen;

use super::layout::Fault;
use super::verdict::{self, Listed};
use crate::api::App;
use crate::api::access::Caller;
use crate::api::jobs::view::JobView;
use crate::api::problem::Problem;
use crate::store::job;

/// Latest jobs that are looked through, and most of them that are reported.
const LATEST: i64 = 200;
const TOLD: usize = 50;

#[derive(Template)]
#[template(path = "feed.xml")]
struct Feed {
    group: String,
    updated: String,
    entries: Vec<Entry>,
}

struct Entry {
    id: String,
    title: String,
    finished_at: String,
    page: String,
    bike: String,
    summary: String,
}

/// The latest finished jobs of the group, the last that ended first.
pub async fn feed(State(server): App, caller: Caller) -> Result<Response, Fault> {
    let filter = job::Filter {
        group: &caller.group,
        ..job::Filter::default()
    };
    let rows = job::page(&server.db, &filter, LATEST).await?;
    let jobs = rows
        .into_iter()
        .map(JobView::from)
        .filter(|job| job.finished_at.is_some());
    let mut jobs = verdict::listed(&server.db, jobs.collect()).await?;
    jobs.sort_by(|a, b| b.job.finished_at.cmp(&a.job.finished_at));
    jobs.truncate(TOLD);
    let entries: Vec<Entry> = jobs.into_iter().map(Entry::of).collect();
    let updated = entries.first().map(|entry| entry.finished_at.clone());
    let feed = Feed {
        group: caller.group,
        updated: updated.unwrap_or_else(|| "1970-01-01T00:00:00Z".to_owned()),
        entries,
    };
    let text = feed.render().map_err(Problem::internal)?;
    Ok((
        [(header::CONTENT_TYPE, "application/atom+xml; charset=utf-8")],
        text,
    )
        .into_response())
}

impl Entry {
    fn of(listed: Listed) -> Self {
        let Listed { job, verdict, .. } = listed;
        let state = job.state.name();
        let what = verdict.unwrap_or_else(|| state.to_owned());
        let failure = job.failure.map(|failure| failure.detail);
        Self {
            title: format!("{}: {what}", printable(&job.ride.name)),
            summary: printable(
                &failure.unwrap_or_else(|| format!("{} of {}, {what}", job.ride.name, job.bike)),
            ),
            id: job.id.to_string(),
            finished_at: job.finished_at.unwrap_or_default(),
            page: job.links.page,
            bike: printable(&job.bike),
        }
    }
}

/// Without what XML has no way to write or nobody can see: names of earlier versions may hold it.
fn printable(text: &str) -> String {
    seen(text)
        .filter(|c| !matches!(c, '\u{fffe}' | '\u{ffff}'))
        .collect()
}
