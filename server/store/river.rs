//! The few statements that touch River's own tables (pinned `riverqueue = "=0.5.0"`).

use sqlx::FromRow;
use uuid::Uuid;

use super::{Db, Tx};

/// A River row that is `running` for a process that is gone.
#[derive(FromRow)]
pub struct Orphan {
    pub id: i64,
    pub kind: String,
    pub args: String,
}

/// Kinds of rows that notify others of what happened; nobody's ride waits for them.
macro_rules! news {
    () => {
        "('announce', 'deliver')"
    };
}

/// A `running` row whose last owner is not in the `worker` table. Two texts: the dialects keep the
/// array of owners differently.
macro_rules! orphaned {
    (sqlite) => {
        "state = 'running' AND NOT EXISTS ( \
            SELECT 1 FROM worker WHERE worker.id = json_extract(river_job.attempted_by, '$[#-1]'))"
    };
    (postgres) => {
        "state = 'running' AND NOT EXISTS ( \
            SELECT 1 FROM worker \
            WHERE worker.id = river_job.attempted_by[array_upper(river_job.attempted_by, 1)])"
    };
}

pub async fn orphans(db: &Db) -> sqlx::Result<Vec<Orphan>> {
    const SQLITE: &str = concat!(
        "SELECT id, kind, json(args) AS args FROM river_job WHERE kind NOT IN ",
        news!(),
        " AND ",
        orphaned!(sqlite)
    );
    const POSTGRES: &str = concat!(
        "SELECT id, kind, CAST(args AS TEXT) AS args FROM river_job WHERE kind NOT IN ",
        news!(),
        " AND ",
        orphaned!(postgres)
    );
    let sql = db.spelt(SQLITE, POSTGRES);
    on!(read db, p => sqlx::query_as(sql).fetch_all(p).await)
}

/// Lets others send what processes that are gone were sending. What is sent twice has one identifier.
pub async fn notify_again(tx: &mut Tx) -> sqlx::Result<()> {
    const SQLITE: &str = concat!(
        "UPDATE river_job SET state = 'available' WHERE kind IN ",
        news!(),
        " AND ",
        orphaned!(sqlite)
    );
    const POSTGRES: &str = concat!(
        "UPDATE river_job SET state = 'available' WHERE kind IN ",
        news!(),
        " AND ",
        orphaned!(postgres)
    );
    let sql = tx.spelt(SQLITE, POSTGRES);
    on!(tx, t => sqlx::query(sql).execute(&mut **t).await.map(drop))
}

/// Ends an orphan so that its late owner's result is refused; false when it no longer is one.
pub async fn discard(tx: &mut Tx, id: i64) -> sqlx::Result<bool> {
    const SQLITE: &str = concat!(
        "UPDATE river_job SET state = 'discarded', finalized_at = datetime('now', 'subsec') \
         WHERE id = $1 AND ",
        orphaned!(sqlite)
    );
    const POSTGRES: &str = concat!(
        "UPDATE river_job SET state = 'discarded', finalized_at = now() WHERE id = $1 AND ",
        orphaned!(postgres)
    );
    let sql = tx.spelt(SQLITE, POSTGRES);
    let changed = on!(tx, t => sqlx::query(sql).bind(id).execute(&mut **t).await?.rows_affected());
    Ok(changed == 1)
}

/// Forgets the leader: on SQLite the only process that could have been it is gone, and waiting for
/// the lease to run out would delay retries.
pub async fn forget_leader(tx: &mut Tx) -> sqlx::Result<()> {
    on!(tx, t => sqlx::query("DELETE FROM river_leader").execute(&mut **t).await.map(drop))
}

/// Lets rows run now that wait for longer than anything but a delivery is ever put off: the clock was set back after
/// they were queued.
pub async fn hasten(tx: &mut Tx) -> sqlx::Result<()> {
    const SQLITE: &str = "\
        UPDATE river_job SET scheduled_at = datetime('now', 'subsec') \
        WHERE state IN ('available', 'retryable', 'scheduled') AND kind <> 'deliver' \
          AND scheduled_at > datetime('now', '+1 minute')";
    const POSTGRES: &str = "\
        UPDATE river_job SET scheduled_at = now() \
        WHERE state IN ('available', 'retryable', 'scheduled') AND kind <> 'deliver' \
          AND scheduled_at > now() + interval '1 minute'";
    let sql = tx.spelt(SQLITE, POSTGRES);
    on!(tx, t => sqlx::query(sql).execute(&mut **t).await.map(drop))
}

/// Gives the rows of a job that wait the place that its turn gives them.
pub async fn line_up(tx: &mut Tx, job: Uuid) -> sqlx::Result<()> {
    macro_rules! sql {
        ($time:literal) => {
            concat!(
                "UPDATE river_job SET scheduled_at = (SELECT ",
                $time,
                " FROM job WHERE id = $1) WHERE state = 'available' AND id IN ( \
                    SELECT river_id FROM job WHERE id = $1 \
                    UNION SELECT river_id FROM trial WHERE job_id = $1 AND result IS NULL)"
            )
        };
    }
    const SQLITE: &str = sql!("strftime('%Y-%m-%d %H:%M:%f', turn / 1000.0, 'unixepoch')");
    const POSTGRES: &str = sql!("to_timestamp(turn / 1000.0)");
    let sql = tx.spelt(SQLITE, POSTGRES);
    on!(tx, t => sqlx::query(sql).bind(job).execute(&mut **t).await.map(drop))
}

/// Gives a message the place that its group's turn gives it (`store/turn.rs`), among those that were not tried.
pub async fn line_up_delivery(tx: &mut Tx, row: i64, group: &str) -> sqlx::Result<()> {
    // Times of a turn are in 1970, those of messages that were put off are not.
    const SQLITE: &str = "\
        UPDATE river_job SET scheduled_at = ( \
            SELECT strftime('%Y-%m-%d %H:%M:%f', \
                MAX(COALESCE(MIN(turn), 0), COALESCE(MAX(CASE WHEN whose = $2 THEN turn END) + 1, 0)) / 1000.0, 'unixepoch') \
            FROM (SELECT CAST(ROUND(unixepoch(scheduled_at, 'subsec') * 1000) AS INTEGER) AS turn, \
                         json_extract(args, '$.group') AS whose \
                  FROM river_job WHERE state = 'available' AND queue = 'deliveries' AND scheduled_at < '1971-01-01')) \
        WHERE id = $1";
    const POSTGRES: &str = "\
        UPDATE river_job SET scheduled_at = ( \
            SELECT to_timestamp( \
                GREATEST(COALESCE(MIN(turn), 0), COALESCE(MAX(CASE WHEN whose = $2 THEN turn END) + 1, 0)) / 1000.0) \
            FROM (SELECT CAST(ROUND(EXTRACT(EPOCH FROM scheduled_at) * 1000) AS BIGINT) AS turn, args ->> 'group' AS whose \
                  FROM river_job WHERE state = 'available' AND queue = 'deliveries' AND scheduled_at < '1971-01-01 UTC') \
            AS waiting) \
        WHERE id = $1";
    let sql = tx.spelt(SQLITE, POSTGRES);
    on!(tx, t => sqlx::query(sql).bind(row).bind(group).execute(&mut **t).await.map(drop))
}

/// Puts rows that were begun before and wait again, with the time of their return for a turn, before
/// those that were not begun.
pub async fn begun_first(tx: &mut Tx) -> sqlx::Result<()> {
    const SQL: &str = "\
        UPDATE river_job SET priority = 1 \
        WHERE state = 'available' AND priority > 1 AND attempted_at IS NOT NULL";
    on!(tx, t => sqlx::query(SQL).execute(&mut **t).await.map(drop))
}

/// Moves rows of the separate queues that earlier versions had for swarms and diagnoses, and messages that they had among
/// the news.
pub async fn join_queues(tx: &mut Tx) -> sqlx::Result<()> {
    const SQL: &str = "\
        UPDATE river_job SET queue = CASE kind WHEN 'deliver' THEN 'deliveries' ELSE 'long' END \
        WHERE queue IN ('swarm', 'heavy', 'diagnosis', 'news') AND (queue <> 'news' OR kind = 'deliver') \
          AND state IN ('available', 'retryable', 'scheduled')";
    on!(tx, t => sqlx::query(SQL).execute(&mut **t).await.map(drop))
}

macro_rules! stray {
    () => {
        "state IN ('queued', 'running') \
         AND NOT EXISTS ( \
            SELECT 1 FROM river_job WHERE river_job.id = job.river_id \
              AND river_job.state NOT IN ('completed', 'cancelled', 'discarded')) \
         AND NOT EXISTS ( \
            SELECT 1 FROM trial JOIN river_job ON river_job.id = trial.river_id \
            WHERE trial.job_id = job.id AND trial.result IS NULL \
              AND river_job.state NOT IN ('completed', 'cancelled', 'discarded'))"
    };
}

/// Jobs that are not at their end although the queue holds nothing for them any more, because River
/// gave up a row (attempts used, or aborted) before our code could say so.
pub async fn strays(db: &Db) -> sqlx::Result<Vec<Uuid>> {
    const SQL: &str = concat!("SELECT id FROM job WHERE ", stray!());
    on!(read db, p => sqlx::query_scalar(SQL).fetch_all(p).await)
}

/// Whether a job that the transaction has locked is a stray.
pub async fn is_stray(tx: &mut Tx, job: Uuid) -> sqlx::Result<bool> {
    const SQL: &str = concat!("SELECT id FROM job WHERE id = $1 AND ", stray!());
    let found: Option<Uuid> =
        on!(tx, t => sqlx::query_scalar(SQL).bind(job).fetch_optional(&mut **t).await)?;
    Ok(found.is_some())
}
