use sqlx::types::Json;
use sqlx::{FromRow, QueryBuilder};
use uuid::Uuid;
use veloid_engine::report::Trial;

use super::{Db, Tx, now_ms};

#[derive(FromRow)]
pub struct TrialRow {
    pub trial_index: i64,
    pub seed: i64,
    pub result: Option<Json<Trial>>,
    pub finished_at: Option<i64>,
}

/// Trials with the seeds from `seed` on, each with its row of River.
pub async fn insert(tx: &mut Tx, job: Uuid, seed: u64, river: &[i64]) -> sqlx::Result<()> {
    const SQL: &str = "INSERT INTO trial (job_id, trial_index, seed, river_id) ";
    on!(tx, t => QueryBuilder::new(SQL)
        .push_values((0..).zip(river), |mut row, (index, river_id)| {
            row.push_bind(job)
                .push_bind(index)
                .push_bind(seed.cast_signed().wrapping_add(index))
                .push_bind(river_id);
        })
        .build()
        .execute(&mut **t)
        .await
        .map(drop))
}

/// Stores a trial's result unless it has one already; says whether it did.
pub async fn finish(tx: &mut Tx, job: Uuid, index: i64, result: &Trial) -> sqlx::Result<bool> {
    const SQL: &str = "\
        UPDATE trial SET cost = $3, result = $4, finished_at = $5 \
        WHERE job_id = $1 AND trial_index = $2 AND result IS NULL";
    let cost = result.best_cost.last().copied().filter(|c| c.is_finite());
    let changed = on!(tx, t => sqlx::query(SQL)
        .bind(job)
        .bind(index)
        .bind(cost)
        .bind(Json(result))
        .bind(now_ms())
        .execute(&mut **t)
        .await?
        .rows_affected());
    Ok(changed == 1)
}

/// A job's trials in the order of their index.
pub async fn list(db: &Db, job: Uuid) -> sqlx::Result<Vec<TrialRow>> {
    const SQL: &str = "\
        SELECT trial_index, seed, result, finished_at FROM trial \
        WHERE job_id = $1 ORDER BY trial_index";
    on!(read db, p => sqlx::query_as(SQL).bind(job).fetch_all(p).await)
}

/// River's rows of the trials that are still to be done.
pub async fn unfinished(tx: &mut Tx, job: Uuid) -> sqlx::Result<Vec<i64>> {
    const SQL: &str = "SELECT river_id FROM trial WHERE job_id = $1 AND result IS NULL";
    on!(tx, t => sqlx::query_scalar(SQL).bind(job).fetch_all(&mut **t).await)
}

/// Points a trial to the River row that took over from another.
pub async fn hand_over(tx: &mut Tx, job: Uuid, index: i64, river_id: i64) -> sqlx::Result<()> {
    const SQL: &str = "UPDATE trial SET river_id = $3 WHERE job_id = $1 AND trial_index = $2";
    on!(tx, t => sqlx::query(SQL)
        .bind(job)
        .bind(index)
        .bind(river_id)
        .execute(&mut **t)
        .await
        .map(drop))
}

pub async fn delete(tx: &mut Tx, job: Uuid) -> sqlx::Result<()> {
    const SQL: &str = "DELETE FROM trial WHERE job_id = $1";
    on!(tx, t => sqlx::query(SQL).bind(job).execute(&mut **t).await.map(drop))
}
