//! A job as the API shows it.

use serde::Serialize;
use utoipa::ToSchema;
use uuid::Uuid;
use veloid_engine::bicycle::PerAxle;
use veloid_engine::report::Estimate;
use veloid_engine::ride::RideSummary;

use crate::api::problem::Problem;
use crate::facts::Facts;
use crate::options::Options;
use crate::store::Db;
use crate::store::job::{self, Failure, JobRow, Stage, State};
use crate::time;

/// An identification: its state and the results so far.
#[derive(Clone, Serialize, ToSchema)]
#[schema(as = Job)]
pub struct JobView {
    pub id: Uuid,
    pub state: State,
    pub stage: Stage,
    /// From 0 to 1.
    pub progress: f64,
    pub trials: Trials,
    pub ride: RideOf,
    /// Name of the bike in the fleet.
    pub bike: String,
    /// Ids of the jobs whose rides it identifies as one, the latest of which is `ride`; null where it identifies one ride.
    pub study: Option<Vec<Uuid>>,
    pub options: Options,
    /// The first estimate, available before the swarm has finished; null where the diagnosis came to no verdict.
    pub least_squares: Option<PerAxle<Estimate>>,
    /// `nothing_missing`, `named`, `named_in_part`, `ambiguous`, `unnamed` or `cannot_tell`, at the end of a diagnosis.
    pub verdict: Option<String>,
    /// Why the job, though it succeeded, gave neither stiffness nor damping.
    pub no_result: Option<String>,
    /// Why the job failed.
    pub failure: Option<Failure>,
    /// Increases with every change; the ETag.
    pub revision: i64,
    /// Time of the ride or, where unknown, of the upload.
    #[schema(format = DateTime)]
    pub dated_at: String,
    #[schema(format = DateTime)]
    pub created_at: String,
    /// When a worker started it.
    #[schema(format = DateTime)]
    pub started_at: Option<String>,
    /// When least squares were available.
    #[schema(format = DateTime)]
    pub observed_at: Option<String>,
    #[schema(format = DateTime)]
    pub finished_at: Option<String>,
    /// When it was deleted, with its ride or its bike.
    #[schema(format = DateTime)]
    pub deleted_at: Option<String>,
    pub links: Links,
}

/// Swarm trials.
#[derive(Clone, Serialize, ToSchema)]
pub struct Trials {
    pub total: i64,
    pub done: i64,
}

/// The ride of a job.
#[derive(Clone, Serialize, ToSchema)]
#[schema(as = JobRide)]
pub struct RideOf {
    pub id: Uuid,
    pub name: String,
    /// Facts about the ride.
    pub facts: Facts,
    /// How the file was read.
    pub summary: RideSummary,
}

/// Addresses of a job.
#[derive(Clone, Serialize, ToSchema)]
pub struct Links {
    pub job: String,
    pub trials: String,
    pub report: String,
    pub series: String,
    pub events: String,
    pub page: String,
}

impl JobView {
    /// What lists call it.
    pub fn title(&self) -> String {
        match &self.study {
            Some(rides) => format!("{} rides as one", rides.len()),
            None => self.ride.name.clone(),
        }
    }
}

impl From<JobRow> for JobView {
    fn from(row: JobRow) -> Self {
        let withheld = row.verdict.as_deref() == Some("cannot_tell");
        let job = format!("/v1/jobs/{}", row.id);
        Self {
            id: row.id,
            state: row.state,
            stage: row.stage,
            progress: progress(&row),
            trials: Trials {
                total: row.trials_total,
                done: row.trials_done,
            },
            ride: RideOf {
                id: row.ride_id,
                name: row.ride_name,
                facts: row.facts.map(|json| json.0).unwrap_or_default(),
                summary: row.summary.0,
            },
            bike: row.bike,
            study: row.study.map(|json| json.0),
            options: row.request.0.options,
            least_squares: row.least_squares.filter(|_| !withheld).map(|json| json.0),
            verdict: row.verdict,
            no_result: row.no_result,
            failure: row.failure.map(|json| json.0),
            revision: row.revision,
            dated_at: time::text(row.dated_at),
            created_at: time::text(row.created_at),
            started_at: row.started_at.map(time::text),
            observed_at: row.observed_at.map(time::text),
            finished_at: row.finished_at.map(time::text),
            deleted_at: row.deleted_at.map(time::text),
            links: Links {
                trials: format!("{job}/trials"),
                report: format!("{job}/report"),
                series: format!("{job}/series"),
                events: format!("{job}/events"),
                page: format!("/jobs/{}", row.id),
                job,
            },
        }
    }
}

/// Stages weigh roughly as their usual share of the time.
fn progress(row: &JobRow) -> f64 {
    match (row.state, row.stage) {
        (State::Succeeded, _) => 1.0,
        (_, Stage::Observe) => 0.0,
        (_, Stage::Trial) => 0.05 + 0.55 * row.trials_done as f64 / row.trials_total.max(1) as f64,
        (_, Stage::Conclude) => 0.6,
        (_, Stage::Diagnose) => 0.65,
    }
}

/// The group's job, or the problem that there is none.
pub async fn find(db: &Db, group: &str, id: Uuid) -> Result<JobView, Problem> {
    let row = job::find(db, group, id).await?;
    row.map(JobView::from).ok_or_else(no_such_job)
}

pub fn no_such_job() -> Problem {
    Problem::not_found("the job")
}
