//! The section of how long rides take that run alone.

use super::begun::Register;
use super::budget::Budget;
use super::kept::{Asked, Kept};
use super::proof::{ProveError, Shown};
use super::run::Runs;
use super::{document, time};
use crate::suite::folder;

/// How long rides take, one after the other; on a slower machine in a section of another name.
pub struct Times<'a> {
    pub register: &'a Register,
    pub section: &'a str,
    pub budget: Budget,
}

impl Times<'_> {
    /// Writes the section, unless no ride is in.
    pub fn write(&self) -> Result<Shown, ProveError> {
        let Register {
            work, seal, origin, ..
        } = self.register;
        let asked = Asked {
            seed: seal.seed,
            binary: &origin.binary,
            sha256: origin.sha256(),
        };
        let kept = Kept::open(work, self.section, &asked)?;
        let folder = work.join("timing");
        let rides = folder::make_timing(&folder, seal.seed)?;
        let listed = self.register.begin(self.section, rides.len())?;
        let runs = Runs {
            binary: &origin.binary,
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
            "## {title}\n\n{} rides, sealed seed {}. {}\n{}",
            document::of(shown.rides, shown.planned),
            seal.seed,
            origin.line(),
            time::table(&timed)
        );
        listed.write(&shown.text, shown.rides, shown.planned)?;
        Ok(shown)
    }
}
