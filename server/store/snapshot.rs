//! Copies of a SQLite database, made while others write to it.

use std::path::Path;

use sqlx::sqlite::SqliteConnectOptions;
use sqlx::{ConnectOptions, Connection};

#[derive(Debug, thiserror::Error)]
pub enum SnapshotError {
    #[error("database: {0}")]
    Database(#[from] sqlx::Error),
    #[error("the database is damaged: {0}")]
    Damaged(String),
}

/// Writes the database in one file, as it is at this moment, into a file that is not there yet. Gives
/// the SHA-256 of every raw file that a ride of the copy has.
pub async fn snapshot(from: &Path, to: &Path) -> Result<Vec<String>, SnapshotError> {
    let mut source = SqliteConnectOptions::new().filename(from).connect().await?;
    sqlx::query("VACUUM INTO $1")
        .bind(to.to_string_lossy())
        .execute(&mut source)
        .await?;
    source.close().await?;

    let mut copy = SqliteConnectOptions::new().filename(to).connect().await?;
    let found: String = sqlx::query_scalar("PRAGMA integrity_check(1)")
        .fetch_one(&mut copy)
        .await?;
    if found != "ok" {
        return Err(SnapshotError::Damaged(found));
    }
    const FILES: &str = "\
        SELECT sha256 FROM ride WHERE id NOT IN (SELECT ride_id FROM ride_file) \
        UNION SELECT sha256 FROM ride_file ORDER BY sha256";
    let files = sqlx::query_scalar(FILES).fetch_all(&mut copy).await?;
    copy.close().await?;
    Ok(files)
}
