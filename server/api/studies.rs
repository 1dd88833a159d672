//! Several rides of one bicycle as one.

use std::collections::BTreeSet;

use axum::Json;
use axum::body::Bytes;
use axum::extract::State;
use axum::http::{StatusCode, header};
use axum::response::IntoResponse;
use serde::Deserialize;
use utoipa::ToSchema;
use uuid::Uuid;

use super::access::Caller;
use super::bikes::existing;
use super::jobs::view::JobView;
use super::problem::{Kind, Problem};
use super::rides::view::no_such_ride;
use super::{App, Server};
use crate::jobs::{LONG, USUAL, known_study, queue_study};
use crate::store::job::{self, Filter, JobRow, State as JobState};
use crate::store::parameter;

/// Rides that a study may have.
const LEAST: usize = 2;
const MOST: usize = 64;

/// The rides of a study: either their ids, or the latest of a bicycle.
#[derive(Debug, Default, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct NewStudy {
    /// Ids of 2 to 64 rides of one bicycle; each is read with the bike file and the options of its newest job.
    pub rides: Option<Vec<Uuid>>,
    /// Name of a bicycle of the fleet: its latest rides with a result.
    pub bike: Option<String>,
    /// How many of them, 2 to 64; 12 by default.
    #[schema(minimum = 2, maximum = 64)]
    pub last: Option<usize>,
}

/// Identifies several rides of one bicycle as one.
///
/// Effects' parameters are common to the rides, stiffness and damping too where the rides bear that: effects that are too weak for one ride
/// are found in several. The job has no trials; its report is a `StudyReport`, and its parameters have the method `study`. The same rides
/// return the same job.
#[utoipa::path(post, path = "/v1/studies", operation_id = "create_study", tag = "jobs", request_body = NewStudy,
    responses(
        (status = 202, description = "Queued, or known", body = JobView, headers(("Location" = String, description = "Address of the job"))),
        (status = 400, description = "Malformed body", body = Problem, content_type = "application/problem+json"),
        (status = 404, description = "No such ride or bike", body = Problem, content_type = "application/problem+json"),
        (status = 422, description = "The rides cannot be identified as one", body = Problem, content_type = "application/problem+json"),
        (status = 503, description = "The queue is full", body = Problem, content_type = "application/problem+json", headers(("Retry-After" = u32)))))]
pub async fn create(
    State(server): App,
    caller: Caller,
    body: Bytes,
) -> Result<impl IntoResponse, Problem> {
    let new: NewStudy = serde_json::from_slice(&body).map_err(|error| {
        let expected = "expected {\"rides\": [RIDE, ...]} or {\"bike\": NAME, \"last\": 12}";
        Problem::new(Kind::BadRequest, format!("the body: {error}; {expected}"))
    })?;
    let job: JobView = submit(&server, &caller, &new).await?.into();
    let location = [(header::LOCATION, job.links.job.clone())];
    Ok((StatusCode::ACCEPTED, location, Json(job)))
}

/// The study's job: a new one, or the one that the same rides have.
pub async fn submit(server: &Server, caller: &Caller, new: &NewStudy) -> Result<JobRow, Problem> {
    let rides = rides(server, &caller.group, new).await?;
    let newest = rides.iter().max_by_key(|job| (job.dated_at, job.id));
    let newest = newest.ok_or_else(no_such_ride)?;
    if let Some(other) = rides.iter().find(|job| job.bike != newest.bike) {
        let detail = format!(
            "the rides are of {} and {}: a study is of one bicycle",
            newest.bike, other.bike
        );
        return Err(Problem::new(Kind::BadRequest, detail));
    }
    let mut tx = server.db.begin().await?;
    if let Some(known) = known_study(&mut tx, &rides).await? {
        return job::load_in(&mut tx, known).await?.ok_or_else(no_such_ride);
    }
    caller.may_queue(&mut tx).await?;
    let id = queue_study(&server.queue, &mut tx, caller.key, &rides).await?;
    let id = id.ok_or_else(no_such_ride)?;
    let row = job::load_in(&mut tx, id).await?.ok_or_else(no_such_ride)?;
    tx.commit().await?;
    server.queue.wake(LONG);
    Ok(row)
}

/// The newest jobs of the rides, the latest ride first.
async fn rides(server: &Server, group: &str, new: &NewStudy) -> Result<Vec<JobRow>, Problem> {
    let bad = |detail: String| Err(Problem::new(Kind::BadRequest, detail));
    let range = LEAST..=MOST;
    match (&new.rides, &new.bike) {
        (Some(rides), None) => {
            let distinct: BTreeSet<&Uuid> = rides.iter().collect();
            if !range.contains(&distinct.len()) || distinct.len() < rides.len() {
                let detail = format!(
                    "rides: {} ids, expected {LEAST} to {MOST} different ones",
                    rides.len()
                );
                return bad(detail);
            }
            let mut jobs = Vec::new();
            for ride in rides {
                jobs.push(newest(server, group, *ride).await?);
            }
            Ok(jobs)
        }
        (None, Some(name)) => {
            let last = new.last.unwrap_or(USUAL);
            if !range.contains(&last) {
                return bad(format!("last: {last}, expected {LEAST} to {MOST}"));
            }
            existing(server, group, name).await?;
            let rows = parameter::named_on_bike(&server.db, group, name, last as i64).await?;
            let mut ids: Vec<Uuid> = rows.into_iter().map(|row| row.job_id).collect();
            ids.dedup();
            if ids.len() < LEAST {
                let detail = format!(
                    "{} rides of this bicycle have a result, a study needs {LEAST}",
                    ids.len()
                );
                return Err(Problem::new(Kind::BadOption, detail));
            }
            let mut jobs = Vec::new();
            for id in ids {
                jobs.extend(job::find(&server.db, group, id).await?);
            }
            Ok(jobs)
        }
        _ => bad("expected either rides, a list of their ids, or bike, a name".to_owned()),
    }
}

async fn newest(server: &Server, group: &str, ride: Uuid) -> Result<JobRow, Problem> {
    let filter = |state| Filter {
        group,
        ride: Some(ride),
        of_one_ride: true,
        state,
        ..Filter::default()
    };
    // One that succeeded, if any did.
    for state in [Some(JobState::Succeeded), None] {
        let page = job::page(&server.db, &filter(state), 1).await?;
        if let Some(job) = page.into_iter().next() {
            return Ok(job);
        }
    }
    Err(no_such_ride())
}
