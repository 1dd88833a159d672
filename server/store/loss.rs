//! Processes that died while they had work of a job, and whether the job is to blame.
//!
//! `lost` counts them since the job last made progress. So many things end a process that the first
//! [`TOGETHER`] prove nothing: the job becomes a suspect, and from then on has a process to itself.
//! Then only deaths count in which its River row, noted as `alone`, had been let begin.

use sqlx::FromRow;
use uuid::Uuid;

use super::{Db, Tx};

/// Deaths beside others that make a job a suspect.
const TOGETHER: i64 = 2;
/// Deaths alone, one after the other, that show it to be the cause. One could be chance: somebody may
/// end a process at any time.
const ALONE: i64 = 3;

/// Where a job stands.
#[derive(Clone, Copy, Default, FromRow)]
pub struct Standing {
    lost: i64,
    /// Another unfinished job was alone when its process died.
    another: bool,
}

impl Standing {
    /// Whether the job has to have a process to itself.
    pub fn is_suspect(self) -> bool {
        self.lost >= TOGETHER
    }

    /// Whether another job has to go first: one that was alone when its process died, so that it does not
    /// meet whoever ends processes at the same point each time.
    pub fn gives_way(self) -> bool {
        self.another && self.lost <= TOGETHER
    }
}

pub async fn standing(db: &Db, job: Uuid) -> sqlx::Result<Standing> {
    // More than TOGETHER, spelt out for the sake of the index.
    const SQL: &str = "\
        SELECT lost, EXISTS ( \
            SELECT 1 FROM job WHERE lost > 2 AND finished_at IS NULL AND id <> $1) AS another \
        FROM job WHERE id = $1";
    let found = on!(read db, p => sqlx::query_as(SQL).bind(job).fetch_optional(p).await)?;
    Ok(found.unwrap_or_default())
}

/// Makes a job a suspect, as if processes had died beside others with its work.
pub async fn suspect(tx: &mut Tx, job: Uuid) -> sqlx::Result<()> {
    const SQL: &str = "UPDATE job SET lost = $2 WHERE id = $1 AND lost < $2";
    on!(tx, t => sqlx::query(SQL).bind(job).bind(TOGETHER).execute(&mut **t).await.map(drop))
}

/// Notes that a River row of a suspect has this process to itself; false while another row of the job
/// has another process.
pub async fn alone(tx: &mut Tx, job: Uuid, row: i64) -> sqlx::Result<bool> {
    const SQL: &str = "\
        UPDATE job SET alone = $2 \
        WHERE id = $1 AND NOT EXISTS ( \
            SELECT 1 FROM river_job \
            WHERE river_job.id = job.alone AND river_job.id <> $2 AND river_job.state = 'running')";
    let changed = on!(tx, t => sqlx::query(SQL)
        .bind(job)
        .bind(row)
        .execute(&mut **t)
        .await?
        .rows_affected());
    Ok(changed == 1)
}

/// Takes the note back: the attempt came to an end, and the process lives.
pub async fn survived(tx: &mut Tx, job: Uuid, row: i64) -> sqlx::Result<()> {
    const SQL: &str = "UPDATE job SET alone = NULL WHERE id = $1 AND alone = $2";
    on!(tx, t => sqlx::query(SQL).bind(job).bind(row).execute(&mut **t).await.map(drop))
}

/// What the death of a process means for a job whose rows it had.
#[derive(Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The job is at its end already.
    Ended,
    /// Others work on.
    Goes,
    /// It is the cause, after so many deaths.
    Guilty(i64),
}

/// Counts the death of a process that had these rows of a job.
pub async fn count(tx: &mut Tx, job: Uuid, rows: &[i64]) -> sqlx::Result<Verdict> {
    const FIND: &str = "\
        SELECT lost, alone FROM job WHERE id = $1 AND state IN ('queued', 'running')";
    const COUNT: &str = "\
        UPDATE job SET takeovers = takeovers + 1, lost = $2, alone = NULL WHERE id = $1";
    let found: Option<(i64, Option<i64>)> =
        on!(&mut *tx, t => sqlx::query_as(FIND).bind(job).fetch_optional(&mut **t).await)?;
    let Some((lost, alone)) = found else {
        return Ok(Verdict::Ended);
    };
    let was_alone = alone.is_some_and(|row| rows.contains(&row));
    let lost = lost + i64::from(lost < TOGETHER || was_alone);
    on!(tx, t => sqlx::query(COUNT).bind(job).bind(lost).execute(&mut **t).await.map(drop))?;
    Ok(match lost >= TOGETHER + ALONE {
        true => Verdict::Guilty(lost),
        false => Verdict::Goes,
    })
}
