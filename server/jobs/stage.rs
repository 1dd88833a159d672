//! What the four stages share: how an attempt begins, how it fails, and what a failure means.

use std::sync::Arc;
use std::time::Duration;

use riverqueue::{BoxError, JobRow as RiverRow, WorkCancelled, WorkContext, WorkOutcome};
use tracing::{debug, info, warn};
use uuid::Uuid;

use super::compute::Lane;
use super::control::Control;
use super::fault::Fault;
use super::gate::{Leave, note};
use super::queue::Queue;
use super::task::{Order, Outcome, Subject};
use super::work::Work;
use crate::crash;
use crate::metrics::METRICS;
use crate::seldom::Seldom;
use crate::store::job::{self, Failure, JobRow};
use crate::store::{Tx, loss, on, trial, webhook};

/// A transaction that is not heard of for so long is started again.
const UNHEARD: Duration = Duration::from_secs(10);
/// Every waiting result is tried again each second.
static KEPT: Seldom = Seldom::new();
/// Wait before the database is tried again.
pub(super) const PAUSE: Duration = Duration::from_secs(1);

impl Work {
    /// The job, when there is still something to do for it.
    pub(super) async fn active(&self, id: Uuid) -> Result<Option<JobRow>, Fault> {
        let active = job::load(&self.db, id)
            .await?
            .filter(|job| !job.state.is_final());
        if active.is_none() {
            debug!(job = %id, "nothing left to do: the job has ended or was erased");
        }
        Ok(active)
    }

    /// What a job is about.
    pub(super) async fn subject(&self, job: &JobRow) -> Result<Arc<Subject>, Fault> {
        let ride = self.rides.get(job).await?;
        self.budget.bears(&ride, &job.request.options.settings)?;
        Ok(Arc::new(Subject {
            job: job.id,
            ride,
            bike: job.request.bike.clone(),
            settings: job.request.options.settings.clone(),
        }))
    }

    pub(super) fn control(&self, context: &WorkContext, job: &JobRow) -> Control {
        Control {
            job: Some((job.id, self.hub.clone())),
            turn: job.turn,
            token: context.cancellation_token().clone(),
            limit: self.limit,
            deadline: None,
        }
    }

    /// Computes a stage. A child process dies in the place of this one, so while a suspect computes there the death of
    /// this process is not held against it.
    pub(super) async fn computed(
        &self,
        lane: &Lane,
        context: &WorkContext,
        job: &JobRow,
        stage: Order,
    ) -> Result<Outcome, Fault> {
        let alone = self.gate.alone().filter(|_| lane.is_isolated());
        if let Some(row) = alone {
            self.survived(job.id, row).await?;
        }
        let outcome = lane.perform(self.control(context, job), stage).await;
        if let Some(row) = alone
            && let Err(error) = note(&self.db, job.id, row).await
        {
            warn!(%error, job = %job.id, "a suspect is not noted as alone");
        }
        outcome
    }

    /// Runs the transaction that publishes a result, again while the database cannot be reached: what
    /// was computed is not lost with it. Should a commit have gone through unheard, the next turn is
    /// refused as any late result is.
    pub(super) async fn publish<T, F>(
        &self,
        context: &WorkContext,
        transaction: impl Fn() -> F,
    ) -> Result<T, Fault>
    where
        F: Future<Output = Result<T, Fault>>,
    {
        crash::point("before_result");
        loop {
            let ended = tokio::time::timeout(UNHEARD, transaction()).await;
            let fault = match ended {
                Ok(Err(fault)) if fault.is_outage() => fault,
                Ok(ended) => {
                    crash::point("after_result");
                    return ended;
                }
                Err(_) => Fault::Database(sqlx::Error::PoolTimedOut),
            };
            if let Some(damage) = fault.damage() {
                self.db.condition().suspect(damage);
            }
            if KEPT.is_due() {
                warn!(%fault, "keeping results until the database is available again");
            }
            let stopped = context.cancellation_token().cancelled();
            if tokio::time::timeout(PAUSE, stopped).await.is_ok() {
                return Err(Fault::Stopped);
            }
        }
    }

    /// Turns the end of an attempt into River's terms: done, to be tried again, or given up.
    pub(super) async fn settle(
        &self,
        context: &WorkContext,
        row: &RiverRow,
        job: Uuid,
        outcome: Result<(), Fault>,
    ) -> Result<WorkOutcome, BoxError> {
        let (id, kind, attempt) = (row.id, row.kind.as_str(), row.attempt);
        let fault = match outcome {
            Ok(()) => {
                debug!(%job, row = id, kind, "finished a row");
                return Ok(WorkOutcome::Complete);
            }
            Err(Fault::Stopped) => {
                debug!(%job, row = id, kind, "stopped: cancelled, or this process ends");
                return Err(WorkCancelled.into());
            }
            Err(why @ (Fault::GivesWay | Fault::Interrupted)) => {
                debug!(%job, row = id, kind, %why, "put off a row");
                return Ok(WorkOutcome::Snooze(PAUSE));
            }
            // The attempt is not to blame.
            Err(fault) if fault.is_outage() => {
                debug!(%job, row = id, kind, why = %fault, "put off a row");
                if let Some(damage) = fault.damage() {
                    self.db.condition().suspect(damage);
                }
                // Or all that is queued would be tried at once.
                let stopped = context.cancellation_token().cancelled();
                let _ = tokio::time::timeout(PAUSE, stopped).await;
                return Ok(WorkOutcome::Snooze(PAUSE));
            }
            Err(Fault::Queue(riverqueue::Error::JobNotRunning { state })) => {
                warn!(%job, row = id, kind, %state, "late result rejected");
                METRICS.stale_completions.add(1, []);
                return Ok(WorkOutcome::Complete);
            }
            Err(fault) => fault,
        };
        let failure = match fault.lasting() {
            Some(failure) => failure,
            None if attempt < row.max_attempts => {
                info!(%job, row = id, kind, attempt, %fault, "attempt failed: it will be retried");
                return Err(fault.into());
            }
            None => Failure::new(
                "internal",
                format!("gave up after {attempt} attempts: {fault}"),
            ),
        };
        warn!(%job, row = id, kind, attempt, %fault, "job failed");
        let mut tx = self.db.begin().await?;
        complete(context, &mut tx, job).await?;
        give_up(&queue(context)?, &mut tx, job, Some(&failure)).await?;
        tx.commit().await?;
        self.hub.close(job);
        Ok(WorkOutcome::Complete)
    }
}

impl Work {
    /// One attempt at a stage, once it may begin, and what its end means to River.
    pub(super) async fn attempt(
        &self,
        context: &WorkContext,
        row: &RiverRow,
        job: Uuid,
        stage: impl Future<Output = Result<(), Fault>>,
    ) -> Result<WorkOutcome, BoxError> {
        let entered = async {
            self.db
                .condition()
                .check_database()
                .map_err(sqlx::Error::from)?;
            self.gate.enter(&self.db, job, row.id).await
        };
        let entered = context
            .cancellation_token()
            .run_until_cancelled(entered)
            .await;
        let outcome = match entered.unwrap_or(Err(Fault::Stopped)) {
            Ok(leave) => {
                let (row, kind, attempt) = (row.id, row.kind.as_str(), row.attempt);
                let alone = matches!(leave, Leave::Alone(_));
                debug!(%job, row, kind, attempt, alone, "begins a row");
                let outcome = stage.await;
                match (leave, outcome) {
                    (Leave::Alone(_), outcome) => {
                        if let Err(error) = self.survived(job, row).await {
                            warn!(%error, %job, "the sign of life was not recorded");
                        }
                        outcome.map_err(Fault::when_alone)
                    }
                    (Leave::Beside(_), Err(Fault::Killed(why))) => {
                        self.suspect(job).await?;
                        info!(%job, row, why, "killed beside others: the next attempt is made alone");
                        Err(Fault::Killed(why))
                    }
                    (Leave::Beside(_), outcome) => outcome,
                }
            }
            Err(fault) => Err(fault),
        };
        self.settle(context, row, job, outcome).await
    }

    /// Has the job's next attempt made with nothing beside it.
    async fn suspect(&self, job: Uuid) -> sqlx::Result<()> {
        let mut tx = self.db.begin_lax().await?;
        loss::suspect(&mut tx, job).await?;
        tx.commit().await
    }

    async fn survived(&self, job: Uuid, row: i64) -> sqlx::Result<()> {
        let mut tx = self.db.begin_lax().await?;
        loss::survived(&mut tx, job, row).await?;
        tx.commit().await
    }
}

/// Completes the attempt's own row. To be called first in the transaction that stores a result: it
/// locks the job and the row and fails unless the row is running, so that a result which comes after
/// a takeover is refused.
pub(super) async fn complete(context: &WorkContext, tx: &mut Tx, job: Uuid) -> Result<(), Fault> {
    job::lock(tx, job).await?;
    on!(tx, t => context.job_complete_tx(t).await)?;
    crash::point("between_completion_and_result");
    Ok(())
}

pub(super) fn queue(context: &WorkContext) -> Result<Queue, Fault> {
    context.client().cloned().map(Queue).ok_or(Fault::NoClient)
}

/// Ends a job as failed, or as cancelled without a reason, and all work that is queued for it; false
/// when it was at its end.
pub async fn give_up(
    queue: &Queue,
    tx: &mut Tx,
    id: Uuid,
    failure: Option<&Failure>,
) -> Result<bool, Fault> {
    let Some(river_id) = job::lock(tx, id).await? else {
        return Ok(false);
    };
    if !job::end(tx, id, failure).await? {
        return Ok(false);
    }
    announce(queue, tx, id).await?;
    crash::point("in_end");
    let mut rows = trial::unfinished(tx, id).await?;
    rows.extend(river_id);
    queue.cancel(tx, &rows).await?;
    if failure.is_none() {
        debug!(job = %id, rows = rows.len(), "cancels a job with the rows that are queued for it");
    }
    Ok(true)
}

/// Lets webhooks know that a job has ended.
pub(super) async fn announce(queue: &Queue, tx: &mut Tx, id: Uuid) -> Result<(), Fault> {
    if webhook::concerns(tx, id).await? {
        queue.announce(tx, id).await?;
    }
    Ok(())
}

/// Wait before another attempt: a second, then four, in place of River's attempt^4.
pub(super) fn backoff(row: &RiverRow) -> Option<Duration> {
    Some(Duration::from_secs(
        u64::from(row.attempt.unsigned_abs()).pow(2),
    ))
}
