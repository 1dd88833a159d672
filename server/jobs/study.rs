//! Several rides of one bicycle as one job.

use std::collections::BTreeSet;
use std::sync::Arc;

use riverqueue::WorkContext;
use sha2::{Digest, Sha256};
use tracing::info;
use uuid::Uuid;

use super::anew::queue_first;
use super::fault::Fault;
use super::finish::finish_study;
use super::queue::Queue;
use super::stage::{complete, queue};
use super::task::{Order, Outcome, Study};
use super::work::Stages;
use crate::files::hex;
use crate::store::job::{self, JobRow, NewJob, State};
use crate::store::{Db, Tx};

/// The jobs of a study's rides that are not deleted, each with its ride's name, numbered where several have one name.
pub async fn named(db: &Db, group: &str, rides: &[Uuid]) -> sqlx::Result<Vec<(String, JobRow)>> {
    let mut found = Vec::new();
    for (i, id) in rides.iter().enumerate() {
        if let Some(job) = job::find(db, group, *id).await? {
            found.push((i + 1, job));
        }
    }
    let names: BTreeSet<String> = found.iter().map(|(_, job)| job.ride_name.clone()).collect();
    let numbered = names.len() < found.len();
    let with_name = |(number, job): (usize, JobRow)| match numbered {
        true => (format!("{} ({number})", job.ride_name), job),
        false => (job.ride_name.clone(), job),
    };
    Ok(found.into_iter().map(with_name).collect())
}

/// The job that studies just these jobs of one bicycle, if there is one.
pub async fn known_study(tx: &mut Tx, rides: &[JobRow]) -> sqlx::Result<Option<Uuid>> {
    let Some(first) = rides.first() else {
        return Ok(None);
    };
    let ids: Vec<Uuid> = rides.iter().map(|job| job.id).collect();
    job::find_equal(tx, &first.group_name, &fingerprint(&ids)).await
}

/// What distinguishes the study of these jobs from others.
fn fingerprint(rides: &[Uuid]) -> String {
    let asked = serde_json::json!(["study", rides, env!("CARGO_PKG_VERSION")]);
    hex(&Sha256::digest(asked.to_string()))
}

/// Queues the study of these jobs of one bicycle, filed under the ride that was ridden last.
pub async fn queue_study(
    queue: &Queue,
    tx: &mut Tx,
    key: Option<Uuid>,
    rides: &[JobRow],
) -> Result<Option<Uuid>, Fault> {
    let Some(newest) = rides.iter().max_by_key(|job| (job.dated_at, job.id)) else {
        return Ok(None);
    };
    let ids: Vec<Uuid> = rides.iter().map(|job| job.id).collect();
    let job = NewJob {
        id: Uuid::now_v7(),
        group: &newest.group_name,
        key,
        ride: newest.ride_id,
        bike: &newest.bike,
        fingerprint: &fingerprint(&ids),
        request: &newest.request,
        summary: &newest.summary,
        ridden_at: Some(newest.dated_at),
        study: Some(&ids),
    };
    job::insert(tx, &job).await?;
    queue_first(queue, tx, job.id).await?;
    Ok(Some(job.id))
}

impl Stages {
    /// The only stage of a study: its rides are those of these jobs, read as these say.
    pub(super) async fn study(
        &self,
        context: &WorkContext,
        job: &JobRow,
        rides: &[Uuid],
    ) -> Result<(), Fault> {
        let (work, id) = (&self.0, job.id);
        if job.state == State::Queued {
            let mut tx = work.db.begin_lax().await?;
            job::start(&mut tx, id).await?;
            tx.commit().await?;
            work.hub.changed(id);
        }
        let study = self.rides(job, rides).await?;
        let order = Order::Study(Arc::new(study));
        let computed = work.computed(&work.compute.long, context, job, order);
        let Outcome::Studied(report) = computed.await? else {
            return Err(Fault::Mismatch);
        };
        let queue = queue(context)?;
        let publish = work.publish(context, || async {
            let mut tx = work.db.begin().await?;
            complete(context, &mut tx, id).await?;
            let whose = (id, job.group_name.as_str(), job.bike.as_str());
            let published = finish_study(&queue, &mut tx, whose, &report).await?;
            tx.commit().await?;
            Ok(published)
        });
        if publish.await? {
            info!(job = %id, rides = rides.len(), "study succeeded");
        }
        work.hub.close(id);
        Ok(())
    }

    /// The rides, without those that were deleted meanwhile.
    async fn rides(&self, job: &JobRow, rides: &[Uuid]) -> Result<Study, Fault> {
        let work = &self.0;
        let settings = job.request.options.settings.clone();
        let mut found = Vec::new();
        for (name, own) in named(&work.db, &job.group_name, rides).await? {
            let ride = work.rides.get(&own).await?;
            found.push((name, ride, own.request.0.bike));
            let all = found.iter().map(|(_, ride, _)| &**ride);
            work.budget.bears_all(all, &settings)?;
        }
        Ok(Study {
            rides: found,
            settings,
        })
    }
}
