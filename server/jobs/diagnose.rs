use riverqueue::jiff::Timestamp;
use riverqueue::{BoxError, Job, WorkContext, WorkError, WorkOutcome, Worker};
use uuid::Uuid;
use veloid_engine::{Conclusion, Observed};

use super::fault::Fault;
use super::finish::finish;
use super::queue::Diagnose;
use super::stage::{backoff, complete, queue};
use super::work::Stages;
use crate::crash;
use crate::store::result;

/// Last stage: what physics the model leaves out. Ends the job.
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
        let ride = work.ride(&job).await?;
        let observed: Observed = result::get(&work.db, id, result::OBSERVED).await?;
        let conclusion: Conclusion = result::get(&work.db, id, result::CONCLUSION).await?;
        let request = job.request.0;
        let report = work
            .compute
            .diagnosis
            .run(work.control(context, id), move |progress| {
                let (bike, settings) = (&request.bike, &request.options.settings);
                let diagnosis =
                    veloid_engine::diagnose(&ride, bike, settings, &conclusion, progress)?;
                veloid_engine::assemble(
                    &ride,
                    bike,
                    settings,
                    observed,
                    conclusion,
                    Some(diagnosis),
                )
            })
            .await?;

        let queue = queue(context)?;
        work.publish(context, || async {
            let mut tx = work.db.begin().await?;
            complete(context, &mut tx, id).await?;
            finish(&queue, &mut tx, id, &job.group_name, &job.bike, &report).await?;
            Ok(tx.commit().await?)
        })
        .await?;
        work.hub.close(id);
        Ok(())
    }
}
