use std::sync::Arc;

use riverqueue::jiff::Timestamp;
use riverqueue::{BoxError, Job, WorkContext, WorkError, WorkOutcome, Worker};
use uuid::Uuid;

use super::fault::Fault;
use super::finish::{finish, finished};
use super::queue::Diagnose;
use super::stage::{backoff, complete, queue};
use super::task::{Order, Outcome, Task};
use super::work::Stages;
use crate::crash;
use crate::store::result;

/// Last stage: what physics the model leaves out. Ends the job. The only one of a study.
impl Worker<Diagnose> for Stages {
    type Error = BoxError;

    fn next_retry(
        &self,
        job: &Job<Diagnose>,
        _: &WorkError,
        _: Timestamp,
    ) -> Option<std::time::Duration> {
        backoff(&job.row)
    }

    async fn work(
        &self,
        context: WorkContext,
        job: Job<Diagnose>,
    ) -> Result<WorkOutcome, BoxError> {
        let id = job.args.job;
        let stage = self.diagnose(&context, id);
        self.0.attempt(&context, &job.row, id, stage).await
    }
}

impl Stages {
    async fn diagnose(&self, context: &WorkContext, id: Uuid) -> Result<(), Fault> {
        let work = &self.0;
        let Some(job) = work.active(id).await? else {
            return Ok(());
        };
        crash::point("in_diagnose");
        if let Some(study) = &job.study {
            return self.study(context, &job, &study.0).await;
        }
        let subject = work.subject(&job).await?;
        let observed = result::get(&work.db, id, result::OBSERVED).await?;
        let conclusion = result::get(&work.db, id, result::CONCLUSION).await?;
        let task = Task::Diagnose {
            observed: Arc::new(observed),
            conclusion: Box::new(conclusion),
        };
        let stage = Order::Stage(Some(subject), task);
        let computed = work.computed(&work.compute.long, context, &job, stage);
        let Outcome::Diagnosed(report) = computed.await? else {
            return Err(Fault::Mismatch);
        };

        let queue = queue(context)?;
        let publish = work.publish(context, || async {
            let mut tx = work.db.begin().await?;
            complete(context, &mut tx, id).await?;
            let published =
                finish(&queue, &mut tx, id, &job.group_name, &job.bike, &report).await?;
            tx.commit().await?;
            Ok(published)
        });
        finished(id, publish.await?, &report);
        work.hub.close(id);
        Ok(())
    }
}
