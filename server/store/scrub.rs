//! What `veloid check` asks of the database.

use sqlx::FromRow;
use sqlx::types::Json;
use uuid::Uuid;
use veloid_engine::bicycle::Bike;

use super::{Db, is_damage};
use crate::facts::Facts;

/// A raw file as the rides have it.
#[derive(FromRow)]
pub struct StoredFile {
    pub sha256: String,
    pub bytes: i64,
}

/// What is wrong with the pages and indices of the database. PostgreSQL sees to that by itself.
pub async fn integrity(db: &Db) -> sqlx::Result<Vec<String>> {
    let Some(read) = db.sqlite() else {
        return Ok(Vec::new());
    };
    // Nothing more can be asked of damaged pages.
    if let Some(fault) = first_fault(db).await? {
        return Ok(vec![fault]);
    }
    let mut faults: Vec<String> = sqlx::query_scalar("PRAGMA integrity_check(100)")
        .fetch_all(read)
        .await?;
    faults.retain(|fault| fault != "ok");
    Ok(faults)
}

/// Rows that belong to rows that are not there. PostgreSQL lets none be.
pub async fn orphans(db: &Db) -> sqlx::Result<Vec<String>> {
    let Some(read) = db.sqlite() else {
        return Ok(Vec::new());
    };
    let orphans: Vec<(String, Option<i64>, String, i64)> =
        sqlx::query_as("PRAGMA foreign_key_check")
            .fetch_all(read)
            .await?;
    let lacks = |(table, row, parent, _): (String, Option<i64>, String, i64)| {
        let row = row.map(|row| format!(" {row}")).unwrap_or_default();
        format!("row{row} of {table} belongs to a missing row of {parent}")
    };
    Ok(orphans.into_iter().map(lacks).collect())
}

/// The first fault of SQLite's pages, found faster and without looking into indices.
pub async fn first_fault(db: &Db) -> sqlx::Result<Option<String>> {
    let Some(read) = db.sqlite() else {
        return Ok(None);
    };
    let found: sqlx::Result<String> = sqlx::query_scalar("PRAGMA quick_check(1)")
        .fetch_one(read)
        .await;
    match found {
        Ok(found) => Ok((found != "ok").then_some(found)),
        Err(error) if is_damage(&error) => Ok(Some(error.to_string())),
        Err(error) => Err(error),
    }
}

/// Files of rides with names after this one, in their order.
pub async fn files(db: &Db, after: &str, limit: i64) -> sqlx::Result<Vec<StoredFile>> {
    const SQL: &str = "\
        SELECT sha256, MAX(bytes) AS bytes FROM ( \
            SELECT sha256, bytes FROM ride \
            WHERE NOT EXISTS (SELECT 1 FROM ride_file WHERE ride_id = ride.id) \
            UNION ALL SELECT sha256, bytes FROM ride_file) AS file \
        WHERE sha256 > $1 GROUP BY sha256 ORDER BY sha256 LIMIT $2";
    on!(read db, p => sqlx::query_as(SQL).bind(after).bind(limit).fetch_all(p).await)
}

/// Jobs after this one, in the order of their ids.
pub async fn jobs(db: &Db, after: Uuid, limit: i64) -> sqlx::Result<Vec<Uuid>> {
    const SQL: &str = "SELECT id FROM job WHERE id > $1 ORDER BY id LIMIT $2";
    on!(read db, p => sqlx::query_scalar(SQL).bind(after).bind(limit).fetch_all(p).await)
}

/// Rides after this one, in the order of their ids.
pub async fn rides(db: &Db, after: Uuid, limit: i64) -> sqlx::Result<Vec<Uuid>> {
    const SQL: &str = "SELECT id FROM ride WHERE id > $1 ORDER BY id LIMIT $2";
    on!(read db, p => sqlx::query_scalar(SQL).bind(after).bind(limit).fetch_all(p).await)
}

/// A ride as its own row has it.
#[derive(FromRow)]
pub struct StoredRide {
    pub sha256: String,
    pub bytes: i64,
    pub facts: Option<Json<Facts>>,
    pub jobs: i64,
}

pub async fn ride(db: &Db, id: Uuid) -> sqlx::Result<Option<StoredRide>> {
    const SQL: &str = "\
        SELECT sha256, bytes, facts, (SELECT COUNT(*) FROM job WHERE ride_id = ride.id) AS jobs \
        FROM ride WHERE id = $1";
    on!(read db, p => sqlx::query_as(SQL).bind(id).fetch_optional(p).await)
}

/// The tags by which a ride is found.
pub async fn tags(db: &Db, ride: Uuid) -> sqlx::Result<Vec<String>> {
    const SQL: &str = "SELECT tag FROM ride_tag WHERE ride_id = $1";
    on!(read db, p => sqlx::query_scalar(SQL).bind(ride).fetch_all(p).await)
}

/// Group and name of every bicycle.
pub async fn bikes(db: &Db) -> sqlx::Result<Vec<(String, String)>> {
    const SQL: &str = "SELECT group_name, name FROM bike ORDER BY group_name, name";
    on!(read db, p => sqlx::query_as(SQL).fetch_all(p).await)
}

/// The bike file of a bicycle.
pub async fn bike(db: &Db, group: &str, name: &str) -> sqlx::Result<Option<Json<Bike>>> {
    const SQL: &str = "SELECT document FROM bike WHERE group_name = $1 AND name = $2";
    on!(read db, p => sqlx::query_scalar(SQL).bind(group).bind(name).fetch_optional(p).await)
}

/// A parameter as the fleet has it.
#[derive(FromRow)]
pub struct StoredParameter {
    pub method: String,
    pub axle: String,
    pub name: String,
    pub value: f64,
    pub std_error: Option<f64>,
    pub unit: String,
    pub bike: String,
    pub group_name: String,
    pub verdict: Option<String>,
    pub version: String,
}

pub async fn parameters(db: &Db, job: Uuid) -> sqlx::Result<Vec<StoredParameter>> {
    const SQL: &str = "\
        SELECT method, axle, name, value, std_error, unit, bike, group_name, verdict, version \
        FROM parameter WHERE job_id = $1";
    on!(read db, p => sqlx::query_as(SQL).bind(job).fetch_all(p).await)
}

/// Idempotency keys that name another request than their jobs do.
pub async fn keys_of_others(db: &Db) -> sqlx::Result<Vec<(String, Uuid)>> {
    const SQL: &str = "\
        SELECT idempotency_key.name, job.id FROM idempotency_key JOIN job ON job.id = job_id \
        WHERE idempotency_key.fingerprint <> job.fingerprint OR idempotency_key.group_name <> job.group_name";
    on!(read db, p => sqlx::query_as(SQL).fetch_all(p).await)
}

/// Keys that did something and are not there; keys are never removed.
pub async fn missing_keys(db: &Db) -> sqlx::Result<Vec<Uuid>> {
    const SQL: &str = "\
        SELECT DISTINCT key_id FROM audit WHERE key_id IS NOT NULL AND key_id NOT IN (SELECT id FROM api_key)";
    on!(read db, p => sqlx::query_scalar(SQL).fetch_all(p).await)
}

/// Actions and subjects of what was noted about webhooks and bicycles' events, oldest first.
pub async fn noted(db: &Db) -> sqlx::Result<Vec<(String, String)>> {
    const SQL: &str = "\
        SELECT action, subject FROM audit \
        WHERE action IN ('create webhook', 'delete webhook') \
           OR action IN ('create', 'delete') AND subject LIKE 'event %' \
           OR action = 'erase' AND subject LIKE '% events of bike %' \
        ORDER BY id";
    on!(read db, p => sqlx::query_as(SQL).fetch_all(p).await)
}

/// All webhooks and bicycles' events.
pub async fn notables(db: &Db) -> sqlx::Result<Vec<Uuid>> {
    const SQL: &str = "SELECT id FROM webhook UNION ALL SELECT id FROM bike_event";
    on!(read db, p => sqlx::query_scalar(SQL).fetch_all(p).await)
}

/// What was read, or what is wrong with it, apart from faults of the connection.
pub fn readable<T>(read: sqlx::Result<T>) -> sqlx::Result<Result<T, String>> {
    match read {
        Ok(row) => Ok(Ok(row)),
        Err(error @ (sqlx::Error::ColumnDecode { .. } | sqlx::Error::Decode(_))) => {
            Ok(Err(error.to_string()))
        }
        Err(error) => Err(error),
    }
}
