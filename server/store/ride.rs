use sqlx::FromRow;
use uuid::Uuid;

use super::{Db, Tx, now_ms};

/// Stands for the SHA-256 of a ride that is only told of (`veloid seed`): there is no file.
pub const TOLD: &str = "season";

/// An uploaded file.
#[derive(FromRow)]
pub struct RideRow {
    pub sha256: String,
    pub name: String,
    pub bytes: i64,
    pub uploaded_at: i64,
}

const UPSERT: &str = "\
    INSERT INTO ride (id, group_name, sha256, name, bytes, uploaded_at) VALUES ($1, $2, $3, $4, $5, $6) \
    ON CONFLICT (group_name, sha256, name) DO UPDATE SET bytes = excluded.bytes RETURNING id";

/// Records a file that lies in the store; the same bytes under the same name stay one ride.
pub async fn upsert(
    tx: &mut Tx,
    group: &str,
    sha256: &str,
    name: &str,
    bytes: i64,
) -> sqlx::Result<Uuid> {
    on!(tx, t => sqlx::query_scalar(UPSERT)
        .bind(Uuid::now_v7())
        .bind(group)
        .bind(sha256)
        .bind(name)
        .bind(bytes)
        .bind(now_ms())
        .fetch_one(&mut **t)
        .await)
}

/// Number of uploaded files, of all groups.
pub async fn real(db: &Db) -> sqlx::Result<i64> {
    const SQL: &str = "SELECT COUNT(*) FROM ride WHERE sha256 <> $1";
    on!(read db, p => sqlx::query_scalar(SQL).bind(TOLD).fetch_one(p).await)
}

pub async fn find(db: &Db, group: &str, id: Uuid) -> sqlx::Result<Option<RideRow>> {
    const SQL: &str =
        "SELECT sha256, name, bytes, uploaded_at FROM ride WHERE id = $1 AND group_name = $2";
    on!(read db, p => sqlx::query_as(SQL).bind(id).bind(group).fetch_optional(p).await)
}
