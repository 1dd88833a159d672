//! Whose ride comes next: start-time fair queueing (Goyal, Vin & Cheng 1996, doi:10.1145/248156.248171)
//! among those who upload, so that one who sends a thousand rides holds up nobody who sends one.
//!
//! A turn is an epoch time in milliseconds, long past, by which River orders what is waiting. A new job's
//! is one more than the last of the same uploader that is not at its end, and at least the least of all.

use uuid::Uuid;

use super::{Tx, now_ms, river};

/// How far in the past turns begin: other machines' clocks may be wrong by so much, and so many rides (one
/// a millisecond) may wait, before River would hold a turn for one that has not come yet.
const PAST_MS: i64 = 3_600_000;

/// Gives a job that is queued a turn, and its waiting rows their places.
pub async fn take(tx: &mut Tx, job: Uuid) -> sqlx::Result<()> {
    const OTHERS: &str = "\
        SELECT (SELECT turn FROM job WHERE finished_at IS NULL AND id <> $1 ORDER BY turn LIMIT 1), \
               (SELECT other.turn FROM job JOIN job AS other \
                    ON other.group_name = job.group_name AND other.key_id IS NOT DISTINCT FROM job.key_id \
                WHERE job.id = $1 AND other.finished_at IS NULL AND other.id <> $1 \
                ORDER BY other.turn DESC LIMIT 1)";
    const TURN: &str = "UPDATE job SET turn = $2 WHERE id = $1";
    let (least, own): (Option<i64>, Option<i64>) =
        on!(tx, t => sqlx::query_as(OTHERS).bind(job).fetch_one(&mut **t).await)?;
    let turn = least
        .unwrap_or_else(|| now_ms() - PAST_MS)
        .max(own.map_or(i64::MIN, |own| own + 1));
    on!(tx, t => sqlx::query(TURN).bind(job).bind(turn).execute(&mut **t).await.map(drop))?;
    river::line_up(tx, job).await
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::conformance::{begun_by, on_each, queue, queued_in};
    use crate::store::Db;

    /// Rows that wait, in the order in which River takes them.
    async fn waiting(db: &Db) -> Vec<i64> {
        const SQL: &str = "\
            SELECT id FROM river_job WHERE state = 'available' ORDER BY priority, scheduled_at, id";
        on!(read db, p => sqlx::query_scalar(SQL).fetch_all(p).await).unwrap()
    }

    #[tokio::test]
    async fn turns_go_round_and_what_was_begun_goes_first() {
        on_each(async |db| {
            let queue = queue(&db);
            let mut rows = Vec::new();
            for group in ["many", "many", "many", "few", "few"] {
                rows.push(queued_in(&db, &queue, group).await.1);
            }
            let [a, b, c, d, e] = rows[..] else {
                unreachable!()
            };
            assert_eq!(waiting(&db).await, [a, d, b, e, c]);

            begun_by(&db, c, "one that stops").await;
            const BACK: &str = "UPDATE river_job SET state = 'available' WHERE id = $1";
            let mut tx = db.begin().await.unwrap();
            on!(&mut tx, t => sqlx::query(BACK).bind(c).execute(&mut **t).await.map(drop)).unwrap();
            river::begun_first(&mut tx).await.unwrap();
            tx.commit().await.unwrap();
            assert_eq!(waiting(&db).await, [c, a, d, b, e]);
        })
        .await;
    }
}
