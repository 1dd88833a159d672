//! What a stage hands to the next one, and at last the report.

use serde::Serialize;
use serde::de::DeserializeOwned;
use sqlx::types::Json;
use uuid::Uuid;

use super::{Db, Tx};

pub const OBSERVED: &str = "observed";
pub const CONCLUSION: &str = "conclusion";
pub const REPORT: &str = "report";

pub async fn put<T: Serialize + Sync>(
    tx: &mut Tx,
    job: Uuid,
    name: &str,
    document: &T,
) -> sqlx::Result<()> {
    const SQL: &str = "\
        INSERT INTO result (job_id, name, document) VALUES ($1, $2, $3) \
        ON CONFLICT (job_id, name) DO UPDATE SET document = excluded.document";
    on!(tx, t => sqlx::query(SQL)
        .bind(job)
        .bind(name)
        .bind(Json(document))
        .execute(&mut **t)
        .await
        .map(drop))
}

/// The document, or [`sqlx::Error::RowNotFound`].
pub async fn get<T>(db: &Db, job: Uuid, name: &str) -> sqlx::Result<T>
where
    T: DeserializeOwned + Send + Unpin + 'static,
{
    const SQL: &str = "SELECT document FROM result WHERE job_id = $1 AND name = $2";
    let document: Json<T> =
        on!(read db, p => sqlx::query_scalar(SQL).bind(job).bind(name).fetch_one(p).await)?;
    Ok(document.0)
}

/// The document as the text that was stored, number for number.
pub async fn text(db: &Db, job: Uuid, name: &str) -> sqlx::Result<Option<String>> {
    const SQL: &str = "SELECT CAST(document AS TEXT) FROM result WHERE job_id = $1 AND name = $2";
    on!(read db, p => sqlx::query_scalar(SQL).bind(job).bind(name).fetch_optional(p).await)
}

/// Drops what the stages handed on and the report.
pub async fn clear(tx: &mut Tx, job: Uuid) -> sqlx::Result<()> {
    const SQL: &str = "DELETE FROM result WHERE job_id = $1";
    on!(tx, t => sqlx::query(SQL).bind(job).execute(&mut **t).await.map(drop))
}
