//! A working process: River's client with our workers, its heartbeat, and its orderly end.

use std::sync::Arc;
use std::time::{Duration, Instant};

use riverqueue::{MaintenanceConfig, QueueConfig, Retention, RunHandle, Workers};
use tokio::task::JoinHandle;
use tokio_util::sync::CancellationToken;
use uuid::Uuid;

use super::compute::QUICK_THREADS;
use super::fault::Fault;
use super::hub::Hub;
use super::queue::{
    Announce, Conclude, DELIVERIES, Deliver, Diagnose, LONG, NEWS, Observe, POLL, QUICK, Queue,
    Trial,
};
use super::repair::repair;
use super::takeover::sweep;
use super::work::{Stages, Work};
use crate::crash;
use crate::store::{Db, river, turn, worker};
use crate::watch::BEAT;
use crate::webhooks::{self, CONNECTIONS};

/// A worker that has not beaten for so long is gone; four beats.
const LEASE: Duration = Duration::from_secs(8);
/// A database that does not answer a heartbeat for so long is not there.
const PATIENCE: Duration = Duration::from_secs(4);
/// Running stages get this long after a stop is asked for; then they hand their work back.
const SOFT_STOP: Duration = Duration::from_secs(8);
/// River steps in so much later than our own deadline, which ends the loop from inside.
const GRACE: Duration = Duration::from_secs(60);

/// Swarms and diagnoses that the only process claims before it has a thread for them, several at once, because
/// SQLite has one writer and claiming one takes it as long as a short swarm. Where others work too, they may
/// have a thread now. A newcomer needs one of these slots and then goes first (permits.rs): it waits for two
/// stages to end.
const AHEAD: usize = 8;
/// Ends of jobs that are announced at a time.
const ANNOUNCED: usize = 4;
/// Messages at a time that wait for a moment for their turn, or are put off.
const WAITING: usize = 8;
/// Wait between two claims, so that what has ended meanwhile is replaced at once.
const GATHER: Duration = Duration::from_millis(10);

/// A process at work.
pub struct Running {
    pub queue: Queue,
    db: Db,
    river: RunHandle,
    heart: JoinHandle<()>,
    stop: CancellationToken,
}

/// Begins to work. On SQLite the caller holds the data folder's work lock: whatever is `running`
/// belongs to a process that is gone.
pub async fn start(work: Arc<Work>) -> Result<Running, Fault> {
    let db = work.db.clone();
    let hub = work.hub.clone();
    let threads = work.compute.long.threads;
    let id = format!("veloid-{}", Uuid::now_v7().simple());
    let queue = Queue(client(&id, work)?);

    let mut tx = db.begin().await?;
    if db.is_sqlite() {
        worker::expire(&mut tx, 0).await?;
        river::forget_leader(&mut tx).await?;
    }
    // Before the first row is fetched, or others would take it over at once.
    let slots = (threads + QUICK_THREADS) as i64;
    worker::beat(&mut tx, &id, slots).await?;
    turn::count_from_0(&mut tx).await?;
    river::join_queues(&mut tx).await?;
    river::hasten(&mut tx).await?;
    tx.commit().await?;
    tracing::debug!(worker = id, slots, "joined the workers");
    sweep(&db, &queue, &hub).await?;
    repair(&db, &queue).await?;

    let river = queue.0.start()?;
    let stop = CancellationToken::new();
    let heart = tokio::spawn(live(db.clone(), queue.clone(), hub, slots, stop.clone()));
    Ok(Running {
        queue,
        db,
        river,
        heart,
        stop,
    })
}

impl Running {
    /// Lets running stages finish for a while, hands the others back, and leaves.
    pub async fn stop(mut self) -> Result<(), Fault> {
        let stopped = self.river.stop().await;
        crash::point("in_stop");
        self.stop.cancel();
        self.heart.await?;
        if self.db.condition().check_database().is_err() {
            return Ok(stopped?);
        }
        let mut tx = self.db.begin().await?;
        worker::leave(&mut tx, self.queue.0.id()).await?;
        tx.commit().await?;
        Ok(stopped?)
    }
}

fn client(id: &str, work: Arc<Work>) -> Result<riverqueue::Client, Fault> {
    // Others may have to end before an attempt begins.
    let timeout = work.limit * 2 + GRACE;
    let threads = work.compute.long.threads;
    let (builder, only_process) = (work.db.river(), work.db.is_sqlite());
    let stages = Stages(work);
    let mut workers = Workers::new();
    workers.add::<Observe, _>(stages.clone())?;
    workers.add::<Trial, _>(stages.clone())?;
    workers.add::<Conclude, _>(stages.clone())?;
    workers.add::<Diagnose, _>(stages.clone())?;
    workers.add::<Announce, _>(stages.clone())?;
    workers.add::<Deliver, _>(stages)?;
    let slots = |count| QueueConfig::new(count).with_fetch_poll_interval(POLL);
    let long = match only_process {
        true => slots(threads + AHEAD).with_fetch_cooldown(GATHER),
        false => slots(threads),
    };
    let maintenance = MaintenanceConfig::default()
        .with_elect_interval(Duration::from_secs(1))
        .with_scheduler_interval(Duration::from_secs(1))
        .with_completed_job_retention(Retention::DeleteAfter(Duration::from_secs(3600)))
        .with_rescue_after(timeout * 2);
    // Without the feature, messages wait for a program that has it.
    let builder = match webhooks::built() {
        Ok(()) => builder.queue(DELIVERIES, slots(CONNECTIONS + WAITING)),
        Err(_) => builder,
    };
    Ok(builder
        .id(id)
        .workers(workers)
        .queue(QUICK, slots(QUICK_THREADS))
        .queue(LONG, long)
        .queue(NEWS, slots(ANNOUNCED))
        .fetch_cooldown(Duration::from_millis(1))
        .job_timeout(timeout)
        .soft_stop_timeout(SOFT_STOP)
        .maintenance(maintenance)
        .build()?)
}

/// Beats, and on PostgreSQL looks for the work of those who no longer do.
async fn live(db: Db, queue: Queue, hub: Hub, slots: i64, stop: CancellationToken) {
    let mut ticks = tokio::time::interval(BEAT);
    ticks.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Delay);
    // Since when no beat has failed and nobody has set the clock.
    let mut steady: Option<Instant> = None;
    let mut clock = Clock::default();
    while stop.run_until_cancelled(ticks.tick()).await.is_some() {
        // The watch has said why.
        if db.condition().check_database().is_err() {
            steady = None;
            continue;
        }
        // Who could not reach the database does not know whether others could.
        let judges = !db.is_sqlite() && steady.is_some_and(|since| since.elapsed() >= LEASE);
        match in_time(beat(&db, queue.0.id(), slots, judges)).await {
            Ok(now_ms) => {
                if clock.was_set(now_ms) {
                    tracing::warn!("the database's clock was changed");
                    steady = None;
                    if let Err(error) = in_time(hasten(&db)).await {
                        tracing::error!(%error, "rows may wait for as long as the clock was changed by");
                    }
                }
                steady = steady.or_else(|| Some(Instant::now()));
            }
            Err(error) => {
                tracing::error!(%error, "heartbeat failed");
                steady = None;
                continue;
            }
        }
        if let Err(error) = in_time(sweep(&db, &queue, &hub)).await {
            tracing::error!(%error, "the search for lost work failed");
        }
    }
}

/// The database's clock beside this process's own, which nobody sets.
#[derive(Default)]
struct Clock {
    last: Option<(i64, Instant)>,
}

impl Clock {
    /// Whether the clock was set since this was asked last. Other workers' beats mean nothing then until
    /// they have beaten again.
    fn was_set(&mut self, now_ms: i64) -> bool {
        let now = Instant::now();
        let Some((then_ms, then)) = self.last.replace((now_ms, now)) else {
            return false;
        };
        let own_ms = now.duration_since(then).as_millis() as i64;
        (now_ms - then_ms - own_ms).abs() > LEASE.as_millis() as i64 / 2
    }
}

async fn hasten(db: &Db) -> Result<(), Fault> {
    let mut tx = db.begin_lax().await?;
    river::hasten(&mut tx).await?;
    Ok(tx.commit().await?)
}

/// Ends what waits for a database that does not answer.
async fn in_time<T>(work: impl Future<Output = Result<T, Fault>>) -> Result<T, Fault> {
    let ended = tokio::time::timeout(PATIENCE, work).await;
    ended.unwrap_or(Err(Fault::Database(sqlx::Error::PoolTimedOut)))
}

/// The time of a heartbeat by the database's clock. On SQLite nobody else works, and a process that was
/// stopped for a while is not gone.
async fn beat(db: &Db, id: &str, slots: i64, judges: bool) -> Result<i64, Fault> {
    let mut tx = db.begin_lax().await?;
    let now_ms = worker::beat(&mut tx, id, slots).await?;
    river::begun_first(&mut tx).await?;
    river::join_queues(&mut tx).await?;
    let gone = match judges {
        true => worker::expire(&mut tx, LEASE.as_millis() as i64).await?,
        false => 0,
    };
    tx.commit().await?;
    if gone > 0 {
        tracing::info!(workers = gone, lease = ?LEASE, "others do not beat any more: their work may be taken over");
    }
    Ok(now_ms)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clock_that_goes_on_was_not_set() {
        let mut clock = Clock::default();
        assert!(!clock.was_set(0), "there is nothing to compare with");
        assert!(!clock.was_set(20), "20 ms went by");
        assert!(clock.was_set(3_600_000));
        assert!(!clock.was_set(3_600_000));
        assert!(clock.was_set(0));
    }
}
