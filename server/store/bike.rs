use sqlx::FromRow;
use sqlx::types::Json;
use veloid_engine::bicycle::Bike;

use super::{Db, Tx, now_ms};

/// A bicycle of the fleet with the state of its latest job.
#[derive(FromRow)]
pub struct BikeRow {
    pub name: String,
    pub document: Json<Bike>,
    pub created_at: i64,
    pub updated_at: i64,
    pub jobs: i64,
}

const SELECT_PAGE: &str = "\
    SELECT name, document, created_at, updated_at, \
           (SELECT COUNT(*) FROM job WHERE job.group_name = $1 AND job.bike = bike.name \
            AND job.deleted_at IS NULL) AS jobs \
    FROM bike WHERE group_name = $1 AND name > $2 AND deleted_at IS NULL ORDER BY name LIMIT $3";

const SELECT_ONE: &str = "\
    SELECT name, document, created_at, updated_at, \
           (SELECT COUNT(*) FROM job WHERE job.group_name = $1 AND job.bike = bike.name \
            AND job.deleted_at IS NULL) AS jobs \
    FROM bike WHERE group_name = $1 AND name = $2 AND deleted_at IS NULL";

const UPSERT: &str = "\
    INSERT INTO bike (group_name, name, document, created_at, updated_at) VALUES ($1, $2, $3, $4, $4) \
    ON CONFLICT (group_name, name) DO UPDATE \
    SET document = excluded.document, updated_at = excluded.updated_at, deleted_at = NULL";

/// Bikes in the order of their names, after the one named `after`.
pub async fn page(db: &Db, group: &str, after: &str, limit: i64) -> sqlx::Result<Vec<BikeRow>> {
    on!(read db, p => sqlx::query_as(SELECT_PAGE).bind(group).bind(after).bind(limit).fetch_all(p).await)
}

pub async fn find(db: &Db, group: &str, name: &str) -> sqlx::Result<Option<BikeRow>> {
    // No name holds a NUL, and PostgreSQL refuses to be asked for one.
    if name.contains('\0') {
        return Ok(None);
    }
    on!(read db, p => sqlx::query_as(SELECT_ONE).bind(group).bind(name).fetch_optional(p).await)
}

/// Keeps the bike file under its name, in place of an earlier one, deleted or not.
pub async fn upsert(tx: &mut Tx, group: &str, name: &str, bike: &Bike) -> sqlx::Result<()> {
    on!(tx, t => sqlx::query(UPSERT)
        .bind(group)
        .bind(name)
        .bind(Json(bike))
        .bind(now_ms())
        .execute(&mut **t)
        .await
        .map(drop))
}
