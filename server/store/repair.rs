//! Jobs that an upgrade wants looked at: migrations/*/0006_repair.sql.

use uuid::Uuid;

use super::{Db, Tx};

pub async fn list(db: &Db) -> sqlx::Result<Vec<Uuid>> {
    const SQL: &str = "SELECT job_id FROM repair ORDER BY job_id";
    on!(read db, p => sqlx::query_scalar(SQL).fetch_all(p).await)
}

/// Strikes a job off the list; false when another process has done so.
pub async fn strike(tx: &mut Tx, id: Uuid) -> sqlx::Result<bool> {
    const SQL: &str = "DELETE FROM repair WHERE job_id = $1";
    let changed = on!(tx, t => sqlx::query(SQL).bind(id).execute(&mut **t).await?.rows_affected());
    Ok(changed == 1)
}
