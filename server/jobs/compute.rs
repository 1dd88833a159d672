//! Computing, away from the async threads: a rayon pool for the quick stages, one for the swarms and one for
//! the diagnoses, each with as many permits as threads. A thread that waits for its share of one piece of
//! work may begin another of its pool, so that no swarm can come to wait for a diagnosis.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};
use tokio::sync::{Semaphore, oneshot};
use tokio_util::sync::CancellationToken;
use uuid::Uuid;
use veloid_engine::{EngineError, Progress};

use super::fault::Fault;
use super::hub::{Hub, Iteration};
use crate::crash;

/// Threads for the quick stages; they take turns with the others by the system's scheduler.
pub const QUICK_THREADS: usize = 4;

/// What the threads of swarms and of diagnoses concede (`nice`), so that answers and quick stages need not
/// wait for them however many cores compute.
const SWARM_NICE: i32 = 5;
const DIAGNOSIS_NICE: i32 = 10;

/// The pools of one process.
pub struct Compute {
    pub quick: Lane,
    pub swarm: Lane,
    pub diagnosis: Lane,
}

impl Compute {
    /// `threads` each for swarms and diagnoses.
    pub fn new(threads: usize) -> Result<Self, ThreadPoolBuildError> {
        Ok(Self {
            quick: Lane::new("quick", QUICK_THREADS, 0)?,
            swarm: Lane::new("swarm", threads, SWARM_NICE)?,
            diagnosis: Lane::new("diagnosis", threads, DIAGNOSIS_NICE)?,
        })
    }
}

/// A computation that goes on for so long after it was to end is deaf, and is given up.
const DEAF: Duration = Duration::from_secs(1);

/// One pool and its permits.
pub struct Lane {
    name: &'static str,
    pool: Mutex<ThreadPool>,
    permits: Arc<Semaphore>,
    pub threads: usize,
    nice: i32,
}

impl Lane {
    fn new(name: &'static str, threads: usize, nice: i32) -> Result<Self, ThreadPoolBuildError> {
        Ok(Self {
            name,
            pool: Mutex::new(pool(name, threads, nice)?),
            permits: Arc::new(Semaphore::new(threads)),
            threads,
            nice,
        })
    }

    /// Runs `work` on the pool. The permit travels with it: should River give the async side up, the
    /// thread stays counted until it really ends. Deaf work is left to itself, and the lane gets new
    /// threads.
    pub async fn run<T, F>(&self, control: Control, work: F) -> Result<T, Fault>
    where
        T: Send + 'static,
        F: FnOnce(&dyn Progress) -> Result<T, EngineError> + Send + 'static,
    {
        let permit = Arc::clone(&self.permits).acquire_owned();
        let permit = (control.token.run_until_cancelled(permit).await)
            .and_then(Result::ok)
            .ok_or(Fault::Stopped)?;
        let (send, receive) = oneshot::channel();
        let control = control.started();
        let reached = control.clone();
        let permit = Arc::new(Mutex::new(Some(permit)));
        let held = Arc::clone(&permit);
        lock(&self.pool).spawn(move || {
            let outcome = catch_unwind(AssertUnwindSafe(|| {
                crash::point("computing");
                work(&control)
            }));
            lock(&held).take();
            let _ = send.send(outcome);
        });
        let received = tokio::select! {
            received = receive => received,
            () = reached.unheard() => {
                tracing::error!(job = %reached.job, lane = self.name, "a computation does not end; it gets no more of this process");
                match pool(self.name, self.threads, self.nice) {
                    Ok(new) => {
                        *lock(&self.pool) = new;
                        lock(&permit).take();
                    }
                    Err(error) => tracing::error!(%error, "its thread stays taken"),
                }
                return Err(reached.fault());
            }
        };
        match received.map_err(|_| Fault::Stopped)? {
            Ok(Ok(value)) => Ok(value),
            Ok(Err(EngineError::Cancelled)) => Err(reached.fault()),
            Ok(Err(error)) => Err(Fault::Engine(error)),
            Err(panic) => Err(Fault::Panic(panic_text(&*panic))),
        }
    }
}

fn pool(name: &'static str, threads: usize, nice: i32) -> Result<ThreadPool, ThreadPoolBuildError> {
    // On Linux niceness is a thread's own.
    let concede = move |index| {
        if let Err(error) = rustix::process::nice(nice) {
            tracing::warn!(%error, thread = format!("{name}-{index}"), "runs with the priority of all");
        }
    };
    ThreadPoolBuilder::new()
        .num_threads(threads)
        .thread_name(move |index| format!("{name}-{index}"))
        .start_handler(concede)
        .build()
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// What a computation may ask while it runs, and where it tells how far it is.
#[derive(Clone)]
pub struct Control {
    pub hub: Hub,
    pub job: Uuid,
    pub token: CancellationToken,
    /// Time that the stage may take.
    pub limit: Duration,
    pub deadline: Option<Instant>,
}

impl Control {
    fn started(mut self) -> Self {
        self.deadline = Some(Instant::now() + self.limit);
        self
    }

    fn late(&self) -> bool {
        self.deadline
            .is_some_and(|deadline| Instant::now() >= deadline)
    }

    /// Why a computation ends before its time.
    fn fault(&self) -> Fault {
        if self.late() {
            Fault::Deadline(self.limit)
        } else {
            Fault::Stopped
        }
    }

    /// Returns when the computation should have ended for some time.
    async fn unheard(&self) {
        let _ = tokio::time::timeout(self.limit, self.token.cancelled()).await;
        tokio::time::sleep(DEAF).await;
    }
}

impl Progress for Control {
    fn iteration(&self, trial: usize, iteration: usize, best_cost: f64) {
        crash::point("in_trial");
        self.hub.iteration(
            self.job,
            Iteration {
                trial,
                iteration,
                best_cost,
            },
        );
    }

    fn cancelled(&self) -> bool {
        self.token.is_cancelled() || self.late()
    }
}

fn panic_text(panic: &(dyn Any + Send)) -> String {
    panic
        .downcast_ref::<&str>()
        .map(|text| (*text).to_owned())
        .or_else(|| panic.downcast_ref::<String>().cloned())
        .unwrap_or_else(|| "no message".to_owned())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn control(limit: Duration) -> Control {
        Control {
            hub: Hub::new(),
            job: Uuid::now_v7(),
            token: CancellationToken::new(),
            limit,
            deadline: None,
        }
    }

    fn until_told(progress: &dyn Progress) -> Result<(), EngineError> {
        while !progress.cancelled() {
            std::thread::yield_now();
        }
        Err(EngineError::Cancelled)
    }

    #[tokio::test]
    async fn a_panic_is_a_fault_and_the_pool_lives_on() {
        let compute = Compute::new(1).unwrap();
        let minute = Duration::from_secs(60);
        for _ in 0..3 {
            let fault = compute
                .diagnosis
                .run::<(), _>(control(minute), |_| panic!("numbers ran out"))
                .await
                .unwrap_err();
            assert!(matches!(fault, Fault::Panic(text) if text == "numbers ran out"));
        }
        let answer = compute
            .diagnosis
            .run(control(minute), |_| Ok(42))
            .await
            .unwrap();
        assert_eq!(answer, 42);
    }

    #[tokio::test]
    async fn deaf_work_is_given_up_and_its_permit_comes_back_once() {
        let compute = Compute::new(1).unwrap();
        let (end, ended) = std::sync::mpsc::channel::<()>();
        let deaf = move |_: &dyn Progress| {
            let _ = ended.recv();
            Ok(())
        };
        let fault = compute.diagnosis.run(control(Duration::ZERO), deaf).await;
        assert!(matches!(fault, Err(Fault::Deadline(_))));
        let minute = Duration::from_secs(60);
        compute
            .diagnosis
            .run(control(minute), |_| Ok(()))
            .await
            .unwrap();
        drop(end);
        compute
            .diagnosis
            .run(control(minute), |_| Ok(()))
            .await
            .unwrap();
        assert_eq!(compute.diagnosis.permits.available_permits(), 1);
    }

    #[tokio::test]
    async fn the_deadline_and_the_token_end_a_loop_that_asks() {
        let compute = Compute::new(1).unwrap();
        let late = compute
            .diagnosis
            .run(control(Duration::ZERO), until_told)
            .await;
        assert!(matches!(late, Err(Fault::Deadline(_))));
        let stopped = control(Duration::from_secs(60));
        stopped.token.cancel();
        let fault = compute.diagnosis.run(stopped, until_told).await;
        assert!(matches!(fault, Err(Fault::Stopped)));
    }
}
