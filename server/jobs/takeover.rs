//! Work of processes that are gone. A takeover makes a NEW River row and discards the old one: River
//! checks only that a row is running when its result comes, so a late owner of a row used again could
//! publish, while the result of a discarded row is refused.

use std::collections::BTreeMap;

use serde::Deserialize;
use tracing::{debug, error, warn};
use uuid::Uuid;

use super::fault::Fault;
use super::hub::Hub;
use super::queue::{LONG, QUICK, Queue, Trial};
use super::stage::give_up;
use crate::crash;
use crate::metrics::METRICS;
use crate::store::job::{self, Failure};
use crate::store::loss::{self, Verdict};
use crate::store::river::{self, Orphan};
use crate::store::{Db, Tx, trial};

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
        if let Some((rows, verdict)) = taken {
            report(id, rows, &verdict);
            METRICS.rescues.add(rows as u64, []);
            for name in [QUICK, LONG] {
                queue.wake(name);
            }
            hub.changed(id);
        }
    }
    let mut tx = db.begin_lax().await?;
    river::notify_again(&mut tx).await?;
    tx.commit().await?;
    for id in river::strays(db).await? {
        let mut tx = db.begin().await?;
        job::lock(&mut tx, id).await?;
        if river::is_stray(&mut tx, id).await? {
            let failure = Failure::new("internal", "the queue gave the job up");
            give_up(queue, &mut tx, id, Some(&failure)).await?;
            tx.commit().await?;
            warn!(job = %id, "job failed: the queue has no row for it any more");
            hub.changed(id);
        }
    }
    Ok(())
}

fn report(job: Uuid, rows: usize, verdict: &Verdict) {
    match verdict {
        Verdict::Goes => warn!(%job, rows, "took over the work of a dead process"),
        Verdict::Ended => {
            debug!(%job, rows, "dropped the work of a dead process: the job has ended")
        }
        Verdict::Guilty(deaths) => {
            error!(%job, rows, deaths, "job failed: it kills the processes that work on it");
        }
    }
}

/// Gives a job's orphans to others; how many there were, if any, and what their death means.
async fn take_over(
    tx: &mut Tx,
    queue: &Queue,
    id: Uuid,
    rows: Vec<Orphan>,
) -> Result<Option<(usize, Verdict)>, Fault> {
    job::lock(tx, id).await?;
    let mut orphaned = Vec::new();
    for orphan in rows {
        if river::discard(tx, orphan.id).await? {
            orphaned.push(orphan);
        }
    }
    if orphaned.is_empty() {
        return Ok(None);
    }
    crash::point("in_takeover");
    let rows: Vec<i64> = orphaned.iter().map(|orphan| orphan.id).collect();
    let verdict = loss::count(tx, id, &rows).await?;
    match verdict {
        Verdict::Goes => requeue(tx, queue, id, &orphaned).await?,
        Verdict::Ended => {}
        Verdict::Guilty(deaths) => {
            let detail = format!(
                "{deaths} processes died while working on it, the last of them with no other work"
            );
            give_up(queue, tx, id, Some(&Failure::new("crash", detail))).await?;
        }
    }
    Ok(Some((orphaned.len(), verdict)))
}

/// A new row in the place of each of a job's orphans.
async fn requeue(tx: &mut Tx, queue: &Queue, id: Uuid, orphaned: &[Orphan]) -> Result<(), Fault> {
    for orphan in orphaned {
        let row = match orphan.kind.as_str() {
            "trial" => {
                let trials: Trial =
                    serde_json::from_str(&orphan.args).map_err(riverqueue::Error::from)?;
                let row = queue.trials_again(tx, trials).await?;
                trial::hand_over(tx, id, orphan.id, row).await?;
                continue;
            }
            "observe" => queue.observe(tx, id).await?,
            "conclude" => queue.conclude(tx, id).await?,
            "diagnose" => queue.diagnose(tx, id).await?,
            _ => continue,
        };
        job::hand_over(tx, id, row).await?;
    }
    river::line_up(tx, id).await?;
    Ok(())
}
