//! Uploads that were refused, kept for a week.

use sqlx::FromRow;
use uuid::Uuid;

use super::audit::Actor;
use super::{Db, Tx, now_ms};

/// Time for which a refusal is kept (ms): long enough to find it after a week of holidays.
pub const KEPT_MS: i64 = 7 * 86_400_000;
/// Refusals that are kept of each group, the newest. A client that sends the same bad file in a loop must not fill the disk.
pub const KEPT: i64 = 1000;

#[derive(FromRow)]
pub struct RefusedRow {
    pub id: Uuid,
    pub actor: String,
    pub key_id: Option<Uuid>,
    pub file: Option<String>,
    pub bike: Option<String>,
    pub kind: String,
    pub status: i64,
    pub detail: String,
    pub refused_at: i64,
}

/// A refusal before it is stored.
pub struct NewRefusal<'a> {
    pub group: &'a str,
    pub actor: Actor,
    pub file: Option<&'a str>,
    pub bike: Option<&'a str>,
    pub kind: &'a str,
    pub status: i64,
    pub detail: &'a str,
}

pub async fn insert(tx: &mut Tx, refusal: &NewRefusal<'_>) -> sqlx::Result<()> {
    const SQL: &str = "\
        INSERT INTO refused_upload (id, group_name, actor, key_id, file, bike, kind, status, detail, refused_at) \
        VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10)";
    const SURPLUS: &str = "\
        DELETE FROM refused_upload WHERE group_name = $1 AND id <= ( \
            SELECT id FROM refused_upload WHERE group_name = $1 ORDER BY id DESC LIMIT 1 OFFSET $2)";
    on!(tx, t => {
        sqlx::query(SQL)
            .bind(Uuid::now_v7())
            .bind(refusal.group)
            .bind(refusal.actor.name())
            .bind(refusal.actor.key())
            .bind(refusal.file)
            .bind(refusal.bike)
            .bind(refusal.kind)
            .bind(refusal.status)
            .bind(refusal.detail)
            .bind(now_ms())
            .execute(&mut **t)
            .await?;
        sqlx::query(SURPLUS).bind(refusal.group).bind(KEPT).execute(&mut **t).await.map(drop)
    })
}

/// Drops refusals from before this time.
pub async fn erase(tx: &mut Tx, before_ms: i64) -> sqlx::Result<()> {
    const SQL: &str = "DELETE FROM refused_upload WHERE refused_at < $1";
    on!(tx, t => sqlx::query(SQL).bind(before_ms).execute(&mut **t).await.map(drop))
}

/// Refusals of a group within the last week, newest first.
pub async fn page(
    db: &Db,
    group: &str,
    before: Option<Uuid>,
    limit: i64,
) -> sqlx::Result<Vec<RefusedRow>> {
    const SQL: &str = "\
        SELECT id, actor, key_id, file, bike, kind, status, detail, refused_at FROM refused_upload \
        WHERE group_name = $1 AND refused_at >= $2 AND ($3 IS NULL OR id < $3) ORDER BY id DESC LIMIT $4";
    let since = now_ms() - KEPT_MS;
    on!(read db, p => sqlx::query_as(SQL)
        .bind(group)
        .bind(since)
        .bind(before)
        .bind(limit)
        .fetch_all(p)
        .await)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::conformance::on_each;
    use crate::store::key::HOME;

    fn refusal<'a>(group: &'a str, detail: &'a str) -> NewRefusal<'a> {
        NewRefusal {
            group,
            actor: Actor::Keyless,
            file: Some("ride.csv"),
            bike: None,
            kind: "urn:veloid:problem:unreadable-ride",
            status: 422,
            detail,
        }
    }

    #[tokio::test]
    async fn the_newest_are_kept_for_a_week() {
        on_each(async |db| {
            let mut tx = db.begin().await.unwrap();
            insert(&mut tx, &refusal("others", "theirs")).await.unwrap();
            for number in 0..=KEPT {
                let detail = number.to_string();
                insert(&mut tx, &refusal(HOME, &detail)).await.unwrap();
            }
            tx.commit().await.unwrap();
            let list = async |group| page(&db, group, None, 2 * KEPT).await.unwrap();
            let ours = list(HOME).await;
            assert_eq!(ours.len() as i64, KEPT);
            assert_eq!(ours[0].detail, KEPT.to_string());
            assert_eq!(ours[ours.len() - 1].detail, "1");
            assert_eq!(list("others").await.len(), 1);

            const AGE: &str = "UPDATE refused_upload SET refused_at = refused_at - $1 WHERE detail = '1'";
            let mut tx = db.begin().await.unwrap();
            on!(&mut tx, t => sqlx::query(AGE).bind(KEPT_MS + 60_000).execute(&mut **t).await.map(drop)).unwrap();
            tx.commit().await.unwrap();
            assert_eq!(list(HOME).await.len() as i64, KEPT - 1, "older ones are not listed");
            let mut tx = db.begin().await.unwrap();
            erase(&mut tx, now_ms() + 1).await.unwrap();
            tx.commit().await.unwrap();
            assert!(list("others").await.is_empty());
        })
        .await;
    }
}
