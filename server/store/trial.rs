use sqlx::types::Json;
use sqlx::{FromRow, QueryBuilder};
use uuid::Uuid;
use veloid_engine::report::Trial;

use super::{Db, Tx, now_ms, river};

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
        .map(drop))?;
    river::line_up(tx, job).await
}

/// Stores the results of the trials from `first` on that have none yet; says how many those were.
pub async fn finish(tx: &mut Tx, job: Uuid, first: usize, results: &[Trial]) -> sqlx::Result<i64> {
    let stored = on!(tx, t => QueryBuilder::new("WITH found (trial_index, cost, result) AS (")
        .push_values((first as i64..).zip(results), |mut row, (index, result)| {
            let cost = result.best_cost.last().copied().filter(|c| c.is_finite());
            row.push_bind(index).push_bind(cost).push_bind(Json(result));
        })
        .push(") UPDATE trial SET cost = found.cost, result = found.result, finished_at = ")
        .push_bind(now_ms())
        .push(" FROM found WHERE trial.trial_index = found.trial_index AND trial.result IS NULL AND job_id = ")
        .push_bind(job)
        .build()
        .execute(&mut **t)
        .await?
        .rows_affected());
    Ok(stored as i64)
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
    const SQL: &str = "SELECT DISTINCT river_id FROM trial WHERE job_id = $1 AND result IS NULL";
    on!(tx, t => sqlx::query_scalar(SQL).bind(job).fetch_all(&mut **t).await)
}

/// Points the trials of one River row to the one that took over from it.
pub async fn hand_over(tx: &mut Tx, job: Uuid, from: i64, to: i64) -> sqlx::Result<()> {
    const SQL: &str = "UPDATE trial SET river_id = $3 WHERE job_id = $1 AND river_id = $2";
    on!(tx, t => sqlx::query(SQL)
        .bind(job)
        .bind(from)
        .bind(to)
        .execute(&mut **t)
        .await
        .map(drop))
}

pub async fn delete(tx: &mut Tx, job: Uuid) -> sqlx::Result<()> {
    const SQL: &str = "DELETE FROM trial WHERE job_id = $1";
    on!(tx, t => sqlx::query(SQL).bind(job).execute(&mut **t).await.map(drop))
}
