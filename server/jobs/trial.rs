use std::ops::Range;

use rayon::prelude::*;
use riverqueue::jiff::Timestamp;
use riverqueue::{BoxError, Job, WorkContext, WorkError, WorkOutcome, Worker};
use uuid::Uuid;
use veloid_engine::swarm::Swarm;
use veloid_engine::{Observed, Progress};

use super::fault::Fault;
use super::queue::{QUICK, Trial};
use super::stage::{backoff, complete, queue};
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
        let swarm = work.swarms.get(id.to_string(), async || {
            let job = work.active(id).await?.ok_or(Fault::Stopped)?;
            let ride = work.ride(&job).await?;
            let observed: Observed = result::get(&work.db, id, result::OBSERVED).await?;
            let request = job.request.0.clone();
            let control = work.control(context, id);
            let make = move |_: &dyn Progress| {
                Swarm::new(&ride, &request.bike, &request.options.settings, &observed)
            };
            work.compute.swarm.run(control, make).await
        });
        let swarm = swarm.await?;
        for index in indices.clone() {
            work.hub.open(id, index);
        }
        let first = indices.start;
        let found: Vec<_> = work
            .compute
            .swarm
            .run(work.control(context, id), move |progress| {
                let trials = indices.into_par_iter();
                trials.map(|index| swarm.trial(index, progress)).collect()
            })
            .await?;

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
            queue.wake(QUICK);
        }
        work.hub.changed(id);
        Ok(())
    }
}
