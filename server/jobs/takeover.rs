//! Work of processes that are gone. A takeover makes a NEW River row and discards the old one: River
//! checks only that a row is running when its result comes, so a late owner of a row used again could
//! publish, while the result of a discarded row is refused.

use std::collections::BTreeMap;

use serde::Deserialize;
use uuid::Uuid;

use super::hub::Hub;
use super::queue::{DIAGNOSIS, QUICK, Queue, SWARM, Trial};
use super::stage::{Fault, give_up};
use crate::crash;
use crate::store::job::{self, Failure, Stage};
use crate::store::river::{self, Orphan};
use crate::store::{Db, Tx, trial};

/// Times that a process may go while it works on a job before the job is held to be the cause.
const MOST: i64 = 3;

/// What all kinds of work have in their arguments.
#[derive(Deserialize)]
struct Args {
    job: Uuid,
}

/// Takes over what no live worker holds, and fails jobs that the queue has nothing for any more. One
/// transaction for each job; what it was begun for is looked at again once the job is locked, since
/// another process may sweep too.
pub async fn sweep(db: &Db, queue: &Queue, hub: &Hub) -> Result<(), Fault> {
    let mut orphaned = BTreeMap::<Uuid, Vec<Orphan>>::new();
    for orphan in river::orphans(db).await? {
        let Args { job } = serde_json::from_str(&orphan.args).map_err(riverqueue::Error::from)?;
        orphaned.entry(job).or_default().push(orphan);
    }
    for (id, rows) in orphaned {
        let mut tx = db.begin().await?;
        let taken = take_over(&mut tx, queue, id, rows).await?;
        tx.commit().await?;
        if taken > 0 {
            tracing::warn!(job = %id, rows = taken, "took over the work of a process that is gone");
            metrics::counter!("veloid_job_rescues_total").increment(taken as u64);
            for name in [QUICK, SWARM, DIAGNOSIS] {
                queue.wake(name);
            }
            hub.changed(id);
        }
    }
    for id in river::strays(db).await? {
        let mut tx = db.begin().await?;
        job::lock(&mut tx, id).await?;
        if river::is_stray(&mut tx, id).await? {
            let failure = Failure::new("internal", "the queue gave the job up");
            give_up(queue, &mut tx, id, Some(&failure)).await?;
            tx.commit().await?;
            hub.changed(id);
        }
    }
    Ok(())
}

/// Gives a job's orphans to others; how many there were.
async fn take_over(
    tx: &mut Tx,
    queue: &Queue,
    id: Uuid,
    rows: Vec<Orphan>,
) -> Result<usize, Fault> {
    job::lock(tx, id).await?;
    let mut orphaned = Vec::new();
    for orphan in rows {
        if river::discard(tx, orphan.id).await? {
            orphaned.push(orphan);
        }
    }
    if orphaned.is_empty() {
        return Ok(0);
    }
    crash::point("in_takeover");
    let Some(takeovers) = job::count_takeover(tx, id).await? else {
        return Ok(orphaned.len());
    };
    if takeovers > MOST {
        let detail = format!("{takeovers} times the process that worked on it was gone");
        give_up(queue, tx, id, Some(&Failure::new("crash", detail))).await?;
        return Ok(orphaned.len());
    }
    for orphan in &orphaned {
        let (stage, row) = match orphan.kind.as_str() {
            "trial" => {
                let trials: Trial =
                    serde_json::from_str(&orphan.args).map_err(riverqueue::Error::from)?;
                let row = queue.trials_again(tx, trials).await?;
                trial::hand_over(tx, id, orphan.id, row).await?;
                continue;
            }
            "observe" => (Stage::Observe, queue.observe(tx, id).await?),
            "conclude" => (Stage::Conclude, queue.conclude(tx, id).await?),
            "diagnose" => (Stage::Diagnose, queue.diagnose(tx, id).await?),
            _ => continue,
        };
        job::enter(tx, id, stage, row).await?;
    }
    river::line_up(tx, id).await?;
    Ok(orphaned.len())
}
