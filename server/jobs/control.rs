//! What a computation hears of those who wait for it, and they of it.

use std::time::{Duration, Instant};

use tokio_util::sync::CancellationToken;
use uuid::Uuid;
use veloid_engine::Progress;

use super::fault::Fault;
use super::hub::{Heard, Hub, Iteration, Searched};
use super::permits::{Permit, Permits};
use crate::crash;

/// A computation that goes on for so long after it was to end is deaf, and is given up.
const DEAF: Duration = Duration::from_secs(1);

/// What a computation may ask while it runs, and where it reports how far it is.
#[derive(Clone)]
pub struct Control {
    /// The job that it is of, and who hears of it.
    pub job: Option<(Uuid, Hub)>,
    /// The turn of the job (`store/turn.rs`).
    pub turn: i64,
    pub token: CancellationToken,
    /// Time that the stage may take.
    pub limit: Duration,
    pub deadline: Option<Instant>,
}

impl Control {
    /// Waits for one of the permits; from then on the time counts.
    pub async fn permit(mut self, permits: &Permits) -> Result<(Self, Permit), Fault> {
        let permit = self.token.run_until_cancelled(permits.acquire(self.turn));
        let permit = permit.await.unwrap_or(Err(Fault::Stopped))?;
        self.deadline = Some(Instant::now() + self.limit);
        Ok((self, permit))
    }

    fn late(&self) -> bool {
        self.deadline
            .is_some_and(|deadline| Instant::now() >= deadline)
    }

    /// Why a computation ends before its time.
    pub fn fault(&self) -> Fault {
        if self.late() {
            Fault::Deadline(self.limit)
        } else {
            Fault::Stopped
        }
    }

    /// Returns when the computation is to end.
    pub async fn over(&self) {
        let _ = tokio::time::timeout(self.limit, self.token.cancelled()).await;
    }

    /// Returns when the computation should have ended for some time.
    pub async fn unheard(&self) {
        self.over().await;
        tokio::time::sleep(DEAF).await;
    }

    /// It is computed from now on.
    pub fn begins(&self) {
        if self.job.is_some() {
            crash::point("computing");
        }
    }

    pub fn hear(&self, heard: Heard) {
        let Some((job, hub)) = &self.job else {
            return;
        };
        match heard {
            Heard::Iteration(iteration) => {
                crash::point("in_trial");
                hub.iteration(*job, iteration);
            }
            Heard::Searched(searched) => hub.searched(*job, searched),
        }
    }
}

impl Progress for Control {
    fn iteration(&self, trial: usize, iteration: usize, best_cost: f64) {
        self.hear(Heard::Iteration(Iteration {
            trial,
            iteration,
            best_cost,
        }));
    }

    fn searched(&self, steps: u64, budget: u64) {
        self.hear(Heard::Searched(Searched { steps, budget }));
    }

    fn cancelled(&self) -> bool {
        self.token.is_cancelled() || self.late()
    }
}
