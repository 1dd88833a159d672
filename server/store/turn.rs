//! Whose ride comes next: start-time fair queueing (Goyal, Vin & Cheng 1996, doi:10.1145/248156.248171)
//! among those who upload, so that one who sends a thousand rides holds up nobody who sends one.
//!
//! A turn is a count that River, which orders what is waiting by time, gets as a time in milliseconds since 1970, so that
//! no clock has a part in it. A new job's turn is one more than the last of the same uploader that is not at its end, and
//! at least the least of all.

use uuid::Uuid;

use super::{Tx, river};

/// Turns of this size were taken from the clock, by versions before schema 15 (ms since 1970, here 1973): to count so far
/// one uploader would have to have as many jobs that are not at their end.
const FROM_CLOCK: i64 = 100_000_000_000;

/// Gives a job a turn, by which the rows of its stages line up.
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
    let turn = least.unwrap_or(0).max(own.map_or(i64::MIN, |own| own + 1));
    on!(tx, t => sqlx::query(TURN).bind(job).bind(turn).execute(&mut **t).await.map(drop))
}

/// Counts turns that earlier versions took from the clock from 0, in their order.
pub async fn count_from_0(tx: &mut Tx) -> sqlx::Result<()> {
    const LEAST: &str = "SELECT MIN(turn) FROM job WHERE finished_at IS NULL";
    const SQL: &str = "UPDATE job SET turn = turn - $1 WHERE finished_at IS NULL RETURNING id";
    let least: Option<i64> = on!(tx, t => sqlx::query_scalar(LEAST).fetch_one(&mut **t).await)?;
    let Some(least) = least.filter(|least| *least >= FROM_CLOCK) else {
        return Ok(());
    };
    let jobs: Vec<Uuid> =
        on!(tx, t => sqlx::query_scalar(SQL).bind(least).fetch_all(&mut **t).await)?;
    for job in jobs {
        river::line_up(tx, job).await?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::conformance::{begun_by, on_each, queue, queued_in};
    use crate::jobs::Queue;
    use crate::store::job::{self, Stage};
    use crate::store::{Db, trial};

    /// Rows that wait, in the order in which River takes them.
    async fn waiting(db: &Db) -> Vec<i64> {
        const SQL: &str = "\
            SELECT id FROM river_job WHERE state = 'available' ORDER BY priority, scheduled_at, id";
        on!(read db, p => sqlx::query_scalar(SQL).fetch_all(p).await).unwrap()
    }

    /// Moves a job to a stage as the stage before it does; the new row.
    async fn enter(db: &Db, queue: &Queue, job: Uuid, stage: Stage, done: i64) -> i64 {
        let mut tx = db.begin().await.unwrap();
        queue.cancel(&mut tx, &[done]).await.unwrap();
        let row = match stage {
            Stage::Observe => queue.observe(&mut tx, job).await.unwrap(),
            Stage::Trial => {
                job::start(&mut tx, job).await.unwrap();
                job::observed(&mut tx, job, &Default::default())
                    .await
                    .unwrap();
                let rows = queue.trials(&mut tx, job, 1, 1).await.unwrap();
                trial::insert(&mut tx, job, 1, &rows).await.unwrap();
                rows[0]
            }
            Stage::Conclude => queue.conclude(&mut tx, job).await.unwrap(),
            Stage::Diagnose => queue.diagnose(&mut tx, job).await.unwrap(),
        };
        if !matches!(stage, Stage::Trial) {
            job::enter(&mut tx, job, stage, row).await.unwrap();
        }
        tx.commit().await.unwrap();
        row
    }

    #[tokio::test]
    async fn every_stage_takes_turns() {
        on_each(async |db| {
            let queue = queue(&db);
            let mut jobs = Vec::new();
            for group in ["many", "many", "many", "few"] {
                jobs.push(queued_in(&db, &queue, group).await);
            }
            for stage in [
                Stage::Observe,
                Stage::Trial,
                Stage::Conclude,
                Stage::Diagnose,
            ] {
                for (job, row) in &mut jobs {
                    *row = enter(&db, &queue, *job, stage, *row).await;
                }
                let [a, b, c, d] = [0, 1, 2, 3].map(|index: usize| jobs[index].1);
                assert_eq!(waiting(&db).await, [a, d, b, c], "{stage:?}");
            }
        })
        .await;
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

            // As an earlier version left them, by a clock that was set back since.
            const AHEAD: &str = "UPDATE job SET turn = turn + $1";
            let ahead = crate::store::now_ms() + 7_200_000;
            let mut tx = db.begin().await.unwrap();
            on!(&mut tx, t => sqlx::query(AHEAD).bind(ahead).execute(&mut **t).await.map(drop))
                .unwrap();
            count_from_0(&mut tx).await.unwrap();
            tx.commit().await.unwrap();
            assert_eq!(waiting(&db).await, [a, d, b, e, c]);
            const TURNS: &str = "SELECT turn FROM job ORDER BY id";
            let turns: Vec<i64> =
                on!(read &db, p => sqlx::query_scalar(TURNS).fetch_all(p).await).unwrap();
            assert_eq!(turns, [0, 1, 2, 0, 1]);

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
