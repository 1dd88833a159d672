//! Processes that work on jobs, and their heartbeats by the database's clock.

use super::{Db, Tx};

/// The database's own clock in epoch milliseconds: the two dialects have no common spelling.
pub(super) fn clock(tx: &Tx) -> &'static str {
    tx.spelt(
        "SELECT CAST(unixepoch('subsec') * 1000 AS INTEGER)",
        "SELECT CAST(EXTRACT(EPOCH FROM clock_timestamp()) * 1000 AS BIGINT)",
    )
}

pub(super) async fn now(tx: &mut Tx) -> sqlx::Result<i64> {
    let sql = clock(tx);
    on!(tx, t => sqlx::query_scalar(sql).fetch_one(&mut **t).await)
}

/// Says that the worker is alive; the time by the database's clock.
pub async fn beat(tx: &mut Tx, id: &str, slots: i64) -> sqlx::Result<i64> {
    const SQL: &str = "\
        INSERT INTO worker (id, version, slots, started_at, beat_at) VALUES ($1, $2, $3, $4, $4) \
        ON CONFLICT (id) DO UPDATE SET beat_at = excluded.beat_at";
    let now = now(tx).await?;
    on!(tx, t => sqlx::query(SQL)
        .bind(id)
        .bind(env!("CARGO_PKG_VERSION"))
        .bind(slots)
        .bind(now)
        .execute(&mut **t)
        .await
        .map(drop))?;
    Ok(now)
}

/// Forgets one worker, at its orderly end.
pub async fn leave(tx: &mut Tx, id: &str) -> sqlx::Result<()> {
    on!(tx, t => sqlx::query("DELETE FROM worker WHERE id = $1")
        .bind(id)
        .execute(&mut **t)
        .await
        .map(drop))
}

/// Forgets workers that have not beaten for `lease_ms`, or in a time to come, before the clock was set
/// back; all of them with 0. How many there were.
pub async fn expire(tx: &mut Tx, lease_ms: i64) -> sqlx::Result<u64> {
    const SQL: &str = "DELETE FROM worker WHERE beat_at <= $1 OR beat_at > $2";
    let now = now(tx).await?;
    let gone = on!(tx, t => sqlx::query(SQL)
        .bind(now - lease_ms)
        .bind(now + lease_ms)
        .execute(&mut **t)
        .await?
        .rows_affected());
    Ok(gone)
}

pub async fn count(db: &Db) -> sqlx::Result<i64> {
    on!(read db, p => sqlx::query_scalar("SELECT COUNT(*) FROM worker").fetch_one(p).await)
}
