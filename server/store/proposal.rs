//! Rides that reports propose next, and the studies that may settle what those reports left open.

use sqlx::FromRow;
use sqlx::types::Json;
use uuid::Uuid;
use veloid_engine::report::diagnosis::NextRide;

use super::{Db, Tx};

#[derive(FromRow)]
pub struct ProposalRow {
    pub job_id: Uuid,
    pub ride_name: String,
    pub next_ride: Json<NextRide>,
}

/// A job that identifies several rides as one.
#[derive(FromRow)]
pub struct StudyRow {
    pub id: Uuid,
    pub state: String,
    pub verdict: Option<String>,
    pub study: Json<Vec<Uuid>>,
}

/// Verdicts of a study that leave nothing open: one set of effects, or none.
const SETTLED: [&str; 2] = ["named", "nothing_missing"];

impl StudyRow {
    /// The newest study that a ride takes part in, of those that have a result or may still get one.
    pub fn newest_with(studies: &[Self], job: Uuid) -> Option<&Self> {
        let mut alive = studies.iter().filter(|study| study.is_alive());
        alive.find(|study| study.study.contains(&job))
    }

    /// Whether its verdict leaves nothing open.
    pub fn is_settled(&self) -> bool {
        (self.verdict.as_deref()).is_some_and(|verdict| SETTLED.contains(&verdict))
    }

    fn is_alive(&self) -> bool {
        !["failed", "cancelled"].contains(&self.state.as_str())
    }
}

/// Stores what a job's report proposes, in place of what an earlier one did.
pub async fn put(tx: &mut Tx, job: Uuid, next: Option<&NextRide>) -> sqlx::Result<()> {
    const DROP: &str = "DELETE FROM proposal WHERE job_id = $1";
    const SQL: &str = "INSERT INTO proposal (job_id, next_ride) VALUES ($1, $2)";
    on!(tx, t => {
        sqlx::query(DROP).bind(job).execute(&mut **t).await?;
        if let Some(next) = next {
            sqlx::query(SQL).bind(job).bind(Json(next)).execute(&mut **t).await?;
        }
        Ok(())
    })
}

/// Proposals of a bicycle's rides, the latest ride's first, each ride's by its newest job.
pub async fn of_bike(
    db: &Db,
    group: &str,
    bike: &str,
    limit: i64,
) -> sqlx::Result<Vec<ProposalRow>> {
    const SQL: &str = concat!(
        "SELECT job_id, ride.name AS ride_name, next_ride \
         FROM proposal JOIN job ON job.id = job_id JOIN ride ON ride.id = job.ride_id \
         WHERE job.group_name = $1 AND job.bike = $2 AND job.state = 'succeeded' AND job.deleted_at IS NULL AND ",
        newest_of_ride!(),
        " ORDER BY dated_at DESC, job.id DESC LIMIT $3"
    );
    on!(read db, p => sqlx::query_as(SQL).bind(group).bind(bike).bind(limit).fetch_all(p).await)
}

/// Studies of a bicycle, newest first.
pub async fn studies(db: &Db, group: &str, bike: &str, limit: i64) -> sqlx::Result<Vec<StudyRow>> {
    const SQL: &str = "\
        SELECT id, state, verdict, study FROM job \
        WHERE group_name = $1 AND bike = $2 AND study IS NOT NULL AND deleted_at IS NULL ORDER BY id DESC LIMIT $3";
    on!(read db, p => sqlx::query_as(SQL).bind(group).bind(bike).bind(limit).fetch_all(p).await)
}

/// Jobs of a bicycle that are queued or running.
pub async fn unfinished(db: &Db, group: &str, bike: &str) -> sqlx::Result<i64> {
    const SQL: &str = "\
        SELECT COUNT(*) FROM job \
        WHERE group_name = $1 AND bike = $2 AND state IN ('queued', 'running') AND deleted_at IS NULL";
    on!(read db, p => sqlx::query_scalar(SQL).bind(group).bind(bike).fetch_one(p).await)
}
