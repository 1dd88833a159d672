//! Who is notified of what, and what was reported last of the bicycles.

use sqlx::FromRow;
use uuid::Uuid;

use super::{Db, Tx, now_ms};

#[derive(Clone, FromRow)]
pub struct WebhookRow {
    pub id: Uuid,
    pub url: String,
    /// With blanks between.
    pub events: String,
    pub secret: String,
    pub created_at: i64,
    pub outcome: Option<String>,
    pub tried_at: Option<i64>,
}

impl WebhookRow {
    pub fn wants(&self, event: &str) -> bool {
        self.events.split(' ').any(|wanted| wanted == event)
    }
}

macro_rules! select {
    ($rest:literal) => {
        concat!(
            "SELECT id, url, events, secret, created_at, outcome, tried_at FROM webhook ",
            $rest
        )
    };
}

/// The group's webhooks, oldest first.
pub async fn of_group(db: &Db, group: &str) -> sqlx::Result<Vec<WebhookRow>> {
    const SQL: &str = select!("WHERE group_name = $1 ORDER BY id");
    on!(read db, p => sqlx::query_as(SQL).bind(group).fetch_all(p).await)
}

pub async fn find(db: &Db, group: &str, id: Uuid) -> sqlx::Result<Option<WebhookRow>> {
    const SQL: &str = select!("WHERE id = $1 AND group_name = $2");
    on!(read db, p => sqlx::query_as(SQL).bind(id).bind(group).fetch_optional(p).await)
}

/// A webhook of whichever group, for those who deliver.
pub async fn load(db: &Db, id: Uuid) -> sqlx::Result<Option<WebhookRow>> {
    const SQL: &str = select!("WHERE id = $1");
    on!(read db, p => sqlx::query_as(SQL).bind(id).fetch_optional(p).await)
}

pub async fn insert(tx: &mut Tx, group: &str, row: &WebhookRow) -> sqlx::Result<()> {
    const SQL: &str = "\
        INSERT INTO webhook (id, group_name, url, events, secret, created_at) VALUES ($1, $2, $3, $4, $5, $6)";
    on!(tx, t => sqlx::query(SQL)
        .bind(row.id)
        .bind(group)
        .bind(&row.url)
        .bind(&row.events)
        .bind(&row.secret)
        .bind(row.created_at)
        .execute(&mut **t)
        .await
        .map(drop))
}

/// Number of the group's webhooks.
pub async fn count(tx: &mut Tx, group: &str) -> sqlx::Result<i64> {
    const SQL: &str = "SELECT COUNT(*) FROM webhook WHERE group_name = $1";
    on!(tx, t => sqlx::query_scalar(SQL).bind(group).fetch_one(&mut **t).await)
}

/// False where there was none.
pub async fn delete(tx: &mut Tx, group: &str, id: Uuid) -> sqlx::Result<bool> {
    const SQL: &str = "DELETE FROM webhook WHERE id = $1 AND group_name = $2";
    let gone = on!(tx, t => sqlx::query(SQL).bind(id).bind(group).execute(&mut **t).await?.rows_affected());
    Ok(gone == 1)
}

/// Notes how an attempt ended.
pub async fn tried(tx: &mut Tx, id: Uuid, outcome: &str) -> sqlx::Result<()> {
    const SQL: &str = "UPDATE webhook SET outcome = $2, tried_at = $3 WHERE id = $1";
    on!(tx, t => sqlx::query(SQL).bind(id).bind(outcome).bind(now_ms()).execute(&mut **t).await.map(drop))
}

/// Whether anybody is notified of what becomes of a job.
pub async fn concerns(tx: &mut Tx, job: Uuid) -> sqlx::Result<bool> {
    const SQL: &str = "\
        SELECT COUNT(*) FROM webhook WHERE group_name = (SELECT group_name FROM job WHERE id = $1)";
    let count: i64 = on!(tx, t => sqlx::query_scalar(SQL).bind(job).fetch_one(&mut **t).await)?;
    Ok(count > 0)
}

/// Keeps others from notifying of a bicycle until the transaction ends.
pub async fn lock_bike(tx: &mut Tx, group: &str, bike: &str) -> sqlx::Result<()> {
    // SQLite has one writer at a time; PostgreSQL has to be reported.
    const LOCK: &str = "SELECT 1 FROM bike WHERE group_name = $1 AND name = $2 FOR UPDATE";
    if let Some(t) = tx.postgres() {
        sqlx::query(LOCK)
            .bind(group)
            .bind(bike)
            .execute(&mut **t)
            .await?;
    }
    Ok(())
}

/// Axle, name and what was reported last of a bicycle's parameters.
pub async fn announced(
    tx: &mut Tx,
    group: &str,
    bike: &str,
) -> sqlx::Result<Vec<(String, String, String)>> {
    const SQL: &str = "SELECT axle, name, kind FROM bike_told WHERE group_name = $1 AND bike = $2";
    on!(tx, t => sqlx::query_as(SQL).bind(group).bind(bike).fetch_all(&mut **t).await)
}

/// Keeps what was reported last.
pub async fn announce(
    tx: &mut Tx,
    group: &str,
    bike: &str,
    axle: &str,
    name: &str,
    kind: &str,
) -> sqlx::Result<()> {
    const SQL: &str = "\
        INSERT INTO bike_told (group_name, bike, axle, name, kind) VALUES ($1, $2, $3, $4, $5) \
        ON CONFLICT (group_name, bike, axle, name) DO UPDATE SET kind = excluded.kind";
    on!(tx, t => sqlx::query(SQL)
        .bind(group)
        .bind(bike)
        .bind(axle)
        .bind(name)
        .bind(kind)
        .execute(&mut **t)
        .await
        .map(drop))
}

/// Axle and name of the effects' parameters that this job identified and no other one of its bicycle's before it.
pub async fn new_effects(
    db: &Db,
    group: &str,
    bike: &str,
    job: Uuid,
) -> sqlx::Result<Vec<(String, String)>> {
    const SQL: &str = "\
        SELECT axle, name FROM parameter AS new \
        WHERE job_id = $1 AND method = 'extended' AND name LIKE '%.%' AND NOT EXISTS ( \
            SELECT 1 FROM parameter AS old \
            WHERE old.group_name = $2 AND old.bike = $3 AND old.job_id <> $1 AND old.method = 'extended' \
              AND old.axle = new.axle AND old.name = new.name \
              AND EXISTS (SELECT 1 FROM job WHERE job.id = old.job_id AND job.deleted_at IS NULL)) \
        ORDER BY axle, name";
    on!(read db, p => sqlx::query_as(SQL).bind(job).bind(group).bind(bike).fetch_all(p).await)
}
