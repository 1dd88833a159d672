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

/// Bytes of the database and of the raw files of its rides.
pub async fn size(database: &Path) -> Result<u64, SnapshotError> {
    const SQL: &str = "\
        SELECT (page_count - freelist_count) * page_size + COALESCE((SELECT SUM(bytes) FROM ( \
            SELECT sha256, MAX(bytes) AS bytes FROM ( \
                SELECT sha256, bytes FROM ride WHERE id NOT IN (SELECT ride_id FROM ride_file) \
                UNION ALL SELECT sha256, bytes FROM ride_file) AS file GROUP BY sha256)), 0) \
        FROM pragma_page_count(), pragma_freelist_count(), pragma_page_size()";
    let options = SqliteConnectOptions::new().filename(database);
    let mut connection = options.connect().await?;
    let bytes: i64 = sqlx::query_scalar(SQL).fetch_one(&mut connection).await?;
    connection.close().await?;
    Ok(bytes.unsigned_abs())
}

/// Writes the database in one file, as it is at this moment, into a file that is not there yet. Gives
/// the SHA-256 of every raw file that a ride of the copy has.
pub async fn snapshot(from: &Path, to: &Path) -> Result<Vec<String>, SnapshotError> {
    let mut source = SqliteConnectOptions::new().filename(from).connect().await?;
    let written = sqlx::query("VACUUM INTO $1")
        .bind(to.to_string_lossy())
        .execute(&mut source)
        .await;
    // Nothing is written there any more once it is closed.
    source.close().await?;
    written?;

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
