//! River's side: the kinds of work, how they are queued, cancelled and waited for.

use std::time::Duration;

use riverqueue::{Client, InsertOpts, JobArgs};
use serde::{Deserialize, Serialize};
use uuid::Uuid;

use crate::store::{Tx, on};

/// Stages that take a moment: least squares must not wait behind other rides' swarms.
pub const QUICK: &str = "quick";
/// Swarms, which keep a core busy for a moment each.
pub const HEAVY: &str = "heavy";
/// Diagnoses, which keep one busy for seconds: apart, since none is begun before its time.
pub const DIAGNOSIS: &str = "diagnosis";

/// River polls this often when nobody wakes it.
pub const POLL: Duration = Duration::from_millis(250);

const ATTEMPTS: i32 = 3;
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
    pub index: usize,
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

    /// Trials wait for the turn of their job (`store/turn.rs`).
    pub async fn trials(
        &self,
        tx: &mut Tx,
        job: Uuid,
        count: usize,
    ) -> Result<Vec<i64>, riverqueue::Error> {
        let rows = (0..count).map(|index| (Trial { job, index }, opts(HEAVY, NORMAL)));
        let inserted = on!(tx, t => self.0.insert_many(rows.collect::<Vec<_>>()).tx(t).await)?;
        Ok(inserted.iter().map(|row| row.job.id()).collect())
    }

    /// A trial whose worker is gone goes first.
    pub async fn trial_again(&self, tx: &mut Tx, trial: Trial) -> Result<i64, riverqueue::Error> {
        self.insert(tx, trial, opts(HEAVY, FIRST)).await
    }

    pub async fn conclude(&self, tx: &mut Tx, job: Uuid) -> Result<i64, riverqueue::Error> {
        self.insert(tx, Conclude { job }, opts(QUICK, FIRST)).await
    }

    pub async fn diagnose(&self, tx: &mut Tx, job: Uuid) -> Result<i64, riverqueue::Error> {
        self.insert(tx, Diagnose { job }, opts(DIAGNOSIS, NORMAL))
            .await
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
