//! Who did what, and when. Rows are only ever added.

use sqlx::FromRow;
use uuid::Uuid;

use super::{Db, Tx, now_ms};

/// Who did it.
#[derive(Clone, Copy)]
pub enum Actor {
    Key(Uuid),
    /// Someone whom the server asks for no key.
    Keyless,
    /// The server by itself.
    Server,
    /// A command of the operator's.
    Command,
}

impl Actor {
    pub(super) fn name(self) -> &'static str {
        match self {
            Actor::Key(_) => "key",
            Actor::Keyless => "keyless",
            Actor::Server => "server",
            Actor::Command => "command",
        }
    }

    pub(super) fn key(self) -> Option<Uuid> {
        match self {
            Actor::Key(key) => Some(key),
            _ => None,
        }
    }
}

#[derive(FromRow)]
pub struct AuditRow {
    pub id: Uuid,
    pub actor: String,
    pub key_id: Option<Uuid>,
    pub action: String,
    pub subject: String,
    pub done_at: i64,
}

pub async fn note(
    tx: &mut Tx,
    group: &str,
    actor: Actor,
    action: &str,
    subject: &str,
) -> sqlx::Result<()> {
    const SQL: &str = "\
        INSERT INTO audit (id, group_name, actor, key_id, action, subject, done_at) \
        VALUES ($1, $2, $3, $4, $5, $6, $7)";
    on!(tx, t => sqlx::query(SQL)
        .bind(Uuid::now_v7())
        .bind(group)
        .bind(actor.name())
        .bind(actor.key())
        .bind(action)
        .bind(subject)
        .bind(now_ms())
        .execute(&mut **t)
        .await
        .map(drop))
}

/// What was done in a group, newest first.
pub async fn page(
    db: &Db,
    group: &str,
    before: Option<Uuid>,
    limit: i64,
) -> sqlx::Result<Vec<AuditRow>> {
    const SQL: &str = "\
        SELECT id, actor, key_id, action, subject, done_at FROM audit \
        WHERE group_name = $1 AND ($2 IS NULL OR id < $2) ORDER BY id DESC LIMIT $3";
    on!(read db, p => sqlx::query_as(SQL).bind(group).bind(before).bind(limit).fetch_all(p).await)
}
