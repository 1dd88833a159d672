//! Work beside the interpreter: it runs on threads of its own, while the caller's thread hears of its progress and of Ctrl-C.

use std::panic::resume_unwind;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::scope;
use std::time::Duration;

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use veloid_engine::{Progress, Settings};

use crate::failure::Failure;

/// How often signals are asked for while nothing happens.
const TICK: Duration = Duration::from_millis(50);

/// A stage, how much of it is done, and how much there is.
type Step = (String, u64, u64);

/// Threads of one call: they end with it, so that the process may fork afterwards.
pub fn pool(threads: Option<usize>) -> PyResult<ThreadPool> {
    let pool = ThreadPoolBuilder::new().num_threads(threads.unwrap_or(0));
    pool.build()
        .map_err(|e| PyRuntimeError::new_err(e.to_string()))
}

/// Runs `work` on the pool without the interpreter's lock. `progress` is called on this thread; what it raises, or a
/// signal's handler, stops the work and is raised in its place.
pub fn beside<T: Send>(
    py: Python<'_>,
    pool: &ThreadPool,
    settings: &Settings,
    progress: Option<Bound<'_, PyAny>>,
    work: impl FnOnce(&dyn Progress) -> Result<T, Failure> + Send,
) -> PyResult<T> {
    let stop = AtomicBool::new(false);
    let (steps, heard) = channel();
    let reported = Told {
        steps,
        stop: &stop,
        iterations: AtomicU64::new(0),
        all: (settings.trials * settings.iterations) as u64,
    };
    scope(|scope| {
        let worker = scope.spawn(move || pool.install(|| work(&reported)));
        let raised = listen(py, heard, progress.as_ref());
        if raised.is_err() {
            stop.store(true, Ordering::Relaxed);
        }
        let done = py.detach(|| worker.join());
        raised?;
        Ok(done.unwrap_or_else(|panic| resume_unwind(panic))?)
    })
}

/// Until the work is over, or something is raised.
fn listen(
    py: Python<'_>,
    mut heard: Receiver<Step>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<()> {
    loop {
        py.check_signals()?;
        let (back, step) = py.detach(move || {
            let step = heard.recv_timeout(TICK);
            (heard, step)
        });
        heard = back;
        match (step, progress) {
            (Ok(step), Some(progress)) => {
                progress.call1(step)?;
            }
            (Err(RecvTimeoutError::Disconnected), _) => return Ok(()),
            _ => {}
        }
    }
}

/// Tells the caller's thread, and is told by it to stop.
struct Told<'a> {
    steps: Sender<Step>,
    stop: &'a AtomicBool,
    iterations: AtomicU64,
    /// Iterations of all trials.
    all: u64,
}

impl Told<'_> {
    fn tell(&self, stage: &str, done: u64, all: u64) {
        // Nobody hears it any more once the work is to stop.
        let _ = self.steps.send((stage.to_owned(), done, all));
    }
}

impl Progress for Told<'_> {
    fn stage(&self, name: &str) {
        self.tell(name, 0, 0);
    }

    fn iteration(&self, _trial: usize, _iteration: usize, _best_cost: f64) {
        let done = 1 + self.iterations.fetch_add(1, Ordering::Relaxed);
        self.tell("trials", done, self.all);
    }

    fn searched(&self, steps: u64, budget: u64) {
        self.tell("diagnose", steps, budget);
    }

    fn cancelled(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}
