//! What `veloid check` asks of the database.

use sqlx::FromRow;
use uuid::Uuid;

use super::{Db, is_damage};

/// A raw file as the rides have it.
#[derive(FromRow)]
pub struct StoredFile {
    pub sha256: String,
    pub bytes: i64,
}

/// What is wrong with the database itself. PostgreSQL sees to that by itself.
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
    let orphans: Vec<(String, Option<i64>, String, i64)> =
        sqlx::query_as("PRAGMA foreign_key_check")
            .fetch_all(read)
            .await?;
    let lacks = |(table, row, parent, _): (String, Option<i64>, String, i64)| {
        let row = row.map(|row| format!(" {row}")).unwrap_or_default();
        format!("row{row} of {table} belongs to a missing row of {parent}")
    };
    faults.extend(orphans.into_iter().map(lacks));
    Ok(faults)
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

/// Jobs that succeeded and have no report.
pub async fn without_report(db: &Db) -> sqlx::Result<Vec<Uuid>> {
    const SQL: &str = "\
        SELECT job.id FROM job WHERE state = 'succeeded' AND NOT EXISTS ( \
            SELECT 1 FROM result WHERE result.job_id = job.id AND result.name = 'report') \
        ORDER BY job.id";
    on!(read db, p => sqlx::query_scalar(SQL).fetch_all(p).await)
}
