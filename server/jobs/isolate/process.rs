//! One child, seen from its parent.

use std::io;
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{ExitStatus, Stdio};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use rustix::process::Signal;
use tokio::io::{AsyncBufReadExt, AsyncWriteExt, BufReader};
use tokio::process::{ChildStderr, ChildStdin, ChildStdout, Command};
use tokio::task::{JoinHandle, spawn_blocking};
use uuid::Uuid;

use super::child::Child;
use super::frame;
use super::word::Word;
use crate::jobs::hub::Heard;
use crate::jobs::task::{Order, Outcome};

/// Time in which a child that closed its pipes is gone, and what it said has arrived.
const GONE: Duration = Duration::from_secs(1);
/// Memory that the allocator asks the system for at a time (KiB); its own 1 GiB would count as the job's.
const STEP_KIB: &str = "32768";
/// What of its parent's environment it gets.
const KEPT: [&str; 2] = ["LD_LIBRARY_PATH", "VELOID_POISON"];
/// Longest part of a line that is kept of what a child says (characters).
const LINE: usize = 300;

/// What the standard library says before it aborts for want of memory.
const REFUSED: &str = "memory allocation of";

/// Why an order did not come to its end in a child.
#[derive(Debug, thiserror::Error)]
pub enum Ended {
    #[error("{message}")]
    Refused { is_input: bool, message: String },
    #[error("{0}")]
    Panicked(String),
    /// It ended by itself, which nothing but its work can have brought about.
    #[error("{0}")]
    Died(String),
    /// The same, when it was refused more memory.
    #[error("{0}")]
    OutOfMemory(String),
    /// It was ended from outside; by the system for want of memory, perhaps.
    #[error("{0}")]
    Killed(String),
    #[error("asked to end")]
    Asked,
    #[error("child process: {0}")]
    Pipe(#[from] io::Error),
}

/// Drop ends it, deaf or not.
pub struct Process {
    child: tokio::process::Child,
    orders: ChildStdin,
    words: BufReader<ChildStdout>,
    /// What it said last on its standard error.
    said: Arc<Mutex<String>>,
    listener: JoinHandle<()>,
    /// The job that it knows.
    holds: Option<Uuid>,
    /// The job whose curves it drew last.
    drew: Option<Uuid>,
}

impl Process {
    pub fn start(as_what: &Child) -> io::Result<Self> {
        let mut command = Command::new(program()?);
        command
            .arg("compute")
            .args(["--threads", &as_what.threads.to_string()])
            .args(["--nice", &as_what.nice.to_string()])
            .args(["--memory", &as_what.memory.to_string()])
            // Nor does it know how to reach the database.
            .env_clear()
            .envs(
                KEPT.iter()
                    .filter_map(|name| Some((name, std::env::var_os(name)?))),
            )
            .env("MIMALLOC_ARENA_RESERVE", STEP_KIB)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            // Ctrl-C is for the parent to hear.
            .process_group(0)
            .kill_on_drop(true);
        let mut child = command.spawn()?;
        let closed = || io::Error::from(io::ErrorKind::BrokenPipe);
        let said = Arc::default();
        let errors = child.stderr.take().ok_or_else(closed)?;
        Ok(Self {
            orders: child.stdin.take().ok_or_else(closed)?,
            words: BufReader::new(child.stdout.take().ok_or_else(closed)?),
            listener: tokio::spawn(listen(errors, Arc::clone(&said))),
            said,
            holds: None,
            drew: None,
            child,
        })
    }

    /// Whether it has at hand what an order is about.
    pub fn knows(&self, order: &Order) -> bool {
        match order {
            Order::Stage(subject, _) => {
                let job = subject.as_ref().map(|subject| subject.job);
                job.is_some() && job == self.holds
            }
            Order::Errand(errand) => errand.job().is_some() && errand.job() == self.drew,
            Order::Study(_) => false,
        }
    }

    /// Whether it can take an order.
    pub fn lives(&mut self) -> bool {
        matches!(self.child.try_wait(), Ok(None))
    }

    /// Has an order carried out, and passes on what is reported meanwhile.
    pub async fn perform(
        &mut self,
        mut order: Order,
        hear: impl Fn(Heard),
    ) -> Result<Outcome, Ended> {
        let knows = self.knows(&order);
        match &mut order {
            Order::Stage(subject, _) if knows => *subject = None,
            Order::Stage(subject, _) => self.holds = subject.as_ref().map(|subject| subject.job),
            Order::Errand(errand) => self.drew = errand.job().or(self.drew),
            Order::Study(_) => {}
        }
        let order = spawn_blocking(move || frame::encode(&order));
        let order = order.await.map_err(io::Error::other)??;
        if self.orders.write_all(&order).await.is_err() {
            return Err(self.end().await);
        }
        drop(order);
        loop {
            let Ok(bytes) = frame::receive(&mut self.words).await else {
                return Err(self.end().await);
            };
            let word = spawn_blocking(move || frame::decode(&bytes));
            match word.await.map_err(io::Error::other)?? {
                Word::Meanwhile(heard) => heard.into_iter().for_each(&hear),
                Word::Done(outcome) => return Ok(outcome),
                Word::Refused { is_input, message } => {
                    return Err(Ended::Refused { is_input, message });
                }
                Word::Panicked(text) => return Err(Ended::Panicked(text)),
            }
        }
    }

    /// How it ended, once its pipes are closed.
    async fn end(&mut self) -> Ended {
        let Ok(status) = tokio::time::timeout(GONE, self.child.wait()).await else {
            return Ended::Pipe(io::ErrorKind::BrokenPipe.into());
        };
        let _ = tokio::time::timeout(GONE, &mut self.listener).await;
        let said = self.said.lock().unwrap_or_else(PoisonError::into_inner);
        match status {
            Ok(status) => ended(status, &said),
            Err(error) => Ended::Pipe(error),
        }
    }
}

fn ended(status: ExitStatus, said: &str) -> Ended {
    let why = match said {
        "" => format!("the computing process ended: {status}"),
        said => format!("the computing process ended: {said} ({status})"),
    };
    match status.signal().and_then(Signal::from_named_raw) {
        Some(Signal::HUP | Signal::INT | Signal::TERM) => Ended::Asked,
        Some(Signal::KILL) => Ended::Killed(why),
        _ if said.starts_with(REFUSED) => Ended::OutOfMemory(why),
        _ => Ended::Died(why),
    }
}

/// This program, even where a newer one has taken its place on the disk; where no `/proc` is mounted, by the path that it was
/// started with.
fn program() -> io::Result<PathBuf> {
    let running = Path::new("/proc/self/exe");
    if running.exists() {
        return Ok(running.into());
    }
    let started = || std::env::args_os().next().map(PathBuf::from);
    std::env::current_exe().or_else(|error| started().ok_or(error))
}

/// Logs what a child says on its standard error, and keeps the last line.
async fn listen(errors: ChildStderr, said: Arc<Mutex<String>>) {
    let mut lines = BufReader::new(errors).lines();
    while let Ok(Some(line)) = lines.next_line().await {
        let line: String = line.trim().chars().take(LINE).collect();
        // The standard library's advice to set a variable is no cause.
        if !line.is_empty() && !line.starts_with("note: ") {
            tracing::warn!(line, "message of a child process");
            *said.lock().unwrap_or_else(PoisonError::into_inner) = line;
        }
    }
}
