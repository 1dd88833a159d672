//! What is deleted. Jobs and bikes are marked with the time, which hides them; a ride is deleted when all of
//! its jobs are. What bears a mark for long enough is erased, by `erasure/prune.rs`.

use sqlx::FromRow;
use uuid::Uuid;

use super::{Db, Tx};

/// Whose jobs are meant.
#[derive(Clone, Copy)]
pub enum Of<'a> {
    Ride(Uuid),
    Bike(&'a str),
}

impl<'a> Of<'a> {
    fn ride(self) -> Option<Uuid> {
        match self {
            Of::Ride(ride) => Some(ride),
            Of::Bike(_) => None,
        }
    }

    fn bike(self) -> Option<&'a str> {
        match self {
            Of::Ride(_) => None,
            Of::Bike(bike) => Some(bike),
        }
    }
}

/// Runs a statement on jobs of the group `$1` that belong to the ride `$2` or the bike `$3`.
macro_rules! on_jobs {
    ($tx:expr, $sql:expr, $group:expr, $of:expr, |$query:ident, $t:ident| $run:expr) => {
        on!($tx, $t => {
            let $query = sqlx::query_scalar($sql).bind($group).bind($of.ride()).bind($of.bike());
            $run
        })
    };
}

/// Keeps others from changing these jobs until the transaction ends, in the order in which all who lock
/// several do; how many there are.
pub async fn lock(tx: &mut Tx, group: &str, of: Of<'_>) -> sqlx::Result<i64> {
    // SQLite has one writer at a time; PostgreSQL has to be reported.
    const SQLITE: &str = "\
        SELECT COUNT(*) FROM job WHERE group_name = $1 AND (ride_id = $2 OR bike = $3)";
    const POSTGRES: &str = "\
        SELECT COUNT(*) FROM ( \
            SELECT id FROM job WHERE group_name = $1 AND (ride_id = $2 OR bike = $3) \
            ORDER BY id FOR UPDATE) AS locked";
    let sql = tx.spelt(SQLITE, POSTGRES);
    on_jobs!(tx, sql, group, of, |query, t| query
        .fetch_one(&mut **t)
        .await)
}

/// Whether none of them is left that is not deleted.
pub async fn is_whole(tx: &mut Tx, group: &str, of: Of<'_>) -> sqlx::Result<bool> {
    const SQL: &str = "\
        SELECT COUNT(*) FROM job \
        WHERE group_name = $1 AND (ride_id = $2 OR bike = $3) AND deleted_at IS NULL";
    let left: i64 = on_jobs!(tx, SQL, group, of, |query, t| query
        .fetch_one(&mut **t)
        .await)?;
    Ok(left == 0)
}

/// Those of them that are not at their end.
pub async fn unfinished(tx: &mut Tx, group: &str, of: Of<'_>) -> sqlx::Result<Vec<Uuid>> {
    const SQL: &str = "\
        SELECT id FROM job \
        WHERE group_name = $1 AND (ride_id = $2 OR bike = $3) AND state IN ('queued', 'running') \
        ORDER BY id";
    on_jobs!(tx, SQL, group, of, |query, t| query
        .fetch_all(&mut **t)
        .await)
}

/// Marks those that bear no mark yet; how many. Whoever sends one of them again under its idempotency
/// key makes a new one.
pub async fn mark(tx: &mut Tx, group: &str, of: Of<'_>, at: i64) -> sqlx::Result<u64> {
    const KEYS: &str = "\
        DELETE FROM idempotency_key WHERE job_id IN ( \
            SELECT id FROM job WHERE group_name = $1 AND (ride_id = $2 OR bike = $3) AND deleted_at IS NULL)";
    const MARK: &str = "\
        UPDATE job SET deleted_at = $4, revision = revision + 1 \
        WHERE group_name = $1 AND (ride_id = $2 OR bike = $3) AND deleted_at IS NULL";
    on!(tx, t => {
        let keys = sqlx::query(KEYS).bind(group).bind(of.ride()).bind(of.bike());
        keys.execute(&mut **t).await?;
        let mark = sqlx::query(MARK).bind(group).bind(of.ride()).bind(of.bike());
        Ok(mark.bind(at).execute(&mut **t).await?.rows_affected())
    })
}

/// Marks jobs of the group that ended and were made before a time; how many.
pub async fn mark_before(tx: &mut Tx, group: &str, before: i64, at: i64) -> sqlx::Result<u64> {
    const SQL: &str = "\
        UPDATE job SET deleted_at = $3, revision = revision + 1 \
        WHERE group_name = $1 AND created_at < $2 AND finished_at IS NOT NULL AND deleted_at IS NULL";
    on!(tx, t => Ok(sqlx::query(SQL)
        .bind(group)
        .bind(before)
        .bind(at)
        .execute(&mut **t)
        .await?
        .rows_affected()))
}

/// Takes marks off, all or those of one time, and off the bikes of these jobs and what was deleted with them; how many jobs come back.
pub async fn unmark(
    tx: &mut Tx,
    group: &str,
    of: Of<'_>,
    marked_at: Option<i64>,
) -> sqlx::Result<u64> {
    const JOBS: &str = "\
        UPDATE job SET deleted_at = NULL, revision = revision + 1 \
        WHERE group_name = $1 AND (ride_id = $2 OR bike = $3) AND deleted_at IS NOT NULL \
          AND (CAST($4 AS BIGINT) IS NULL OR deleted_at = $4)";
    // Those that were deleted with their bikes.
    const EVENTS: &str = "\
        UPDATE bike_event SET deleted_at = NULL \
        WHERE group_name = $1 AND deleted_at IS NOT NULL AND EXISTS ( \
            SELECT 1 FROM bike WHERE bike.group_name = $1 AND bike.name = bike_event.bike \
              AND bike.deleted_at = bike_event.deleted_at AND (bike.name = $3 OR bike.name IN ( \
                  SELECT job.bike FROM job WHERE job.group_name = $1 AND job.ride_id = $2)))";
    const BIKES: &str = "\
        UPDATE bike SET deleted_at = NULL \
        WHERE group_name = $1 AND deleted_at IS NOT NULL AND (name = $3 OR name IN ( \
            SELECT bike FROM job WHERE group_name = $1 AND ride_id = $2))";
    on!(tx, t => {
        let jobs = sqlx::query(JOBS).bind(group).bind(of.ride()).bind(of.bike());
        let back = jobs.bind(marked_at).execute(&mut **t).await?.rows_affected();
        let events = sqlx::query(EVENTS).bind(group).bind(of.ride()).bind(of.bike());
        events.execute(&mut **t).await?;
        let bikes = sqlx::query(BIKES).bind(group).bind(of.ride()).bind(of.bike());
        bikes.execute(&mut **t).await?;
        Ok(back)
    })
}

/// Marks a bike and its events; false when the group has none of this name that is not marked.
pub async fn mark_bike(tx: &mut Tx, group: &str, name: &str, at: i64) -> sqlx::Result<bool> {
    const SQL: &str = "\
        UPDATE bike SET deleted_at = $3 WHERE group_name = $1 AND name = $2 AND deleted_at IS NULL";
    const EVENTS: &str = "\
        UPDATE bike_event SET deleted_at = $3 WHERE group_name = $1 AND bike = $2 AND deleted_at IS NULL";
    on!(tx, t => {
        let bike = sqlx::query(SQL).bind(group).bind(name).bind(at);
        let changed = bike.execute(&mut **t).await?.rows_affected() == 1;
        if changed {
            let events = sqlx::query(EVENTS).bind(group).bind(name).bind(at);
            events.execute(&mut **t).await?;
        }
        Ok(changed)
    })
}

/// When a bike was marked, if it is.
pub async fn bike_mark(tx: &mut Tx, group: &str, name: &str) -> sqlx::Result<Option<i64>> {
    const SQL: &str = "\
        SELECT deleted_at FROM bike WHERE group_name = $1 AND name = $2 AND deleted_at IS NOT NULL";
    on!(tx, t => sqlx::query_scalar(SQL).bind(group).bind(name).fetch_optional(&mut **t).await)
}

/// A job whose mark is old enough.
#[derive(Clone, FromRow)]
pub struct Due {
    pub id: Uuid,
    pub ride_id: Uuid,
    pub group_name: String,
}

/// Jobs that were marked at a time or before, after one of them, in the order of their ids.
pub async fn due(db: &Db, until: i64, after: Uuid, limit: i64) -> sqlx::Result<Vec<Due>> {
    const SQL: &str = "\
        SELECT id, ride_id, group_name FROM job \
        WHERE deleted_at IS NOT NULL AND deleted_at <= $1 AND id > $2 ORDER BY id LIMIT $3";
    on!(read db, p => sqlx::query_as(SQL).bind(until).bind(after).bind(limit).fetch_all(p).await)
}

/// Whether a job still bears a mark of that age, as seen by the transaction that has locked it.
pub async fn is_due(tx: &mut Tx, id: Uuid, until: i64) -> sqlx::Result<bool> {
    const SQL: &str = "SELECT id FROM job WHERE id = $1 AND deleted_at <= $2";
    let found: Option<Uuid> =
        on!(tx, t => sqlx::query_scalar(SQL).bind(id).bind(until).fetch_optional(&mut **t).await)?;
    Ok(found.is_some())
}

/// Erases a job with all that belongs to it.
pub async fn erase_job(tx: &mut Tx, id: Uuid) -> sqlx::Result<()> {
    const SQL: &str = "DELETE FROM job WHERE id = $1";
    on!(tx, t => sqlx::query(SQL).bind(id).execute(&mut **t).await.map(drop))
}

/// Erases bikes that were marked at a time or before and have no job left; their groups and names.
pub async fn erase_bikes(tx: &mut Tx, until: i64) -> sqlx::Result<Vec<(String, String)>> {
    const SQL: &str = "\
        DELETE FROM bike WHERE deleted_at <= $1 AND NOT EXISTS ( \
            SELECT 1 FROM job WHERE job.group_name = bike.group_name AND job.bike = bike.name) \
        RETURNING group_name, name";
    on!(tx, t => sqlx::query_as(SQL).bind(until).fetch_all(&mut **t).await)
}

/// Groups that have jobs.
pub async fn groups(db: &Db) -> sqlx::Result<Vec<String>> {
    const SQL: &str = "SELECT DISTINCT group_name FROM job ORDER BY group_name";
    on!(read db, p => sqlx::query_scalar(SQL).fetch_all(p).await)
}
