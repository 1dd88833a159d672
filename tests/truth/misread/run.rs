//! Runs a binary on rides that are misread, and on the same kinds of rides as they are.

use std::path::Path;
use std::process::{Command, Stdio};

use rayon::prelude::*;
use serde_json::Value;

use super::mistake::{MISTAKES, Mistake};
use super::outcome::{Outcome, kinds, outcome};
use super::record::{Kind, Recorded, recorded};
use crate::chance::Chance;
use crate::files::{self, FilesError};

/// What is run, and on how many rides of each kind.
pub struct Trial<'a> {
    pub binary: &'a Path,
    pub work: &'a Path,
    pub seed: u64,
    pub rides: u64,
    pub clean: u64,
    /// Words that a mistake's name holds; all mistakes where there are none.
    pub only: &'a str,
}

/// Identification as quick as it gets: what is misread does not depend on the swarm.
const QUICK: [&str; 7] = [
    "--trials",
    "1",
    "--iterations",
    "3",
    "--particles",
    "6",
    "--no-diagnosis",
];

impl Trial<'_> {
    /// The table: a line for each mistake, a column for each kind of bench.
    ///
    /// # Errors
    /// A file that cannot be written or read.
    pub fn run(&self) -> Result<String, FilesError> {
        files::create_folder(self.work)?;
        let names = Kind::ALL.map(Kind::name).join(" | ");
        let mut table = format!("| mistake | {names} |\n|---|---|---|---|\n");
        let mistakes = MISTAKES.iter().enumerate();
        for (m, mistake) in mistakes.filter(|(_, m)| m.name.contains(self.only)) {
            let cell = |kind: Kind| match mistake.kinds.contains(&kind) {
                true => self.cell(m as u64, mistake, kind),
                false => Ok(String::new()),
            };
            let cells: Vec<String> = Kind::ALL.into_iter().map(cell).collect::<Result<_, _>>()?;
            let line = format!("| {} | {} |\n", mistake.name, cells.join(" | "));
            eprint!("{line}");
            table += &line;
        }
        if self.clean > 0 {
            let cells = Kind::ALL.into_iter().map(|kind| self.clean(kind));
            let cells: Vec<String> = cells.collect::<Result<_, _>>()?;
            table += &format!("| named on clean rides | {} |\n", cells.join(" | "));
        }
        Ok(table)
    }

    /// What comes of one mistake on one kind of bench, in words.
    fn cell(&self, m: u64, mistake: &Mistake, kind: Kind) -> Result<String, FilesError> {
        let one = |number: u64| {
            let mut ride = recorded(kind, self.seed, number);
            let stream = (1 << 42) + 1000 * m + number;
            (mistake.make)(&mut ride, &mut Chance::new(self.seed, stream));
            let name = format!("{m}-{}-{number}", kind as u8);
            let report = self.identify(&ride, &name)?;
            let found = outcome(
                report.as_ref().map_err(String::as_str),
                &ride,
                mistake.noticed,
            );
            if found != Outcome::Found {
                let said = match &report {
                    Ok(report) => format!("{:?}", kinds(report)),
                    Err(error) => error.clone(),
                };
                eprintln!(
                    "  {name} {}, {}: {found:?} {said}",
                    mistake.name,
                    kind.name()
                );
            }
            Ok(found)
        };
        let found: Vec<Outcome> = (0..self.rides)
            .into_par_iter()
            .map(one)
            .collect::<Result<_, FilesError>>()?;
        let count = |which| found.iter().filter(|o| **o == which).count();
        let mut cell = format!("{} of {}", count(Outcome::Found), self.rides);
        for (which, words) in [
            (Outcome::Withheld, "withheld"),
            (Outcome::Right, "right all the same"),
            (Outcome::Wrong, "wrong"),
        ] {
            if count(which) > 0 {
                cell += &format!(", {} {words}", count(which));
            }
        }
        Ok(cell)
    }

    /// Clean rides of a kind on which a mistake is named.
    fn clean(&self, kind: Kind) -> Result<String, FilesError> {
        let one = |number: u64| {
            let name = format!("clean-{}-{number}", kind as u8);
            let report = self.identify(&recorded(kind, self.seed, number), &name)?;
            let named = match &report {
                Ok(report) => kinds(report).join(" "),
                Err(error) => error.clone(),
            };
            if !named.is_empty() {
                eprintln!("  {name}: {named}");
            }
            Ok(usize::from(!named.is_empty()))
        };
        let named: usize = (0..self.clean)
            .into_par_iter()
            .map(one)
            .collect::<Result<Vec<usize>, FilesError>>()?
            .into_iter()
            .sum();
        Ok(format!("{named} of {}", self.clean))
    }

    /// The report, or what is said where there is none.
    fn identify(&self, ride: &Recorded, name: &str) -> Result<Result<Value, String>, FilesError> {
        let path = |kind: &str| self.work.join(format!("{kind}_{name}"));
        let (log, bike) = (
            path("ride").with_extension("csv"),
            path("bike").with_extension("json"),
        );
        files::write(&log, &ride.to_csv())?;
        files::write(&bike, &ride.bike.to_string())?;
        let run = Command::new(self.binary)
            .arg("identify")
            .arg(&log)
            .arg("--bike")
            .arg(&bike)
            .args(["--json", "-"])
            .args(QUICK)
            .stdin(Stdio::null())
            .output();
        Ok(match run {
            Err(e) => Err(e.to_string()),
            Ok(done) if !done.status.success() => {
                let said = String::from_utf8_lossy(&done.stderr);
                Err(said.lines().last().unwrap_or_default().to_owned())
            }
            Ok(done) => serde_json::from_slice(&done.stdout).map_err(|e| e.to_string()),
        })
    }
}
