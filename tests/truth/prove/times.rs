//! The section of how long rides take that run alone.

use std::path::Path;

use super::budget::Budget;
use super::kept::{Kept, Of};
use super::origin::Origin;
use super::proof::{ProveError, Shown};
use super::run::Runs;
use super::{document, time};
use crate::suite::files;

/// How long rides take, one after the other; on a slower machine in a section of another name.
pub struct Times<'a> {
    pub origin: &'a Origin,
    pub seed: u64,
    pub work: &'a Path,
    pub docs: &'a Path,
    pub section: &'a str,
    pub budget: Budget,
}

impl Times<'_> {
    /// Writes the section, unless no ride is in.
    pub fn write(&self) -> Result<Shown, ProveError> {
        let of = Of {
            seed: self.seed,
            binary_sha256: self.origin.sha256().to_owned(),
        };
        let kept = Kept::open(self.work, self.section, &of)?;
        let folder = self.work.join("timing");
        let rides = files::make_timing(&folder, self.seed)?;
        let runs = Runs {
            binary: &self.origin.binary,
            folder: &folder,
            reports: &folder,
            kept: &kept,
            budget: self.budget,
        };
        let timed = time::alone(&runs, &rides)?;
        let mut shown = Shown {
            text: String::new(),
            rides: timed.len(),
            planned: rides.len(),
        };
        if timed.is_empty() {
            return Ok(shown);
        }
        let title = match self.section {
            "timing" => "Time of a ride, alone on the machine",
            _ => "The same on a slower machine",
        };
        shown.text = format!(
            "## {title}\n\n{} rides, seed {}. {}\n{}",
            document::of(shown.rides, shown.planned),
            self.seed,
            self.origin.line(),
            time::table(&timed)
        );
        document::insert(self.docs, self.section, &shown.text)?;
        Ok(shown)
    }
}
