//! The child's side: reads orders from its standard input, carries them out one after the other, and ends
//! when its parent does, whatever it is computing.

use std::io::{self, Stdout};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use rayon::{ThreadPool, ThreadPoolBuilder};
use rustix::process::{Resource, Rlimit};
use veloid_engine::swarm::Swarm;
use veloid_engine::{EngineError, Progress};

use super::frame;
use super::word::Word;
use crate::jobs::drawing::Drawn;
use crate::jobs::hub::{Heard, Iteration, Searched};
use crate::jobs::panics::panic_text;
use crate::jobs::task::{Order, Outcome, Subject, Task};

/// What happens is reported at most this often; a short swarm has a hundred in a few milliseconds.
const EVERY: Duration = Duration::from_millis(20);
/// Memory besides the job's (bytes): the program's own, and stacks of threads.
const OWN: u64 = 256 << 20;

/// What a child is started with.
pub struct Child {
    pub threads: usize,
    pub nice: i32,
    /// Memory of a job (bytes).
    pub memory: u64,
}

#[derive(Debug, thiserror::Error)]
pub enum ChildError {
    #[error("its limits: {0}")]
    Limit(#[from] rustix::io::Errno),
    #[error("its threads: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
    #[error("its parent: {0}")]
    Parent(#[from] io::Error),
}

impl Child {
    /// Works until the parent hangs up.
    pub fn run(&self) -> Result<(), ChildError> {
        let limit = Some(self.memory.saturating_add(OWN));
        let limit = Rlimit {
            current: limit,
            maximum: limit,
        };
        // Writable memory, not addresses: those that an allocator keeps in store cost nothing.
        rustix::process::setrlimit(Resource::Data, limit)?;
        // Nor does what it knew of a ride get onto the disk when it dies.
        let none = Rlimit {
            current: Some(0),
            maximum: Some(0),
        };
        rustix::process::setrlimit(Resource::Core, none)?;
        rustix::process::nice(self.nice)?;
        // Where the system runs out of memory it should end this process rather than the parent.
        let _ = std::fs::write("/proc/self/oom_score_adj", "500");
        let threads = ThreadPoolBuilder::new()
            .num_threads(self.threads)
            .thread_name(|index| format!("compute-{index}"))
            .build()?;
        let orders = orders();
        let (mut held, drawn) = (None, Drawn::default());
        let sender = Sender::default();
        while let Ok(order) = orders.recv() {
            let word = carry_out(&threads, &mut held, &drawn, order, &sender);
            sender.finish(word)?;
        }
        Ok(())
    }
}

/// Orders as they come. The thread that reads them ends the process with the parent.
fn orders() -> Receiver<Order> {
    let (send, receive) = channel();
    std::thread::spawn(move || {
        let mut pipe = io::stdin().lock();
        while let Ok(order) = frame::read(&mut pipe) {
            if send.send(order).is_err() {
                break;
            }
        }
        std::process::exit(0);
    });
    receive
}

/// The job that the last task was of, and what its trials share.
struct Held {
    subject: Arc<Subject>,
    swarm: Option<Swarm>,
}

fn carry_out(
    threads: &ThreadPool,
    held: &mut Option<Held>,
    drawn: &Drawn,
    order: Order,
    progress: &Sender,
) -> Word {
    let work = || match order {
        Order::Stage(subject, task) => {
            if let Some(subject) = subject {
                let swarm = None;
                *held = Some(Held { subject, swarm });
            }
            let held = held.as_mut().expect("a task comes with its job");
            held.perform(task, progress)
        }
        Order::Errand(errand) => Ok(Outcome::Errand(errand.perform(drawn))),
        Order::Study(study) => study.perform(progress),
    };
    match catch_unwind(AssertUnwindSafe(|| threads.install(work))) {
        Ok(Ok(outcome)) => Word::Done(outcome),
        Ok(Err(error)) => Word::Refused {
            is_input: error.is_input(),
            message: error.to_string(),
        },
        Err(panic) => Word::Panicked(panic_text(&*panic)),
    }
}

impl Held {
    fn perform(&mut self, task: Task, progress: &dyn Progress) -> Result<Outcome, EngineError> {
        if let (Task::Trials { observed, .. }, None) = (&task, &self.swarm) {
            self.swarm = Some(self.subject.swarm(observed)?);
        }
        self.subject.perform(task, self.swarm.as_ref(), progress)
    }
}

/// The way to the parent.
struct Sender(Mutex<Unsaid>);

/// What is reported with the next word.
struct Unsaid {
    heard: Vec<Heard>,
    spoke: Instant,
    pipe: Stdout,
}

impl Default for Sender {
    fn default() -> Self {
        Self(Mutex::new(Unsaid {
            heard: Vec::new(),
            spoke: Instant::now(),
            pipe: io::stdout(),
        }))
    }
}

impl Sender {
    fn send(&self, heard: Heard) {
        let mut unsaid = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        unsaid.heard.push(heard);
        if unsaid.spoke.elapsed() >= EVERY && unsaid.say().is_err() {
            // Nobody listens any more.
            std::process::exit(0);
        }
    }

    fn finish(&self, word: Word) -> io::Result<()> {
        let mut unsaid = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        unsaid.say()?;
        frame::write(&mut unsaid.pipe, &word)
    }
}

impl Unsaid {
    fn say(&mut self) -> io::Result<()> {
        self.spoke = Instant::now();
        let heard = std::mem::take(&mut self.heard);
        match heard.is_empty() {
            true => Ok(()),
            false => frame::write(&mut self.pipe, &Word::Meanwhile(heard)),
        }
    }
}

impl Progress for Sender {
    fn iteration(&self, trial: usize, iteration: usize, best_cost: f64) {
        self.send(Heard::Iteration(Iteration {
            trial,
            iteration,
            best_cost,
        }));
    }

    fn searched(&self, steps: u64, budget: u64) {
        self.send(Heard::Searched(Searched { steps, budget }));
    }
}
