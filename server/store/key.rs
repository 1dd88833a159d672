//! Keys that open the server. Of a key only its SHA-256 is kept: 256 random bits need no slow hash.

use std::fmt;

use clap::ValueEnum;
use sqlx::FromRow;
use uuid::Uuid;

use super::{Db, Tx, now_ms};

/// Group of whatever comes without a key, and of all that was there before there were groups.
pub const HOME: &str = "default";

/// What a key is good for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Scope {
    /// Fetch rides, jobs and results of the group.
    Read,
    /// Upload rides, cancel and retry jobs of the group.
    Upload,
    /// Both, and the operator's figures, which count all groups.
    Admin,
}

const SCOPES: [(Scope, &str); 3] = [
    (Scope::Read, "read"),
    (Scope::Upload, "upload"),
    (Scope::Admin, "admin"),
];

/// The scopes of a key; in the database their names.
#[derive(Clone, Debug)]
pub struct Scopes(pub Vec<Scope>);

impl Scopes {
    pub fn allow(&self, scope: Scope) -> bool {
        self.0.contains(&scope) || self.0.contains(&Scope::Admin)
    }
}

impl From<String> for Scopes {
    /// A name that this version does not know allows nothing.
    fn from(text: String) -> Self {
        let known = |word: &str| SCOPES.iter().find(|(_, name)| *name == word);
        Self(
            text.split(' ')
                .filter_map(|word| known(word).map(|(scope, _)| *scope))
                .collect(),
        )
    }
}

impl fmt::Display for Scopes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<&str> = SCOPES
            .iter()
            .filter(|(scope, _)| self.0.contains(scope))
            .map(|(_, name)| *name)
            .collect();
        f.write_str(&names.join(" "))
    }
}

#[derive(Clone, Debug, FromRow)]
pub struct KeyRow {
    pub id: Uuid,
    pub name: String,
    pub group_name: String,
    #[sqlx(try_from = "String")]
    pub scopes: Scopes,
    pub max_upload_bytes: Option<i64>,
    pub requests_per_minute: Option<i64>,
    pub unfinished_jobs: Option<i64>,
    pub created_at: i64,
    pub expires_at: Option<i64>,
    pub last_used_at: Option<i64>,
    pub revoked_at: Option<i64>,
}

impl KeyRow {
    pub fn is_valid(&self) -> bool {
        self.revoked_at.is_none() && self.expires_at.is_none_or(|end| now_ms() < end)
    }
}

macro_rules! select {
    ($rest:literal) => {
        concat!(
            "SELECT id, name, group_name, scopes, max_upload_bytes, requests_per_minute, \
                    unfinished_jobs, created_at, expires_at, last_used_at, revoked_at \
             FROM api_key ",
            $rest
        )
    };
}

pub async fn insert(tx: &mut Tx, sha256: &str, key: &KeyRow) -> sqlx::Result<()> {
    const SQL: &str = "\
        INSERT INTO api_key (id, sha256, name, group_name, scopes, max_upload_bytes, \
                             requests_per_minute, unfinished_jobs, created_at, expires_at) \
        VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10)";
    on!(tx, t => sqlx::query(SQL)
        .bind(key.id)
        .bind(sha256)
        .bind(&key.name)
        .bind(&key.group_name)
        .bind(key.scopes.to_string())
        .bind(key.max_upload_bytes)
        .bind(key.requests_per_minute)
        .bind(key.unfinished_jobs)
        .bind(key.created_at)
        .bind(key.expires_at)
        .execute(&mut **t)
        .await
        .map(drop))
}

pub async fn find(db: &Db, sha256: &str) -> sqlx::Result<Option<KeyRow>> {
    const SQL: &str = select!("WHERE sha256 = $1");
    on!(read db, p => sqlx::query_as(SQL).bind(sha256).fetch_optional(p).await)
}

pub async fn by_id(db: &Db, id: Uuid) -> sqlx::Result<Option<KeyRow>> {
    const SQL: &str = select!("WHERE id = $1");
    on!(read db, p => sqlx::query_as(SQL).bind(id).fetch_optional(p).await)
}

/// All keys, oldest first.
pub async fn list(db: &Db) -> sqlx::Result<Vec<KeyRow>> {
    const SQL: &str = select!("ORDER BY id");
    on!(read db, p => sqlx::query_as(SQL).fetch_all(p).await)
}

/// Closes the server to a key for good; false when it was not open to it.
pub async fn revoke(tx: &mut Tx, id: Uuid) -> sqlx::Result<bool> {
    const SQL: &str = "UPDATE api_key SET revoked_at = $2 WHERE id = $1 AND revoked_at IS NULL";
    let changed = on!(tx, t => sqlx::query(SQL)
        .bind(id)
        .bind(now_ms())
        .execute(&mut **t)
        .await?
        .rows_affected());
    Ok(changed == 1)
}

/// Notes that the key was used.
pub async fn used(tx: &mut Tx, id: Uuid) -> sqlx::Result<()> {
    const SQL: &str = "UPDATE api_key SET last_used_at = $2 WHERE id = $1";
    on!(tx, t => sqlx::query(SQL).bind(id).bind(now_ms()).execute(&mut **t).await.map(drop))
}

/// Keeps others from queueing with this key until the transaction ends, and counts its jobs that are
/// not at their end.
pub async fn unfinished_jobs(tx: &mut Tx, id: Uuid) -> sqlx::Result<i64> {
    // SQLite has one writer at a time; PostgreSQL has to be reported.
    const LOCK: &str = "SELECT id FROM api_key WHERE id = $1 FOR NO KEY UPDATE";
    const COUNT: &str =
        "SELECT COUNT(*) FROM job WHERE key_id = $1 AND state IN ('queued', 'running')";
    if let Some(t) = tx.postgres() {
        sqlx::query(LOCK).bind(id).execute(&mut **t).await?;
    }
    on!(tx, t => sqlx::query_scalar(COUNT).bind(id).fetch_one(&mut **t).await)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scopes_are_kept_by_name_and_admin_has_all() {
        let scopes = Scopes::from("read nonsense".to_owned());
        assert!(scopes.allow(Scope::Read) && !scopes.allow(Scope::Upload));
        assert_eq!(scopes.to_string(), "read");
        assert!(Scopes(vec![Scope::Admin]).allow(Scope::Upload));
        assert!(!Scopes::from(String::new()).allow(Scope::Read));
    }
}
