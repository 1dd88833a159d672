//! How transactions of SQLite begin.

use sqlx::{Sqlite, SqlitePool, Transaction};

/// Transactions of SQLite that write take the lock at their beginning, since one that reads first cannot take
/// it later; their commits wait for the disk, or do not.
pub(super) const SYNCED: &str = "PRAGMA synchronous = FULL; BEGIN IMMEDIATE";
pub(super) const LAX: &str = "PRAGMA synchronous = NORMAL; BEGIN IMMEDIATE";

/// Begins a transaction on a task of its own, as River begins its own: who is cancelled midway leaves none
/// open.
pub(super) async fn begin_sqlite(
    pool: &SqlitePool,
    how: &'static str,
) -> sqlx::Result<Transaction<'static, Sqlite>> {
    let pool = pool.clone();
    let begun = tokio::spawn(async move { pool.begin_with(how).await }).await;
    begun.unwrap_or_else(|error| Err(sqlx::Error::Io(std::io::Error::other(error))))
}
