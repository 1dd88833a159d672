//! Threads of this process that compute, and as many permits.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};
use tokio::sync::oneshot;
use veloid_engine::{EngineError, Progress};

use super::control::Control;
use super::fault::Fault;
use super::panics::panic_text;
use super::permits::Permits;

pub struct Threads {
    name: &'static str,
    pool: Mutex<ThreadPool>,
    permits: Permits,
    count: usize,
    nice: i32,
}

impl Threads {
    pub fn new(name: &'static str, count: usize, nice: i32) -> Result<Self, ThreadPoolBuildError> {
        Ok(Self {
            name,
            pool: Mutex::new(pool(name, count, nice)?),
            permits: Permits::new(count),
            count,
            nice,
        })
    }

    /// Runs `work`. The permit travels with it: should River give the async side up, the thread stays
    /// counted until it really ends. Deaf work is left to itself, and there are new threads.
    pub async fn run<T, F>(&self, control: Control, work: F) -> Result<T, Fault>
    where
        T: Send + 'static,
        F: FnOnce(&dyn Progress) -> Result<T, EngineError> + Send + 'static,
    {
        let (control, permit) = control.permit(&self.permits).await?;
        let (send, receive) = oneshot::channel();
        let reached = control.clone();
        let permit = Arc::new(Mutex::new(Some(permit)));
        let held = Arc::clone(&permit);
        lock(&self.pool).spawn(move || {
            let outcome = catch_unwind(AssertUnwindSafe(|| {
                control.begins();
                work(&control)
            }));
            lock(&held).take();
            let _ = send.send(outcome);
        });
        let received = tokio::select! {
            received = receive => received,
            () = reached.unheard() => {
                let job = reached.job.as_ref().map(|(job, _)| job);
                tracing::error!(?job, lane = self.name, "a computation does not end; it gets no further threads");
                match pool(self.name, self.count, self.nice) {
                    Ok(new) => {
                        *lock(&self.pool) = new;
                        lock(&permit).take();
                    }
                    Err(error) => tracing::error!(%error, "its thread remains occupied"),
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::time::Duration;

    use tokio_util::sync::CancellationToken;
    use uuid::Uuid;

    use super::*;
    use crate::jobs::hub::Hub;

    fn control(limit: Duration) -> Control {
        Control {
            job: Some((Uuid::now_v7(), Hub::new())),
            turn: 0,
            token: CancellationToken::new(),
            limit,
            deadline: None,
        }
    }

    fn until_cancelled(progress: &dyn Progress) -> Result<(), EngineError> {
        while !progress.cancelled() {
            std::thread::yield_now();
        }
        Err(EngineError::Cancelled)
    }

    #[tokio::test]
    async fn a_panic_is_a_fault_and_the_pool_lives_on() {
        let threads = Threads::new("long", 1, 0).unwrap();
        let minute = Duration::from_secs(60);
        for _ in 0..3 {
            let fault = threads
                .run::<(), _>(control(minute), |_| panic!("numbers ran out"))
                .await
                .unwrap_err();
            assert!(matches!(fault, Fault::Panic(text) if text == "numbers ran out"));
        }
        let answer = threads.run(control(minute), |_| Ok(42)).await.unwrap();
        assert_eq!(answer, 42);
    }

    #[tokio::test]
    async fn deaf_work_is_given_up_and_its_permit_comes_back_once() {
        let threads = Threads::new("long", 1, 0).unwrap();
        let (end, ended) = std::sync::mpsc::channel::<()>();
        let deaf = move |_: &dyn Progress| {
            let _ = ended.recv();
            Ok(())
        };
        let fault = threads.run(control(Duration::ZERO), deaf).await;
        assert!(matches!(fault, Err(Fault::Deadline(_))));
        let minute = Duration::from_secs(60);
        threads.run(control(minute), |_| Ok(())).await.unwrap();
        drop(end);
        threads.run(control(minute), |_| Ok(())).await.unwrap();
        assert_eq!(threads.permits.free(), 1);
    }

    #[tokio::test]
    async fn the_deadline_and_the_token_end_a_loop_that_asks() {
        let threads = Threads::new("long", 1, 0).unwrap();
        let late = threads.run(control(Duration::ZERO), until_cancelled).await;
        assert!(matches!(late, Err(Fault::Deadline(_))));
        let stopped = control(Duration::from_secs(60));
        stopped.token.cancel();
        let fault = threads.run(stopped, until_cancelled).await;
        assert!(matches!(fault, Err(Fault::Stopped)));
    }
}
