//! Raw files whose last ride was erased. A row stays until its file is removed from the store, or a ride has the
//! same bytes again.

use super::{Db, Tx};

/// Records that no ride has this file any more.
pub async fn add(tx: &mut Tx, sha256: &str, erased_at: i64) -> sqlx::Result<()> {
    const SQL: &str = "\
        INSERT INTO erased_file (sha256, erased_at) VALUES ($1, $2) \
        ON CONFLICT (sha256) DO UPDATE SET erased_at = excluded.erased_at";
    on!(tx, t => sqlx::query(SQL).bind(sha256).bind(erased_at).execute(&mut **t).await.map(drop))
}

/// Files recorded until a time (epoch ms) with names after this one, in their order.
pub async fn due(db: &Db, until: i64, after: &str, limit: i64) -> sqlx::Result<Vec<String>> {
    const SQL: &str = "\
        SELECT sha256 FROM erased_file WHERE erased_at <= $1 AND sha256 > $2 ORDER BY sha256 LIMIT $3";
    on!(read db, p => sqlx::query_scalar(SQL).bind(until).bind(after).bind(limit).fetch_all(p).await)
}

/// Removes the row of a file.
pub async fn forget(tx: &mut Tx, sha256: &str) -> sqlx::Result<()> {
    const SQL: &str = "DELETE FROM erased_file WHERE sha256 = $1";
    on!(tx, t => sqlx::query(SQL).bind(sha256).execute(&mut **t).await.map(drop))
}
