//! River's side: the kinds of work, how they are queued, cancelled and waited for.

use std::iter::repeat_n;
use std::ops::Range;
use std::time::Duration;

use riverqueue::{Client, InsertOpts, JobArgs};
use serde::{Deserialize, Serialize};
use uuid::Uuid;

use crate::store::{Tx, on};

/// Stages that take a moment: least squares must not wait behind other rides' swarms.
pub const QUICK: &str = "quick";
/// Swarms and diagnoses, which keep cores busy: one queue, so that they take turns.
pub const LONG: &str = "long";

/// What others are notified of: jobs that ended. Earlier versions queued the deliveries of it here too.
pub const NEWS: &str = "news";
/// Messages that are to be delivered, apart, since their receivers may not answer.
pub const DELIVERIES: &str = "deliveries";

/// River polls this often when nobody wakes it.
pub const POLL: Duration = Duration::from_millis(250);

const ATTEMPTS: i32 = 3;
/// Waits between attempts (s), as standard-webhooks proposes: five seconds, and a day at last.
pub const WAITS: [u64; 9] = [5, 300, 1800, 7200, 18_000, 36_000, 50_400, 72_000, 86_400];
const FIRST: i16 = 1;
const NORMAL: i16 = 2;

#[derive(Clone, Debug, Serialize, Deserialize, JobArgs)]
#[river(kind = "observe")]
pub struct Observe {
    pub job: Uuid,
}

#[derive(Clone, Debug, Serialize, Deserialize, JobArgs)]
#[river(kind = "trial")]
pub struct Trial {
    pub job: Uuid,
    /// The first of `count` trials.
    pub index: usize,
    #[serde(default = "single")]
    pub count: usize,
}

fn single() -> usize {
    1
}

impl Trial {
    pub fn indices(&self) -> Range<usize> {
        self.index..self.index + self.count
    }
}

#[derive(Clone, Debug, Serialize, Deserialize, JobArgs)]
#[river(kind = "conclude")]
pub struct Conclude {
    pub job: Uuid,
}

#[derive(Clone, Debug, Serialize, Deserialize, JobArgs)]
#[river(kind = "diagnose")]
pub struct Diagnose {
    pub job: Uuid,
}

/// Says what the end of a job means, and to whom.
#[derive(Clone, Debug, Serialize, Deserialize, JobArgs)]
#[river(kind = "announce")]
pub struct Announce {
    pub job: Uuid,
}

/// One message to one receiver.
#[derive(Clone, Debug, Serialize, Deserialize, JobArgs)]
#[river(kind = "deliver")]
pub struct Deliver {
    /// Empty in rows of earlier versions.
    #[serde(default)]
    pub group: String,
    pub webhook: Uuid,
    pub message: String,
    pub body: String,
}

fn opts(queue: &str, priority: i16) -> InsertOpts {
    InsertOpts::default()
        .with_queue(queue)
        .with_priority(priority)
        .with_max_attempts(ATTEMPTS)
}

/// A River client, seen from our side.
#[derive(Clone)]
pub struct Queue(pub Client);

impl Queue {
    pub async fn observe(&self, tx: &mut Tx, job: Uuid) -> Result<i64, riverqueue::Error> {
        self.insert(tx, Observe { job }, opts(QUICK, NORMAL)).await
    }

    /// Queues a job's trials, as many to a row as `share` says; the row of each trial. They wait for
    /// the turn of their job (`store/turn.rs`).
    pub async fn trials(
        &self,
        tx: &mut Tx,
        job: Uuid,
        total: usize,
        share: usize,
    ) -> Result<Vec<i64>, riverqueue::Error> {
        let rows = (0..total).step_by(share).map(|index| {
            let count = share.min(total - index);
            (Trial { job, index, count }, opts(LONG, NORMAL))
        });
        let inserted = on!(tx, t => self.0.insert_many(rows.collect::<Vec<_>>()).tx(t).await)?;
        let rows = inserted
            .iter()
            .flat_map(|row| repeat_n(row.job.id(), share));
        Ok(rows.take(total).collect())
    }

    /// Trials whose worker is gone go first.
    pub async fn trials_again(&self, tx: &mut Tx, trials: Trial) -> Result<i64, riverqueue::Error> {
        self.insert(tx, trials, opts(LONG, FIRST)).await
    }

    pub async fn conclude(&self, tx: &mut Tx, job: Uuid) -> Result<i64, riverqueue::Error> {
        self.insert(tx, Conclude { job }, opts(QUICK, FIRST)).await
    }

    pub async fn diagnose(&self, tx: &mut Tx, job: Uuid) -> Result<i64, riverqueue::Error> {
        self.insert(tx, Diagnose { job }, opts(LONG, NORMAL)).await
    }

    pub async fn announce(&self, tx: &mut Tx, job: Uuid) -> Result<i64, riverqueue::Error> {
        self.insert(tx, Announce { job }, opts(NEWS, NORMAL)).await
    }

    /// Tried as often as there are waits between, and once more. All have the priority of work that
    /// was begun, so that those that were put off come after new ones.
    pub async fn deliver(&self, tx: &mut Tx, delivery: Deliver) -> Result<i64, riverqueue::Error> {
        let opts = opts(DELIVERIES, FIRST).with_max_attempts(WAITS.len() as i32 + 1);
        self.insert(tx, delivery, opts).await
    }

    async fn insert<A: JobArgs>(
        &self,
        tx: &mut Tx,
        args: A,
        opts: InsertOpts,
    ) -> Result<i64, riverqueue::Error> {
        let inserted = on!(tx, t => self.0.insert(args).opts(opts).tx(t).await)?;
        Ok(inserted.id())
    }

    /// Cancels rows, wherever they are waiting or running. A row that River has cleaned away is at
    /// its end already.
    pub async fn cancel(&self, tx: &mut Tx, rows: &[i64]) -> Result<(), riverqueue::Error> {
        for row in rows {
            match on!(&mut *tx, t => self.0.jobs().cancel(*row).tx(t).await) {
                Ok(_) | Err(riverqueue::Error::NotFound(_)) => {}
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }

    /// Makes this process look for work in a queue now, after a commit: an insert in a transaction does
    /// not wake SQLite's producers. A changed configuration does, so the poll interval alternates.
    pub fn wake(&self, queue: &str) {
        let queues = self.0.local_queues();
        let Some(config) = queues.configs().remove(queue) else {
            return;
        };
        let poll = if config.fetch_poll_interval() == POLL {
            POLL + Duration::from_millis(1)
        } else {
            POLL
        };
        if let Err(error) = queues.update(queue, config.with_fetch_poll_interval(poll)) {
            tracing::warn!(queue, %error, "queue not woken; it polls");
        }
    }
}
