use uuid::Uuid;

use super::{Tx, now_ms};

/// What an `Idempotency-Key` stands for: the fingerprint of its request and the job that came of it.
pub type Used = (String, Uuid);

pub async fn find(tx: &mut Tx, group: &str, name: &str) -> sqlx::Result<Option<Used>> {
    const SQL: &str =
        "SELECT fingerprint, job_id FROM idempotency_key WHERE group_name = $1 AND name = $2";
    on!(tx, t => sqlx::query_as(SQL).bind(group).bind(name).fetch_optional(&mut **t).await)
}

pub async fn insert(
    tx: &mut Tx,
    group: &str,
    name: &str,
    fingerprint: &str,
    job: Uuid,
) -> sqlx::Result<()> {
    const SQL: &str = "\
        INSERT INTO idempotency_key (group_name, name, fingerprint, job_id, created_at) \
        VALUES ($1, $2, $3, $4, $5)";
    on!(tx, t => sqlx::query(SQL)
        .bind(group)
        .bind(name)
        .bind(fingerprint)
        .bind(job)
        .bind(now_ms())
        .execute(&mut **t)
        .await
        .map(drop))
}
