//! The few statements that touch River's own tables (pinned `riverqueue = "=0.5.0"`).

use sqlx::FromRow;

use super::Tx;

/// A River row that is `running` for a process that is gone.
#[derive(FromRow)]
pub struct Orphan {
    pub id: i64,
    pub kind: String,
    pub args: String,
}

/// `running` rows whose last owner is not in the `worker` table. Two texts: the dialects keep the
/// array of owners differently, and only PostgreSQL has other sweepers to skip.
pub async fn orphans(tx: &mut Tx) -> sqlx::Result<Vec<Orphan>> {
    const SQLITE: &str = "\
        SELECT id, kind, json(args) AS args FROM river_job \
        WHERE state = 'running' AND NOT EXISTS ( \
            SELECT 1 FROM worker WHERE worker.id = json_extract(river_job.attempted_by, '$[#-1]'))";
    const POSTGRES: &str = "\
        SELECT id, kind, CAST(args AS TEXT) AS args FROM river_job \
        WHERE state = 'running' AND NOT EXISTS ( \
            SELECT 1 FROM worker \
            WHERE worker.id = river_job.attempted_by[array_upper(river_job.attempted_by, 1)]) \
        FOR UPDATE SKIP LOCKED";
    match tx {
        Tx::Sqlite(t) => sqlx::query_as(SQLITE).fetch_all(&mut **t).await,
        Tx::Postgres(t) => sqlx::query_as(POSTGRES).fetch_all(&mut **t).await,
    }
}

/// Ends an orphan so that its late owner's result is refused; false when it ended meanwhile.
pub async fn discard(tx: &mut Tx, id: i64) -> sqlx::Result<bool> {
    const SQLITE: &str = "\
        UPDATE river_job SET state = 'discarded', finalized_at = datetime('now', 'subsec') \
        WHERE id = $1 AND state = 'running'";
    const POSTGRES: &str = "\
        UPDATE river_job SET state = 'discarded', finalized_at = now() \
        WHERE id = $1 AND state = 'running'";
    let changed = match tx {
        Tx::Sqlite(t) => sqlx::query(SQLITE)
            .bind(id)
            .execute(&mut **t)
            .await?
            .rows_affected(),
        Tx::Postgres(t) => sqlx::query(POSTGRES)
            .bind(id)
            .execute(&mut **t)
            .await?
            .rows_affected(),
    };
    Ok(changed == 1)
}

/// Forgets the leader: on SQLite the only process that could have been it is gone, and waiting for
/// the lease to run out would delay retries.
pub async fn forget_leader(tx: &mut Tx) -> sqlx::Result<()> {
    on!(tx, t => sqlx::query("DELETE FROM river_leader").execute(&mut **t).await.map(drop))
}

/// Jobs that are not at their end although the queue holds nothing for them any more, because River
/// gave up a row (attempts used, or aborted) before our code could say so.
pub async fn strays(tx: &mut Tx) -> sqlx::Result<Vec<uuid::Uuid>> {
    const SQL: &str = "\
        SELECT id FROM job WHERE state IN ('queued', 'running') AND NOT EXISTS ( \
            SELECT 1 FROM river_job \
            WHERE river_job.state NOT IN ('completed', 'cancelled', 'discarded') \
              AND (river_job.id = job.river_id OR river_job.id IN ( \
                  SELECT river_id FROM trial WHERE trial.job_id = job.id AND result IS NULL)))";
    on!(tx, t => sqlx::query_scalar(SQL).fetch_all(&mut **t).await)
}
