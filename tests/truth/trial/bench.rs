//! A binary under trial: runs it, keeps what came of each ride, and goes on where it was stopped.

use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};

use rayon::prelude::*;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

use crate::files::{self, FilesError};
use crate::prove::budget::Budget;
use crate::prove::kept::{Asked, Kept, KeptError};
use crate::suite::made;

/// What is run, on what, and for how long.
#[derive(Clone, Debug)]
pub struct Order {
    pub binary: PathBuf,
    pub work: PathBuf,
    pub seed: u64,
    /// Rides of each class, or sets of each kind.
    pub count: u64,
    pub budget: Budget,
}

#[derive(Debug, thiserror::Error)]
pub enum TrialError {
    /// Who stops a trial may stop the binary first, which then says nothing of the ride; what is in is kept.
    #[error("{} was killed, {status}; the same command goes on", binary.display())]
    Killed { binary: PathBuf, status: ExitStatus },
    #[error("cannot run {}: {source}", binary.display())]
    NotRun {
        binary: PathBuf,
        source: std::io::Error,
    },
    #[error(transparent)]
    Kept(#[from] KeptError),
    #[error(transparent)]
    Files(#[from] FilesError),
}

/// A report, or what a binary says where it gives none.
pub type Reported = Result<Value, String>;

pub struct Bench {
    order: Order,
    kept: Kept,
    /// SHA-256 of this program, which makes the rides, and of the binary: outcomes of others are not taken.
    programs: String,
}

/// A swarm as small as it gets: neither the diagnosis nor the last estimate depends on it.
pub const QUICK: [&str; 6] = ["--trials", "1", "--iterations", "3", "--particles", "6"];

impl Bench {
    /// # Errors
    /// A folder that holds outcomes of another seed, and files that cannot be written.
    pub fn open(order: Order, section: &str) -> Result<Self, TrialError> {
        files::create_folder(&order.work)?;
        let sha256 = files::digest(files::read_bytes(&order.binary)?);
        let asked = Asked {
            seed: order.seed,
            binary: &order.binary,
            sha256: &sha256,
        };
        let maker = made::this_program().unwrap_or_default();
        Ok(Self {
            kept: Kept::open(&order.work, section, &asked)?,
            programs: format!("{maker} {sha256}"),
            order,
        })
    }

    /// The outcomes of these rides of a class, as many at once as rayon has threads; none of those not begun within the budget.
    pub fn all<T>(
        &self,
        class: &str,
        numbers: impl IntoIterator<Item = u64>,
        one: impl Fn(&str, u64) -> Result<T, TrialError> + Sync,
    ) -> Result<Vec<T>, TrialError>
    where
        T: Serialize + DeserializeOwned + Send,
    {
        let outcome = |number: u64| {
            let name = format!("{class}_{number:03}");
            let before = self.kept.get(&name, &self.programs)?;
            if before.is_some() || self.order.budget.is_used() {
                return Ok(before);
            }
            let outcome = self.once(&name, || one(&name, number))?;
            eprintln!("{name}");
            Ok(Some(outcome))
        };
        let numbers: Vec<u64> = numbers.into_iter().collect();
        let all: Vec<Option<T>> = numbers
            .into_par_iter()
            .map(outcome)
            .collect::<Result<_, TrialError>>()?;
        Ok(all.into_iter().flatten().collect())
    }

    /// What is kept under a name, or what comes now and is kept.
    pub fn once<T>(
        &self,
        name: &str,
        one: impl FnOnce() -> Result<T, TrialError>,
    ) -> Result<T, TrialError>
    where
        T: Serialize + DeserializeOwned,
    {
        if let Some(before) = self.kept.get(name, &self.programs)? {
            return Ok(before);
        }
        let outcome = one()?;
        self.kept.keep(name, &self.programs, &outcome)?;
        Ok(outcome)
    }

    /// Rides of each class, or sets of each kind.
    pub fn count(&self) -> u64 {
        self.order.count
    }

    pub fn seed(&self) -> u64 {
        self.order.seed
    }

    /// Writes a file of a ride, to be removed once it was read.
    pub fn write(&self, name: &str, text: &str) -> Result<Scratch, FilesError> {
        let path = self.order.work.join(name);
        files::write(&path, text)?;
        Ok(Scratch(path))
    }

    /// What `identify` reports of a ride.
    pub fn identify(
        &self,
        ride: &Path,
        bike: &Path,
        more: &[&str],
    ) -> Result<Reported, TrialError> {
        self.report("identify", &[ride], bike, &[&QUICK, more].concat())
    }

    /// What `study` reports of the rides of one bicycle.
    pub fn study(&self, rides: &[Scratch], bike: &Path) -> Result<Reported, TrialError> {
        let rides: Vec<&Path> = rides.iter().map(|ride| ride.0.as_path()).collect();
        self.report("study", &rides, bike, &[])
    }

    fn report(
        &self,
        command: &str,
        rides: &[&Path],
        bike: &Path,
        more: &[&str],
    ) -> Result<Reported, TrialError> {
        let binary = &self.order.binary;
        let run = Command::new(binary)
            .arg(command)
            .args(rides)
            .arg("--bike")
            .arg(bike)
            .args(["--json", "-"])
            .args(more)
            .stdin(Stdio::null())
            .output();
        let done = run.map_err(|source| TrialError::NotRun {
            binary: binary.clone(),
            source,
        })?;
        if done.status.code().is_none() {
            return Err(TrialError::Killed {
                binary: binary.clone(),
                status: done.status,
            });
        }
        if !done.status.success() {
            let said = String::from_utf8_lossy(&done.stderr);
            return Ok(Err(said.lines().last().unwrap_or_default().to_owned()));
        }
        Ok(serde_json::from_slice(&done.stdout).map_err(|e| e.to_string()))
    }
}

/// What stands above tables that lack outcomes.
pub fn progress(done: usize, all: u64) -> String {
    match done as u64 == all {
        true => String::new(),
        false => format!("{done} of {all} are in; the same command goes on.\n\n"),
    }
}

/// A file that is removed when it is no longer needed.
pub struct Scratch(pub PathBuf);

impl Scratch {
    /// Leaves the file where it is.
    pub fn keep(self) {
        std::mem::forget(self);
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        // What cannot be removed is in nobody's way.
        let _ = std::fs::remove_file(&self.0);
    }
}
