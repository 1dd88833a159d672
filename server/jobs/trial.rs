use std::ops::Range;
use std::sync::Arc;

use riverqueue::jiff::Timestamp;
use riverqueue::{BoxError, Job, WorkContext, WorkError, WorkOutcome, Worker};
use tracing::debug;
use uuid::Uuid;

use super::fault::Fault;
use super::queue::{QUICK, Trial};
use super::stage::{backoff, complete, queue};
use super::task::{Order, Outcome, Task};
use super::work::Stages;
use crate::store::job::{self, Stage};
use crate::store::{result, trial};

/// Second stage: the swarms of some of the seeds, at once on all threads. Who finishes the last one
/// queues the conclusion.
impl Worker<Trial> for Stages {
    type Error = BoxError;

    fn next_retry(
        &self,
        job: &Job<Trial>,
        _: &WorkError,
        _: Timestamp,
    ) -> Option<std::time::Duration> {
        backoff(&job.row)
    }

    async fn work(&self, context: WorkContext, job: Job<Trial>) -> Result<WorkOutcome, BoxError> {
        let id = job.args.job;
        let stage = self.trials(&context, id, job.args.indices());
        self.0.attempt(&context, &job.row, id, stage).await
    }
}

impl Stages {
    async fn trials(
        &self,
        context: &WorkContext,
        id: Uuid,
        indices: Range<usize>,
    ) -> Result<(), Fault> {
        let work = &self.0;
        let job = work.active(id).await?.ok_or(Fault::Stopped)?;
        let subject = work.subject(&job).await?;
        let observed = result::get(&work.db, id, result::OBSERVED).await?;
        for index in indices.clone() {
            work.hub.open(id, index);
        }
        let first = indices.start;
        let task = Task::Trials {
            observed: Arc::new(observed),
            indices,
        };
        let stage = Order::Stage(Some(subject), task);
        let computed = work.computed(&work.compute.long, context, &job, stage);
        let Outcome::Trials(found) = computed.await? else {
            return Err(Fault::Mismatch);
        };

        let queue = queue(context)?;
        let publish = work.publish(context, || async {
            let mut tx = work.db.begin_lax().await?;
            complete(context, &mut tx, id).await?;
            let stored = trial::finish(&mut tx, id, first, &found).await?;
            let last = stored > 0 && job::count_trials(&mut tx, id, stored).await?;
            if last {
                let row = queue.conclude(&mut tx, id).await?;
                job::enter(&mut tx, id, Stage::Conclude, row).await?;
            }
            tx.commit().await?;
            Ok(last)
        });
        if publish.await? {
            debug!(job = %id, "queues the conclusion: all trials are in");
            queue.wake(QUICK);
        }
        work.hub.changed(id);
        Ok(())
    }
}
