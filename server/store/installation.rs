//! The id of the one installation that a database belongs to.

use uuid::Uuid;

use super::{Db, Tx, now_ms, soon};

pub async fn find(db: &Db) -> sqlx::Result<Option<Uuid>> {
    const SQL: &str = "SELECT id FROM installation";
    on!(read db, p => sqlx::query_scalar(SQL).fetch_optional(p).await)
}

/// The same, or an error soon.
pub async fn ask(db: &Db) -> sqlx::Result<Option<Uuid>> {
    const SQL: &str = "SELECT id FROM installation";
    soon(async { on!(signs db, p => sqlx::query_scalar(SQL).fetch_optional(p).await) }).await
}

/// Keeps others from recording an id until the transaction ends; the id that is recorded.
pub async fn lock(tx: &mut Tx) -> sqlx::Result<Option<Uuid>> {
    const SQL: &str = "SELECT id FROM installation";
    // SQLite has one writer at a time.
    if let Some(t) = tx.postgres() {
        let lock = sqlx::query("LOCK TABLE installation IN EXCLUSIVE MODE");
        lock.execute(&mut **t).await?;
    }
    on!(tx, t => sqlx::query_scalar(SQL).fetch_optional(&mut **t).await)
}

/// Records the id, in place of any other.
pub async fn put(tx: &mut Tx, id: Uuid) -> sqlx::Result<()> {
    const SQL: &str = "\
        INSERT INTO installation (single, id, created_at) VALUES (1, $1, $2) \
        ON CONFLICT (single) DO UPDATE SET id = excluded.id, created_at = excluded.created_at";
    on!(tx, t => sqlx::query(SQL).bind(id).bind(now_ms()).execute(&mut **t).await.map(drop))
}
