use std::sync::Arc;

use riverqueue::jiff::Timestamp;
use riverqueue::{BoxError, Job, WorkContext, WorkError, WorkOutcome, Worker};
use tracing::debug;
use uuid::Uuid;

use super::fault::Fault;
use super::finish::{finish, finished};
use super::queue::{Conclude, LONG};
use super::stage::{backoff, complete, queue};
use super::task::{Order, Outcome, Task};
use super::work::Stages;
use crate::store::job::{self, Stage};
use crate::store::{result, trial};

/// Third stage: the swarm's best, the output-error fit, the comparison. Queues the diagnosis, or
/// ends the job where none is wanted.
impl Worker<Conclude> for Stages {
    type Error = BoxError;

    fn next_retry(
        &self,
        job: &Job<Conclude>,
        _: &WorkError,
        _: Timestamp,
    ) -> Option<std::time::Duration> {
        backoff(&job.row)
    }

    async fn work(
        &self,
        context: WorkContext,
        job: Job<Conclude>,
    ) -> Result<WorkOutcome, BoxError> {
        let id = job.args.job;
        let stage = self.conclude(&context, id);
        self.0.attempt(&context, &job.row, id, stage).await
    }
}

impl Stages {
    async fn conclude(&self, context: &WorkContext, id: Uuid) -> Result<(), Fault> {
        let work = &self.0;
        let Some(job) = work.active(id).await? else {
            return Ok(());
        };
        let subject = work.subject(&job).await?;
        let observed = result::get(&work.db, id, result::OBSERVED).await?;
        let trials = trial::list(&work.db, id)
            .await?
            .into_iter()
            .filter_map(|row| row.result.map(|json| json.0))
            .collect();
        let task = Task::Conclude {
            observed: Arc::new(observed),
            trials,
        };
        let stage = Order::Stage(Some(subject), task);
        let computed = work.computed(&work.compute.quick, context, &job, stage);
        let Outcome::Concluded(conclusion, report) = computed.await? else {
            return Err(Fault::Mismatch);
        };

        let queue = queue(context)?;
        let publish = work.publish(context, || async {
            let mut tx = work.db.begin().await?;
            complete(context, &mut tx, id).await?;
            let published = match &report {
                Some(report) => {
                    finish(&queue, &mut tx, id, &job.group_name, &job.bike, report).await?
                }
                None => {
                    result::put(&mut tx, id, result::CONCLUSION, &conclusion).await?;
                    let row = queue.diagnose(&mut tx, id).await?;
                    job::enter(&mut tx, id, Stage::Diagnose, row).await?;
                    false
                }
            };
            tx.commit().await?;
            Ok(published)
        });
        let published = publish.await?;
        if let Some(report) = &report {
            finished(id, published, report);
            work.hub.close(id);
        } else {
            debug!(job = %id, "queues the diagnosis");
            queue.wake(LONG);
            work.hub.changed(id);
        }
        Ok(())
    }
}
