//! Jobs as users see them. Every change raises `revision`, which is the ETag, and every change of a
//! running job asks for the state it expects, so that a cancelled job stays cancelled.

use serde::{Deserialize, Serialize};
use sqlx::types::Json;
use sqlx::{FromRow, QueryBuilder};
use utoipa::ToSchema;
use uuid::Uuid;
use veloid_engine::bicycle::{Bike, PerAxle};
use veloid_engine::report::Estimate;
use veloid_engine::ride::RideSummary;

use super::search::{Search, search};
use super::{Db, Tx, now_ms, river};
use crate::facts::Facts;
use crate::options::Options;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum State {
    Queued,
    Running,
    Succeeded,
    Failed,
    Cancelled,
}

impl State {
    pub fn name(self) -> &'static str {
        match self {
            State::Queued => "queued",
            State::Running => "running",
            State::Succeeded => "succeeded",
            State::Failed => "failed",
            State::Cancelled => "cancelled",
        }
    }

    pub fn is_final(self) -> bool {
        !matches!(self, State::Queued | State::Running)
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Stage {
    Observe,
    Trial,
    Conclude,
    Diagnose,
}

impl Stage {
    pub fn name(self) -> &'static str {
        match self {
            Stage::Observe => "observe",
            Stage::Trial => "trial",
            Stage::Conclude => "conclude",
            Stage::Diagnose => "diagnose",
        }
    }
}

/// Reads an enum column by the names that serde gives its variants.
fn parse<T: serde::de::DeserializeOwned>(text: String) -> Result<T, serde_json::Error> {
    serde_json::from_value(serde_json::Value::String(text))
}

impl TryFrom<String> for State {
    type Error = serde_json::Error;
    fn try_from(text: String) -> Result<Self, Self::Error> {
        parse(text)
    }
}

impl TryFrom<String> for Stage {
    type Error = serde_json::Error;
    fn try_from(text: String) -> Result<Self, Self::Error> {
        parse(text)
    }
}

/// What, with the bytes of the ride, determines the report.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Request {
    pub bike: Bike,
    pub options: Options,
}

/// Why a job failed.
#[derive(Clone, Debug, Serialize, Deserialize, ToSchema)]
pub struct Failure {
    /// `input` (trying again cannot help), `file` (the stored file is missing or was altered), `engine`, `deadline`,
    /// `memory` (it needs more than is allowed), `crash` or `internal`.
    pub kind: String,
    /// What went wrong, in words for the user.
    pub detail: String,
}

impl Failure {
    pub fn new(kind: &str, detail: impl Into<String>) -> Self {
        Self {
            kind: kind.to_owned(),
            detail: detail.into(),
        }
    }
}

#[derive(FromRow)]
pub struct JobRow {
    pub id: Uuid,
    pub group_name: String,
    pub ride_id: Uuid,
    pub ride_name: String,
    pub sha256: String,
    pub bike: String,
    pub request: Json<Request>,
    pub summary: Json<RideSummary>,
    #[sqlx(try_from = "String")]
    pub state: State,
    #[sqlx(try_from = "String")]
    pub stage: Stage,
    pub revision: i64,
    pub trials_total: i64,
    pub trials_done: i64,
    pub least_squares: Option<Json<PerAxle<Estimate>>>,
    pub verdict: Option<String>,
    /// Why a job that succeeded gave neither stiffness nor damping.
    pub no_result: Option<String>,
    pub failure: Option<Json<Failure>>,
    pub created_at: i64,
    pub started_at: Option<i64>,
    pub observed_at: Option<i64>,
    pub finished_at: Option<i64>,
    pub deleted_at: Option<i64>,
    /// Its place in the queue (`store/turn.rs`).
    pub turn: i64,
    /// When it was ridden or, where that is not known, uploaded.
    pub dated_at: i64,
    pub facts: Option<Json<Facts>>,
    /// The jobs whose rides it identifies as one.
    pub study: Option<Json<Vec<Uuid>>>,
}

/// A job about to be queued.
pub struct NewJob<'a> {
    pub id: Uuid,
    pub group: &'a str,
    /// The key that it was uploaded with.
    pub key: Option<Uuid>,
    pub ride: Uuid,
    pub bike: &'a str,
    pub fingerprint: &'a str,
    pub request: &'a Request,
    pub summary: &'a RideSummary,
    /// When it was ridden, if that is known.
    pub ridden_at: Option<i64>,
    /// The jobs whose rides it identifies as one.
    pub study: Option<&'a [Uuid]>,
}

/// Which jobs of a group a list holds; absent means any.
#[derive(Default)]
pub struct Filter<'a> {
    pub group: &'a str,
    pub state: Option<State>,
    pub bike: Option<&'a str>,
    pub verdict: Option<&'a str>,
    pub ride: Option<Uuid>,
    /// Without those that identify several rides as one.
    pub of_one_ride: bool,
    /// Those that are deleted, or those that are not.
    pub deleted: bool,
    pub tag: Option<&'a str>,
    /// Part of the ride's name, capitals or not.
    pub name: Option<&'a str>,
    /// Those in which this effect was named.
    pub effect: Option<&'a str>,
    /// Those whose rides and results are asked for.
    pub search: Search,
    /// Ridden from this time on and before that; uploaded, where it is not known when it was ridden.
    pub from_ms: Option<i64>,
    pub to_ms: Option<i64>,
    /// Jobs older than this one.
    pub before: Option<Uuid>,
}

macro_rules! select {
    ($rest:literal) => {
        concat!(
            "SELECT job.id, job.group_name, ride_id, ride.name AS ride_name, ride.sha256, bike, request, summary, ",
            "state, stage, revision, trials_total, trials_done, least_squares, verdict, no_result, ",
            "failure, created_at, started_at, observed_at, finished_at, deleted_at, turn, dated_at, facts, study ",
            "FROM job JOIN ride ON ride.id = job.ride_id ",
            $rest
        )
    };
}

/// A job of the group that is not deleted.
pub async fn find(db: &Db, group: &str, id: Uuid) -> sqlx::Result<Option<JobRow>> {
    const SQL: &str = select!("WHERE job.id = $1 AND job.group_name = $2 AND deleted_at IS NULL");
    on!(read db, p => sqlx::query_as(SQL).bind(id).bind(group).fetch_optional(p).await)
}

const SELECT_ANY: &str = select!("WHERE job.id = $1");

/// A job of whichever group, for those who work on it.
pub async fn load(db: &Db, id: Uuid) -> sqlx::Result<Option<JobRow>> {
    on!(read db, p => sqlx::query_as(SELECT_ANY).bind(id).fetch_optional(p).await)
}

/// The same, as a transaction sees it.
pub async fn load_in(tx: &mut Tx, id: Uuid) -> sqlx::Result<Option<JobRow>> {
    on!(tx, t => sqlx::query_as(SELECT_ANY).bind(id).fetch_optional(&mut **t).await)
}

/// Keeps others from changing the job until the transaction ends, and shows its River row, if it has
/// one; `None` when there is no such job. A transaction that changes a job and River's rows begins
/// with this: all take the job's lock first, so that no two wait for each other.
pub async fn lock(tx: &mut Tx, id: Uuid) -> sqlx::Result<Option<Option<i64>>> {
    // SQLite has one writer at a time; PostgreSQL has to be reported.
    const SQLITE: &str = "SELECT river_id FROM job WHERE id = $1";
    const POSTGRES: &str = "SELECT river_id FROM job WHERE id = $1 FOR UPDATE";
    let sql = tx.spelt(SQLITE, POSTGRES);
    on!(tx, t => sqlx::query_scalar(sql).bind(id).fetch_optional(&mut **t).await)
}

/// Adds the conditions that are asked for, and only those, so that the database can choose an index.
macro_rules! conditions {
    ($query:ident, $filter:ident) => {
        for (condition, value) in [
            (" AND state = ", $filter.state.map(State::name)),
            (" AND bike = ", $filter.bike),
            (" AND verdict = ", $filter.verdict),
        ] {
            if let Some(value) = value {
                $query.push(condition).push_bind(value);
            }
        }
        if $filter.of_one_ride {
            $query.push(" AND study IS NULL");
        }
        for (condition, id) in [
            (" AND ride_id = ", $filter.ride),
            (" AND job.id < ", $filter.before),
        ] {
            if let Some(id) = id {
                $query.push(condition).push_bind(id);
            }
        }
        for (condition, time) in [
            (" AND dated_at >= ", $filter.from_ms),
            (" AND dated_at < ", $filter.to_ms),
        ] {
            if let Some(time) = time {
                $query.push(condition).push_bind(time);
            }
        }
        if let Some(tag) = $filter.tag {
            $query.push(" AND ride_id IN (SELECT ride_id FROM ride_tag WHERE tag = ");
            $query.push_bind(tag).push(")");
        }
        if let Some(name) = $filter.name {
            // Without wildcards of their own, which LIKE has.
            $query.push(" AND ride_id IN (SELECT id FROM ride WHERE group_name = ");
            $query.push_bind($filter.group).push(" AND REPLACE(LOWER(name), LOWER(");
            $query.push_bind(name).push("), '') <> LOWER(name))");
        }
        if let Some(effect) = $filter.effect {
            // `/` follows `.`, so this is every name that begins with the effect's.
            $query.push(" AND job.id IN (SELECT job_id FROM parameter WHERE method = 'extended' AND group_name = ");
            $query.push_bind($filter.group).push(" AND name >= ");
            $query.push_bind(format!("{effect}.")).push(" AND name < ");
            $query.push_bind(format!("{effect}/")).push(")");
        }
        search!($query, $filter.search);
        $query.push(match $filter.deleted {
            true => " AND deleted_at IS NOT NULL",
            false => " AND deleted_at IS NULL",
        });
    };
}

/// Whether a job identifies several rides as one.
pub async fn is_study(tx: &mut Tx, id: Uuid) -> sqlx::Result<bool> {
    const SQL: &str = "SELECT study IS NOT NULL FROM job WHERE id = $1";
    let found: Option<bool> =
        on!(tx, t => sqlx::query_scalar(SQL).bind(id).fetch_optional(&mut **t).await)?;
    Ok(found.unwrap_or(false))
}

/// The ride of a job.
pub async fn ride(tx: &mut Tx, id: Uuid) -> sqlx::Result<Option<Uuid>> {
    const SQL: &str = "SELECT ride_id FROM job WHERE id = $1";
    on!(tx, t => sqlx::query_scalar(SQL).bind(id).fetch_optional(&mut **t).await)
}

/// Newest first.
pub async fn page(db: &Db, filter: &Filter<'_>, limit: i64) -> sqlx::Result<Vec<JobRow>> {
    on!(read db, p => {
        let mut query = QueryBuilder::new(select!("WHERE job.group_name = "));
        query.push_bind(filter.group);
        conditions!(query, filter);
        query.push(" ORDER BY job.id DESC LIMIT ").push_bind(limit);
        query.build_query_as().fetch_all(p).await
    })
}

/// The revision and whether the job is at its end: all that a poll needs when nothing changed.
pub async fn revision(db: &Db, group: &str, id: Uuid) -> sqlx::Result<Option<(i64, bool)>> {
    const SQL: &str = "\
        SELECT revision, state NOT IN ('queued', 'running') FROM job \
        WHERE id = $1 AND group_name = $2 AND deleted_at IS NULL";
    on!(read db, p => sqlx::query_as(SQL).bind(id).bind(group).fetch_optional(p).await)
}

/// The group's latest job with this fingerprint that did not fail and is not deleted.
pub async fn find_equal(tx: &mut Tx, group: &str, fingerprint: &str) -> sqlx::Result<Option<Uuid>> {
    const SQL: &str = "\
        SELECT id FROM job WHERE fingerprint = $1 AND group_name = $2 AND state IN ('queued', 'running', 'succeeded') AND deleted_at IS NULL \
        ORDER BY id DESC LIMIT 1";
    on!(tx, t => sqlx::query_scalar(SQL).bind(fingerprint).bind(group).fetch_optional(&mut **t).await)
}

pub async fn insert(tx: &mut Tx, job: &NewJob<'_>) -> sqlx::Result<()> {
    const SQL: &str = "\
        INSERT INTO job (id, ride_id, bike, fingerprint, request, summary, state, stage, revision, \
                         trials_total, trials_done, takeovers, created_at, group_name, key_id, dated_at, study) \
        VALUES ($1, $2, $3, $4, $5, $6, 'queued', 'observe', 1, $7, 0, 0, $8, $9, $10, $11, $12)";
    let trials = match job.study {
        Some(_) => 0,
        None => job.request.options.settings.trials as i64,
    };
    let now = now_ms();
    on!(tx, t => sqlx::query(SQL)
        .bind(job.id)
        .bind(job.ride)
        .bind(job.bike)
        .bind(job.fingerprint)
        .bind(Json(job.request))
        .bind(Json(job.summary))
        .bind(trials)
        .bind(now)
        .bind(job.group)
        .bind(job.key)
        .bind(job.ridden_at.unwrap_or(now))
        .bind(job.study.map(Json))
        .execute(&mut **t)
        .await
        .map(drop))
}

/// Notes that a process has picked the job up.
pub async fn start(tx: &mut Tx, id: Uuid) -> sqlx::Result<()> {
    const SQL: &str = "\
        UPDATE job SET state = 'running', started_at = $2, revision = revision + 1 \
        WHERE id = $1 AND state = 'queued'";
    on!(tx, t => sqlx::query(SQL).bind(id).bind(now_ms()).execute(&mut **t).await.map(drop))
}

/// Stores the least-squares estimate and turns to the trials; false when the job is not running.
pub async fn observed(
    tx: &mut Tx,
    id: Uuid,
    least_squares: &PerAxle<Estimate>,
) -> sqlx::Result<bool> {
    const SQL: &str = "\
        UPDATE job SET stage = 'trial', river_id = NULL, least_squares = $2, observed_at = $3, \
                       lost = 0, revision = revision + 1 \
        WHERE id = $1 AND state = 'running' AND stage = 'observe'";
    let changed = on!(tx, t => sqlx::query(SQL)
        .bind(id)
        .bind(Json(least_squares))
        .bind(now_ms())
        .execute(&mut **t)
        .await?
        .rows_affected());
    Ok(changed == 1)
}

/// Counts more finished trials; true for the one who finds the last of a running job among them.
pub async fn count_trials(tx: &mut Tx, id: Uuid, more: i64) -> sqlx::Result<bool> {
    const SQL: &str = "\
        UPDATE job SET trials_done = trials_done + $2, lost = 0, revision = revision + 1 \
        WHERE id = $1 AND state = 'running' RETURNING trials_done, trials_total";
    let counts: Option<(i64, i64)> =
        on!(tx, t => sqlx::query_as(SQL).bind(id).bind(more).fetch_optional(&mut **t).await)?;
    Ok(counts.is_some_and(|(done, total)| done == total))
}

/// Turns a job that is not at its end to a stage that the River row `river_id` works on, when its turn comes.
pub async fn enter(tx: &mut Tx, id: Uuid, stage: Stage, river_id: i64) -> sqlx::Result<()> {
    const SQL: &str = "\
        UPDATE job SET stage = $2, river_id = $3, lost = 0, revision = revision + 1 \
        WHERE id = $1 AND state IN ('queued', 'running')";
    on!(tx, t => sqlx::query(SQL)
        .bind(id)
        .bind(stage.name())
        .bind(river_id)
        .execute(&mut **t)
        .await
        .map(drop))?;
    river::line_up(tx, id).await
}

/// Gives the stage of a job that is not at its end to another River row.
pub async fn hand_over(tx: &mut Tx, id: Uuid, river_id: i64) -> sqlx::Result<()> {
    const SQL: &str = "\
        UPDATE job SET river_id = $2, revision = revision + 1 \
        WHERE id = $1 AND state IN ('queued', 'running')";
    on!(tx, t => sqlx::query(SQL).bind(id).bind(river_id).execute(&mut **t).await.map(drop))
}

/// Ends a running job well; false when it is not running.
pub async fn succeed(
    tx: &mut Tx,
    id: Uuid,
    verdict: Option<&str>,
    no_result: Option<&str>,
) -> sqlx::Result<bool> {
    const SQL: &str = "\
        UPDATE job SET state = 'succeeded', verdict = $2, river_id = NULL, finished_at = $3, \
                       revision = revision + 1, no_result = $4 \
        WHERE id = $1 AND state = 'running'";
    let changed = on!(tx, t => sqlx::query(SQL)
        .bind(id)
        .bind(verdict)
        .bind(now_ms())
        .bind(no_result)
        .execute(&mut **t)
        .await?
        .rows_affected());
    Ok(changed == 1)
}

/// Ends a job badly, as failed with a reason or as cancelled without; false when it was at its end.
pub async fn end(tx: &mut Tx, id: Uuid, failure: Option<&Failure>) -> sqlx::Result<bool> {
    const SQL: &str = "\
        UPDATE job SET state = $2, failure = $3, finished_at = $4, revision = revision + 1 \
        WHERE id = $1 AND state IN ('queued', 'running')";
    let state = if failure.is_some() {
        State::Failed
    } else {
        State::Cancelled
    };
    let changed = on!(tx, t => sqlx::query(SQL)
        .bind(id)
        .bind(state.name())
        .bind(failure.map(Json))
        .bind(now_ms())
        .execute(&mut **t)
        .await?
        .rows_affected());
    Ok(changed == 1)
}

/// Puts a job that ended in one of these states back to its beginning; false when it is in another, or deleted.
pub async fn reset(tx: &mut Tx, id: Uuid, from: [State; 2]) -> sqlx::Result<bool> {
    const SQL: &str = "\
        UPDATE job SET state = 'queued', stage = 'observe', trials_done = 0, takeovers = 0, lost = 0, \
                       least_squares = NULL, verdict = NULL, no_result = NULL, failure = NULL, started_at = NULL, \
                       observed_at = NULL, finished_at = NULL, refitted = NULL, revision = revision + 1 \
        WHERE id = $1 AND state IN ($2, $3) AND deleted_at IS NULL";
    let [one, other] = from.map(State::name);
    let changed = on!(tx, t => sqlx::query(SQL)
        .bind(id)
        .bind(one)
        .bind(other)
        .execute(&mut **t)
        .await?
        .rows_affected());
    Ok(changed == 1)
}

/// Number of jobs that are not at their end.
pub async fn unfinished(tx: &mut Tx) -> sqlx::Result<i64> {
    const SQL: &str = "SELECT COUNT(*) FROM job WHERE state IN ('queued', 'running')";
    on!(tx, t => sqlx::query_scalar(SQL).fetch_one(&mut **t).await)
}

/// Number of jobs in each state.
pub async fn counts(db: &Db) -> sqlx::Result<Vec<(String, i64)>> {
    const SQL: &str = "SELECT state, COUNT(*) FROM job GROUP BY state";
    on!(read db, p => sqlx::query_as(SQL).fetch_all(p).await)
}
