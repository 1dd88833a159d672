use std::collections::BTreeSet;

use riverqueue::jiff::Timestamp;
use riverqueue::{BoxError, Job, WorkContext, WorkError, WorkOutcome, Worker};
use serde_json::{Value, json};
use tracing::{debug, info};
use uuid::Uuid;

use super::fault::Fault;
use super::queue::{Announce, Deliver, LONG, Queue};
use super::stage::{PAUSE, backoff, complete, queue};
use super::study::{known_study, queue_study};
use super::work::Stages;
use crate::fleet;
use crate::store::job::{self, JobRow, State};
use crate::store::parameter::{self, JobResult};
use crate::store::webhook::{self, WebhookRow};
use crate::store::{Tx, now_ms, river};
use crate::webhooks::{Event, Notification, changes};

/// What follows from a job's end: rides of its bicycle are fitted again with effects that others name, a study that is due is queued,
/// and so are webhooks' messages.
impl Worker<Announce> for Stages {
    type Error = BoxError;

    fn next_retry(
        &self,
        job: &Job<Announce>,
        _: &WorkError,
        _: Timestamp,
    ) -> Option<std::time::Duration> {
        backoff(&job.row)
    }

    async fn work(
        &self,
        context: WorkContext,
        job: Job<Announce>,
    ) -> Result<WorkOutcome, BoxError> {
        match self.announce(&context, job.args.job).await {
            Err(fault) if fault.is_outage() => Ok(WorkOutcome::Snooze(PAUSE)),
            announced => Ok(announced.map(|()| WorkOutcome::Complete)?),
        }
    }
}

impl Stages {
    async fn announce(&self, context: &WorkContext, id: Uuid) -> Result<(), Fault> {
        let db = &self.0.db;
        let Some(job) = job::load(db, id)
            .await?
            .filter(|job| job.state.is_final() && job.deleted_at.is_none())
        else {
            return Ok(());
        };
        let (group, bike) = (job.group_name.as_str(), job.bike.as_str());
        let succeeded = job.state == State::Succeeded;
        if succeeded {
            self.0.refit(group, bike).await?;
        }
        let study = match succeeded {
            true => self.0.due_study(&job).await?,
            false => None,
        };
        let to = webhook::of_group(db, group).await?;
        let (histories, effects) = match succeeded {
            true => (
                vec![fleet::history(db, group, bike).await?],
                webhook::new_effects(db, group, bike, id).await?,
            ),
            false => (Vec::new(), Vec::new()),
        };
        debug!(job = %id, receivers = to.len(), "announces the end of a job");
        let mut tx = db.begin().await?;
        complete(context, &mut tx, id).await?;
        webhook::lock_bike(&mut tx, group, bike).await?;
        let mut news = vec![(
            ended(job.state),
            of_job(&job, &parameter::results(db, &[id]).await?),
        )];
        if !effects.is_empty() {
            news.push((Event::BikeNewPhysics, of_effects(&job, &effects)));
        }
        let announced = webhook::announced(&mut tx, group, bike).await?;
        for change in histories
            .iter()
            .flat_map(|history| changes::of(history, &announced))
        {
            webhook::announce(
                &mut tx,
                group,
                bike,
                &change.axle,
                &change.name,
                &change.kind,
            )
            .await?;
            news.extend(change.event.map(|event| (event, change.data)));
        }
        for (event, data) in news {
            self.queue_deliveries(context, &mut tx, (group, &to), event, data)
                .await?;
        }
        let study = self.queue_study(context, &mut tx, study).await?;
        tx.commit().await?;
        if let Some(study) = study {
            info!(job = %id, %study, bike, "queues a study");
            queue(context)?.wake(LONG);
        }
        Ok(())
    }

    /// Queues the study of these jobs, unless there is one.
    async fn queue_study(
        &self,
        context: &WorkContext,
        tx: &mut Tx,
        ids: Option<Vec<Uuid>>,
    ) -> Result<Option<Uuid>, Fault> {
        let mut rides = Vec::new();
        for id in ids.into_iter().flatten() {
            rides.extend(
                job::load_in(tx, id)
                    .await?
                    .filter(|job| job.deleted_at.is_none()),
            );
        }
        match rides.len() < 2 || known_study(tx, &rides).await?.is_some() {
            true => Ok(None),
            false => queue_study(&queue(context)?, tx, None, &rides).await,
        }
    }

    async fn queue_deliveries(
        &self,
        context: &WorkContext,
        tx: &mut Tx,
        (group, to): (&str, &[WebhookRow]),
        event: Event,
        data: Value,
    ) -> Result<(), Fault> {
        let queue = queue(context)?;
        let body = Notification::new(event, now_ms(), data).body();
        let message = format!("msg_{}", Uuid::now_v7().simple());
        for webhook in to.iter().filter(|webhook| webhook.wants(event.name())) {
            let delivery = Deliver {
                group: group.to_owned(),
                webhook: webhook.id,
                message: message.clone(),
                body: body.clone(),
            };
            deliver(&queue, tx, delivery).await?;
        }
        Ok(())
    }
}

/// Queues a message in its group's turn; its row.
async fn deliver(queue: &Queue, tx: &mut Tx, delivery: Deliver) -> Result<i64, Fault> {
    let group = delivery.group.clone();
    let row = queue.deliver(tx, delivery).await?;
    river::line_up_delivery(tx, row, &group).await?;
    Ok(row)
}

fn ended(state: State) -> Event {
    match state {
        State::Succeeded => Event::JobSucceeded,
        State::Cancelled => Event::JobCancelled,
        _ => Event::JobFailed,
    }
}

fn of_job(job: &JobRow, results: &[JobResult]) -> Value {
    let quantity = |found: &JobResult| {
        json!({
            "axle": found.axle, "name": found.name, "value": found.value, "std_error": found.std_error, "unit": found.unit,
        })
    };
    let result: Vec<Value> = results.iter().map(quantity).collect();
    json!({
        "job": job.id, "bike": job.bike, "ride": job.ride_name, "state": job.state, "verdict": job.verdict,
        "result": result,
        "failure": job.failure.as_ref().map(|failure| &failure.0),
        "links": {"job": format!("/v1/jobs/{}", job.id), "page": format!("/jobs/{}", job.id)},
    })
}

fn of_effects(job: &JobRow, parameters: &[(String, String)]) -> Value {
    let effects: BTreeSet<(&str, &str)> = parameters
        .iter()
        .filter_map(|(axle, name)| Some((name.split_once('.')?.0, axle.as_str())))
        .collect();
    let effects: Vec<Value> = effects
        .into_iter()
        .map(|(effect, axle)| json!({"effect": effect, "axle": axle}))
        .collect();
    json!({"bike": job.bike, "job": job.id, "effects": effects})
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::conformance::{on_each, queue};
    use crate::store::on;

    #[tokio::test]
    async fn messages_of_a_group_wait_for_nobody_elses_many() {
        const WAITING: &str = "SELECT id FROM river_job WHERE state = 'available' ORDER BY priority, scheduled_at, id";
        // As those stand that were put off for less than River's round.
        const PUT_OFF: &str = "UPDATE river_job SET scheduled_at = created_at WHERE id = $1";
        on_each(async |db| {
            let queue = queue(&db);
            let mut tx = db.begin().await.unwrap();
            let mut rows = Vec::new();
            for group in ["many", "many", "many", "many", "few", "few"] {
                let delivery = Deliver {
                    group: group.to_owned(),
                    webhook: Uuid::nil(),
                    message: String::new(),
                    body: String::new(),
                };
                let row = deliver(&queue, &mut tx, delivery).await.unwrap();
                if rows.is_empty() {
                    on!(&mut tx, t => sqlx::query(PUT_OFF).bind(row).execute(&mut **t).await.map(drop)).unwrap();
                }
                rows.push(row);
            }
            tx.commit().await.unwrap();
            let waiting: Vec<i64> =
                on!(read &db, p => sqlx::query_scalar(WAITING).fetch_all(p).await).unwrap();
            let [put_off, a, b, c, d, e] = rows[..] else {
                unreachable!()
            };
            assert_eq!(waiting, [a, d, b, e, c, put_off]);
        })
        .await;
    }
}
