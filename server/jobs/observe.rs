use riverqueue::jiff::Timestamp;
use riverqueue::{BoxError, Job, WorkContext, WorkError, WorkOutcome, Worker};
use tracing::debug;
use uuid::Uuid;
use veloid_engine::Settings;
use veloid_engine::ride::Ride;

use super::fault::Fault;
use super::queue::{LONG, Observe};
use super::stage::{backoff, complete, queue};
use super::task::{Order, Outcome, Task};
use super::work::Stages;
use crate::crash;
use crate::store::{job, result, trial};

/// Particles times samples that one row of River is worth at least: about 0.1 s of a core where each is
/// simulated, so that the queue's part (a few milliseconds) is small beside it.
const PIECE: usize = 200_000_000;

/// Trials that one row of River holds.
fn share(ride: &Ride, settings: &Settings) -> usize {
    let samples = ride.samples * ride.axles.iter().count();
    let trial = settings.particles * settings.iterations * samples;
    (PIECE / trial.max(1)).clamp(1, settings.trials)
}

/// First stage: observer and least squares. Queues the trials.
impl Worker<Observe> for Stages {
    type Error = BoxError;

    fn next_retry(
        &self,
        job: &Job<Observe>,
        _: &WorkError,
        _: Timestamp,
    ) -> Option<std::time::Duration> {
        backoff(&job.row)
    }

    async fn work(&self, context: WorkContext, job: Job<Observe>) -> Result<WorkOutcome, BoxError> {
        let id = job.args.job;
        let stage = self.observe(&context, id);
        self.0.attempt(&context, &job.row, id, stage).await
    }
}

impl Stages {
    async fn observe(&self, context: &WorkContext, id: Uuid) -> Result<(), Fault> {
        let work = &self.0;
        let Some(job) = work.active(id).await? else {
            return Ok(());
        };
        let mut tx = work.db.begin_lax().await?;
        job::start(&mut tx, id).await?;
        tx.commit().await?;
        crash::point("in_observe");
        work.hub.changed(id);

        let subject = work.subject(&job).await?;
        let settings = subject.settings.clone();
        let share = share(&subject.ride, &settings);
        let stage = Order::Stage(Some(subject), Task::Observe);
        let computed = work.computed(&work.compute.quick, context, &job, stage);
        let Outcome::Observed(observed) = computed.await? else {
            return Err(Fault::Mismatch);
        };

        let queue = queue(context)?;
        work.publish(context, || async {
            let mut tx = work.db.begin_lax().await?;
            complete(context, &mut tx, id).await?;
            if job::observed(&mut tx, id, &observed.least_squares).await? {
                result::put(&mut tx, id, result::OBSERVED, &observed).await?;
                let rows = queue.trials(&mut tx, id, settings.trials, share).await?;
                trial::insert(&mut tx, id, settings.seed, &rows).await?;
            }
            Ok(tx.commit().await?)
        })
        .await?;
        debug!(job = %id, trials = settings.trials, share, "queues the trials");
        queue.wake(LONG);
        work.hub.changed(id);
        Ok(())
    }
}
