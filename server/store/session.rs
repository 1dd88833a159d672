//! Browsers that are signed in, each with a token of its own. A session ends with its key, if not before.

use sqlx::FromRow;
use uuid::Uuid;

use super::{Db, Tx, now_ms};

#[derive(FromRow)]
pub struct SessionRow {
    pub id: Uuid,
    pub key_id: Uuid,
    pub key_name: String,
    pub created_at: i64,
    pub expires_at: i64,
}

/// Begins a session of a key, and forgets those that are over.
pub async fn begin(tx: &mut Tx, sha256: &str, key: Uuid, lasts_ms: i64) -> sqlx::Result<()> {
    const OVER: &str = "DELETE FROM session WHERE expires_at <= $1";
    const SQL: &str = "\
        INSERT INTO session (id, sha256, key_id, created_at, expires_at) VALUES ($1, $2, $3, $4, $5)";
    let now = now_ms();
    on!(tx, t => {
        sqlx::query(OVER).bind(now).execute(&mut **t).await?;
        sqlx::query(SQL)
            .bind(Uuid::now_v7())
            .bind(sha256)
            .bind(key)
            .bind(now)
            .bind(now + lasts_ms)
            .execute(&mut **t)
            .await
            .map(drop)
    })
}

/// The session of a token and its key, unless it is over.
pub async fn find(db: &Db, sha256: &str) -> sqlx::Result<Option<(Uuid, Uuid)>> {
    const SQL: &str = "SELECT id, key_id FROM session WHERE sha256 = $1 AND expires_at > $2";
    on!(read db, p => sqlx::query_as(SQL).bind(sha256).bind(now_ms()).fetch_optional(p).await)
}

/// Whether a session goes on.
pub async fn goes_on(db: &Db, id: Uuid) -> sqlx::Result<bool> {
    const SQL: &str = "SELECT id FROM session WHERE id = $1 AND expires_at > $2";
    let found: Option<Uuid> =
        on!(read db, p => sqlx::query_scalar(SQL).bind(id).bind(now_ms()).fetch_optional(p).await)?;
    Ok(found.is_some())
}

/// Ends the session of a token, if there is one.
pub async fn end(tx: &mut Tx, sha256: &str) -> sqlx::Result<()> {
    const SQL: &str = "DELETE FROM session WHERE sha256 = $1";
    on!(tx, t => sqlx::query(SQL).bind(sha256).execute(&mut **t).await.map(drop))
}

/// Ends a session; false when there is none of this id.
pub async fn revoke(tx: &mut Tx, id: Uuid) -> sqlx::Result<bool> {
    const SQL: &str = "DELETE FROM session WHERE id = $1";
    let changed = on!(tx, t => sqlx::query(SQL).bind(id).execute(&mut **t).await?.rows_affected());
    Ok(changed == 1)
}

/// All sessions of keys that are not revoked, oldest first.
pub async fn list(db: &Db) -> sqlx::Result<Vec<SessionRow>> {
    const SQL: &str = "\
        SELECT session.id, key_id, api_key.name AS key_name, session.created_at, session.expires_at \
        FROM session JOIN api_key ON api_key.id = key_id \
        WHERE session.expires_at > $1 AND revoked_at IS NULL ORDER BY session.id";
    on!(read db, p => sqlx::query_as(SQL).bind(now_ms()).fetch_all(p).await)
}
