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
           (SELECT COUNT(*) FROM job WHERE job.bike = bike.name) AS jobs \
    FROM bike WHERE name > $1 ORDER BY name LIMIT $2";

const SELECT_ONE: &str = "\
    SELECT name, document, created_at, updated_at, \
           (SELECT COUNT(*) FROM job WHERE job.bike = bike.name) AS jobs \
    FROM bike WHERE name = $1";

const UPSERT: &str = "\
    INSERT INTO bike (name, document, created_at, updated_at) VALUES ($1, $2, $3, $3) \
    ON CONFLICT (name) DO UPDATE SET document = excluded.document, updated_at = excluded.updated_at";

/// Bikes in the order of their names, after the one named `after`.
pub async fn page(db: &Db, after: &str, limit: i64) -> sqlx::Result<Vec<BikeRow>> {
    on!(read db, p => sqlx::query_as(SELECT_PAGE).bind(after).bind(limit).fetch_all(p).await)
}

pub async fn find(db: &Db, name: &str) -> sqlx::Result<Option<BikeRow>> {
    // No name holds a NUL, and PostgreSQL refuses to be asked for one.
    if name.contains('\0') {
        return Ok(None);
    }
    on!(read db, p => sqlx::query_as(SELECT_ONE).bind(name).fetch_optional(p).await)
}

/// Keeps the bike file under its name, in place of an earlier one.
pub async fn upsert(tx: &mut Tx, name: &str, bike: &Bike) -> sqlx::Result<()> {
    on!(tx, t => sqlx::query(UPSERT)
        .bind(name)
        .bind(Json(bike))
        .bind(now_ms())
        .execute(&mut **t)
        .await
        .map(drop))
}
