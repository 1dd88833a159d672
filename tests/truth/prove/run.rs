//! Runs a binary on every ride as a user would.

use std::path::{Path, PathBuf};
use std::process::Output;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use rayon::prelude::*;

use super::budget::Budget;
use super::identify;
use super::kept::Kept;
use crate::files::{self, FilesError};
use crate::outcome::Outcome;

/// A binary, the rides of a folder, and what of them is done.
pub struct Runs<'a> {
    pub binary: &'a Path,
    pub folder: &'a Path,
    pub reports: &'a Path,
    pub kept: &'a Kept,
    pub budget: Budget,
}

impl Runs<'_> {
    /// Identifies the rides that are not done, as many at once as rayon has threads, until the budget is used; outcomes in the
    /// order of `names`, none of rides that were not begun.
    pub fn all(&self, names: &[String]) -> Result<Vec<Option<Outcome>>, FilesError> {
        let before: Vec<Option<Outcome>> = names
            .par_iter()
            .map(|name| self.kept.get(name, &self.digest(name)?))
            .collect::<Result<_, _>>()?;
        let done = AtomicUsize::new(before.iter().flatten().count());
        if done.load(Ordering::Relaxed) > 0 {
            eprintln!(
                "{}/{} rides were in",
                done.load(Ordering::Relaxed),
                names.len()
            );
        }
        names
            .par_iter()
            .zip(before)
            .map(|(name, before)| {
                if before.is_some() {
                    return Ok(before);
                }
                let outcome = self.one(name)?;
                if let Some(outcome) = &outcome {
                    let count = done.fetch_add(1, Ordering::Relaxed) + 1;
                    eprintln!(
                        "{count}/{} ride {name}: {} in {:.1} s",
                        names.len(),
                        outcome.verdict,
                        outcome.seconds
                    );
                }
                Ok(outcome)
            })
            .collect()
    }

    /// The outcome that is kept of a ride, or that of identifying it, or nothing once the budget is used.
    pub fn one(&self, name: &str) -> Result<Option<Outcome>, FilesError> {
        let digest = self.digest(name)?;
        let before = self.kept.get(name, &digest)?;
        if before.is_some() || self.budget.is_used() {
            return Ok(before);
        }
        let (outcome, lasts) = self.identify(name);
        if lasts {
            self.kept.keep(name, &digest, &outcome)?;
        }
        Ok(Some(outcome))
    }

    fn digest(&self, name: &str) -> Result<String, FilesError> {
        let mut bytes = files::read_bytes(&self.ride(name))?;
        bytes.extend(files::read_bytes(&self.bike(name))?);
        Ok(files::digest(bytes))
    }

    fn ride(&self, name: &str) -> PathBuf {
        self.folder.join(format!("ride_{name}.csv"))
    }

    fn bike(&self, name: &str) -> PathBuf {
        self.folder.join(format!("bike_{name}.json"))
    }

    /// `BINARY identify RIDE --bike BIKE --json OUT`, and whether it ended by itself: who stops a proof may stop the
    /// binary first, which then says nothing of the ride.
    fn identify(&self, name: &str) -> (Outcome, bool) {
        let out = self.reports.join(format!("report_{name}.json"));
        // The binary of a proof that was killed may still be writing its own.
        let part = out.with_extension(format!("json.{}.part", std::process::id()));
        let begun = Instant::now();
        let run = identify::ride(self.binary, self.folder, name, &part);
        let seconds = begun.elapsed().as_secs_f64();
        let lasts = run.as_ref().is_ok_and(|done| done.status.code().is_some());
        let report = match run {
            Err(e) => Err(format!("{}: {e}", self.binary.display())),
            Ok(done) if !done.status.success() => Err(last_words(&done)),
            Ok(_) => std::fs::rename(&part, &out)
                .map_err(|e| format!("no report: {e}"))
                .and_then(|()| files::read_json(&out).map_err(|e| e.to_string())),
        };
        let outcome = match report {
            Ok(report) => Outcome::read(&report, seconds),
            Err(error) => Outcome::failed(error, seconds),
        };
        (outcome, lasts)
    }
}

fn last_words(done: &Output) -> String {
    let said = String::from_utf8_lossy(&done.stderr);
    let last = said.lines().last().unwrap_or_default();
    format!("{}: {last}", done.status)
}
