use std::time::Duration;

use riverqueue::jiff::Timestamp;
use riverqueue::{BoxError, Job, WorkContext, WorkError, WorkOutcome, Worker};
use tracing::{debug, info, warn};
use uuid::Uuid;

use super::queue::{Deliver, WAITS};
use super::work::Stages;
use crate::store::{now_ms, webhook};
use crate::webhooks::{Message, Receiver, Secret, SendError, send};

/// A message is given up after so many days: while its host is busy or silent it is put off without an attempt.
const LONGEST_DAYS: i64 = 4;
const DAY_MS: i64 = 86_400_000;

/// One attempt at a delivery.
impl Worker<Deliver> for Stages {
    type Error = BoxError;

    fn next_retry(&self, job: &Job<Deliver>, _: &WorkError, _: Timestamp) -> Option<Duration> {
        let attempt = usize::try_from(job.row.attempt)
            .unwrap_or(1)
            .clamp(1, WAITS.len());
        Some(Duration::from_secs(WAITS[attempt - 1]))
    }

    async fn work(&self, _: WorkContext, job: Job<Deliver>) -> Result<WorkOutcome, BoxError> {
        let work = &self.0;
        let (webhook, id) = (job.args.webhook, job.args.message.as_str());
        let Some(row) = webhook::load(&work.db, webhook).await? else {
            debug!(%webhook, id, "message dropped: its webhook was deleted");
            return Ok(WorkOutcome::Complete);
        };
        if now_ms() - job.row.created_at.as_millisecond() > LONGEST_DAYS * DAY_MS {
            let outcome = format!("a message was given up after {LONGEST_DAYS} days");
            self.note(row.id, &outcome).await;
            info!(%webhook, id, days = LONGEST_DAYS, "message given up: too old");
            return Ok(WorkOutcome::Discard);
        }
        let receiver = Receiver::new(&job.args.group, &row.url);
        let turn = match work.turns.take(receiver).await {
            Ok(turn) => turn,
            Err(wait) => {
                debug!(%webhook, id, ?wait, "message put off: its host is busy or silent");
                return Ok(WorkOutcome::Snooze(wait));
            }
        };
        let message = Message {
            id,
            body: &job.args.body,
            timestamp: now_ms() / 1000,
        };
        let sent = send(
            &work.targets,
            &row.url,
            &Secret::stored(row.secret),
            &message,
        )
        .await;
        turn.end(sent.as_ref().is_err_and(SendError::is_silence));
        let outcome = match &sent {
            Ok(status) => status.to_string(),
            Err(error) => format!("attempt {}: {error}", job.row.attempt),
        };
        self.note(row.id, &outcome).await;
        debug!(%webhook, id, outcome, "tried to deliver a message");
        sent?;
        Ok(WorkOutcome::Complete)
    }
}

impl Stages {
    /// Nothing depends on it.
    async fn note(&self, webhook: Uuid, outcome: &str) {
        let noted = async {
            let mut tx = self.0.db.begin_lax().await?;
            webhook::tried(&mut tx, webhook, outcome).await?;
            tx.commit().await
        };
        if let Err(error) = noted.await {
            warn!(%error, %webhook, "the outcome of a delivery was not recorded");
        }
    }
}
