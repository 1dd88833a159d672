//! Computing, away from the async threads: a lane for the quick stages, one for swarms and diagnoses (and one for the readers
//! of files: readers.rs). Each has as many permits as threads or, where work is isolated, as children, and grants them by turn.

use std::sync::Arc;

use rayon::ThreadPoolBuildError;
use veloid_engine::Progress;
use veloid_engine::swarm::Swarm;

use super::control::Control;
use super::drawing::Drawn;
use super::fault::Fault;
use super::isolate::{Child, Children};
use super::permits::Permits;
use super::task::{Order, Outcome, Subject, Task};
use super::threads::Threads;
use crate::lru::Lru;

/// Threads for the quick stages; they take turns with the others by the system's scheduler.
pub const QUICK_THREADS: usize = 4;

/// What the threads of swarms and diagnoses concede (`nice`), so that answers and quick stages need not
/// wait for them however many cores compute.
const LONG_NICE: i32 = 5;

/// Most threads of one child. A lane of n children has n times as many, of which n have a core.
const CHILD_THREADS: usize = 8;

/// Jobs whose swarms are kept ready: those that trials may be running of.
const SWARMS: usize = 4;

/// The lanes of one process.
pub struct Compute {
    pub quick: Lane,
    /// Swarms and diagnoses.
    pub long: Lane,
}

impl Compute {
    /// `threads` for swarms and diagnoses together; in child processes that have so much memory (bytes) for a
    /// job, if any is said.
    pub fn new(threads: usize, isolated: Option<u64>) -> Result<Self, ThreadPoolBuildError> {
        let lane = |name, threads, nice| Lane::new(name, threads, nice, isolated);
        Ok(Self {
            quick: lane("quick", QUICK_THREADS, 0)?,
            long: lane("long", threads, LONG_NICE)?,
        })
    }
}

pub struct Lane {
    place: Place,
    pub threads: usize,
}

/// Where a lane computes.
enum Place {
    /// With what the trials of the last few jobs share, and the curves that were drawn last.
    Here(Threads, Lru<Swarm>, Arc<Drawn>),
    Children(Children, Permits),
}

impl Lane {
    /// In child processes that have so much memory (bytes) for a job, if any is said.
    pub fn new(
        name: &'static str,
        threads: usize,
        nice: i32,
        isolated: Option<u64>,
    ) -> Result<Self, ThreadPoolBuildError> {
        let child = |memory| Child {
            threads: threads.min(CHILD_THREADS),
            nice,
            memory,
        };
        let place = match isolated.map(child) {
            Some(child) => Place::Children(Children::new(child), Permits::new(threads)),
            None => {
                let threads = Threads::new(name, threads, nice)?;
                Place::Here(threads, Lru::new(SWARMS), Arc::default())
            }
        };
        Ok(Self { place, threads })
    }

    /// Whether work is done in child processes.
    pub fn is_isolated(&self) -> bool {
        matches!(self.place, Place::Children(..))
    }

    /// Carries an order out.
    pub async fn perform(&self, control: Control, order: Order) -> Result<Outcome, Fault> {
        match &self.place {
            Place::Here(threads, swarms, drawn) => match order {
                Order::Stage(Some(subject), task) => {
                    here(threads, swarms, control, subject, task).await
                }
                Order::Stage(None, _) => Err(Fault::Mismatch),
                Order::Errand(errand) => {
                    let drawn = Arc::clone(drawn);
                    let work = move |_: &dyn Progress| Ok(Outcome::Errand(errand.perform(&drawn)));
                    threads.run(control, work).await
                }
                Order::Study(study) => {
                    let work = move |progress: &dyn Progress| study.perform(progress);
                    threads.run(control, work).await
                }
            },
            Place::Children(children, permits) => {
                let (control, _permit) = control.permit(permits).await?;
                control.begins();
                let hear = |heard| control.hear(heard);
                tokio::select! {
                    outcome = children.perform(order, hear) => Ok(outcome?),
                    () = control.over() => Err(control.fault()),
                }
            }
        }
    }
}

async fn here(
    threads: &Threads,
    swarms: &Lru<Swarm>,
    control: Control,
    subject: Arc<Subject>,
    task: Task,
) -> Result<Outcome, Fault> {
    let swarm = match &task {
        Task::Trials { observed, .. } => {
            let make = async || {
                let (subject, observed) = (Arc::clone(&subject), Arc::clone(observed));
                let swarm = move |_: &dyn Progress| subject.swarm(&observed);
                threads.run(control.clone(), swarm).await
            };
            Some(swarms.get(subject.job.to_string(), make).await?)
        }
        _ => None,
    };
    let work = move |progress: &dyn Progress| subject.perform(task, swarm.as_deref(), progress);
    threads.run(control, work).await
}
