use uuid::Uuid;

use super::{Tx, now_ms};

/// What an `Idempotency-Key` of a job that is not deleted stands for: the fingerprint of its request and the job that came of it.
pub type Used = (String, Uuid);

pub async fn find(tx: &mut Tx, group: &str, name: &str) -> sqlx::Result<Option<Used>> {
    const SQL: &str = "\
        SELECT idempotency_key.fingerprint, job_id FROM idempotency_key JOIN job ON job.id = job_id \
        WHERE idempotency_key.group_name = $1 AND name = $2 AND deleted_at IS NULL";
    on!(tx, t => sqlx::query_as(SQL).bind(group).bind(name).fetch_optional(&mut **t).await)
}

pub async fn insert(
    tx: &mut Tx,
    group: &str,
    name: &str,
    fingerprint: &str,
    job: Uuid,
) -> sqlx::Result<()> {
    // A job that is deleted leaves its key to the next one.
    const FREE: &str = "\
        DELETE FROM idempotency_key WHERE group_name = $1 AND name = $2 \
          AND job_id IN (SELECT id FROM job WHERE deleted_at IS NOT NULL)";
    const SQL: &str = "\
        INSERT INTO idempotency_key (group_name, name, fingerprint, job_id, created_at) \
        VALUES ($1, $2, $3, $4, $5)";
    on!(tx, t => {
        let free = sqlx::query(FREE).bind(group).bind(name);
        free.execute(&mut **t).await?;
        let insert = sqlx::query(SQL).bind(group).bind(name).bind(fingerprint);
        let insert = insert.bind(job).bind(now_ms());
        insert.execute(&mut **t).await.map(drop)
    })
}
