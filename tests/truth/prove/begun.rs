//! The table of sealed runs in docs/proof.md: a row is there from the moment a run begins, and stays.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::document;
use super::origin::{Origin, OriginError};
use super::seal::Seal;
use crate::files::{self, FilesError};

const HEAD: &str = "## Sealed runs\n\n\
| run | seed | suite | trees | nonce | commit | binary's SHA-256 | begun | rides | state |\n\
|---|---|---|---|---|---|---|---|---|---|\n";
const CELLS: usize = 10;
const MARK: &str = "begun";

#[derive(Debug, thiserror::Error)]
pub enum BegunError {
    #[error(transparent)]
    Origin(#[from] OriginError),
    #[error(transparent)]
    Files(#[from] FilesError),
}

/// A document, and what is about to be run for it.
#[derive(Clone, Debug)]
pub struct Register {
    pub docs: PathBuf,
    pub work: PathBuf,
    pub seal: Seal,
    pub origin: Origin,
}

/// One listed run of a suite.
#[derive(Clone, Debug, PartialEq)]
struct Row([String; CELLS]);

/// Which row a work folder belongs to.
#[derive(PartialEq, Serialize, Deserialize)]
struct Stamp {
    seed: u64,
    run: usize,
}

/// A run that is listed.
pub struct Begun<'a> {
    register: &'a Register,
    suite: String,
    run: usize,
    is_repeat: bool,
}

impl Register {
    /// Lists the run before its first ride, or finds the row of the one that this work folder goes on with.
    pub fn begin(&self, suite: &str, planned: usize) -> Result<Begun<'_>, BegunError> {
        let mut rows = rows(&files::read(&self.docs)?);
        let run = match self.found(suite, &rows) {
            Some(run) => run,
            None => {
                let is_repeat = rows.iter().any(|row| self.is_ours(row, suite));
                rows.push(self.row(rows.len() + 1, suite, planned, is_repeat)?);
                rows.len()
            }
        };
        let row = &mut rows[run - 1];
        row.add_binary(self.origin.sha256());
        let is_repeat = row.state().starts_with("repeat");
        document::insert(&self.docs, MARK, &table(&rows))?;
        files::create_folder(&self.work)?;
        let seed = self.seal.seed;
        files::write_whole(
            &self.stamp(suite),
            &serde_json::json!(Stamp { seed, run }).to_string(),
        )?;
        Ok(Begun {
            register: self,
            suite: suite.to_owned(),
            run,
            is_repeat,
        })
    }

    /// Whether the run of this work folder has all rides of a suite in the document.
    pub fn is_whole(&self, suite: &str) -> Result<bool, FilesError> {
        let rows = rows(&files::read(&self.docs)?);
        let row = self.found(suite, &rows).and_then(|run| rows.get(run - 1));
        Ok(row.is_some_and(|row| row.state().ends_with("whole")))
    }

    /// The run that this work folder has begun.
    fn found(&self, suite: &str, rows: &[Row]) -> Option<usize> {
        let stamp = files::read_json(&self.stamp(suite)).ok()?;
        let stamp: Stamp = serde_json::from_value(stamp).ok()?;
        let row = rows.get(stamp.run.checked_sub(1)?)?;
        (stamp.seed == self.seal.seed && self.is_ours(row, suite)).then_some(stamp.run)
    }

    fn is_ours(&self, row: &Row, suite: &str) -> bool {
        row.seed() == self.seal.seed.to_string() && row.suite() == suite
    }

    fn stamp(&self, suite: &str) -> PathBuf {
        self.work.join(format!("{suite}_begun.json"))
    }

    fn row(&self, run: usize, suite: &str, of: usize, repeat: bool) -> Result<Row, OriginError> {
        let state = if repeat { "repeat, begun" } else { "begun" };
        Ok(Row([
            run.to_string(),
            self.seal.seed.to_string(),
            suite.to_owned(),
            self.seal.trees(),
            self.seal.nonce(),
            self.origin.commit().to_owned(),
            String::new(),
            super::origin::today()?,
            document::of(0, of),
            state.to_owned(),
        ]))
    }
}

impl Begun<'_> {
    /// Notes how many rides are in, and shows the section unless an earlier run of the same code and nonce counts.
    pub fn write(&self, text: &str, rides: usize, planned: usize) -> Result<(), BegunError> {
        let docs = &self.register.docs;
        let mut rows = rows(&files::read(docs)?);
        if let Some(row) = rows.get_mut(self.run - 1) {
            row.0[8] = document::of(rides, planned);
            if rides == planned {
                row.0[9] = row.0[9].replace("begun", "whole");
            }
        }
        document::insert(docs, MARK, &table(&rows))?;
        if !self.is_repeat {
            document::insert(docs, &self.suite, text)?;
        }
        Ok(())
    }
}

impl Row {
    fn seed(&self) -> &str {
        &self.0[1]
    }

    fn suite(&self) -> &str {
        &self.0[2]
    }

    fn state(&self) -> &str {
        &self.0[9]
    }

    /// A part may be run by a rebuild that says the same.
    fn add_binary(&mut self, sha256: &str) {
        let all = &mut self.0[6];
        if !all.contains(sha256) {
            *all += if all.is_empty() { "" } else { ", " };
            *all += sha256;
        }
    }
}

fn rows(document: &str) -> Vec<Row> {
    let section = document::section_of(document, MARK).unwrap_or_default();
    let row = |line: &str| {
        let inner = line.strip_prefix("| ")?.strip_suffix(" |")?;
        let cells: Vec<String> = inner.split(" | ").map(str::to_owned).collect();
        let is_run = cells[0].parse::<usize>().is_ok();
        cells.try_into().ok().filter(|_| is_run).map(Row)
    };
    section.lines().filter_map(row).collect()
}

fn table(rows: &[Row]) -> String {
    let line = |row: &Row| format!("| {} |\n", row.0.join(" | "));
    HEAD.to_owned() + &rows.iter().map(line).collect::<String>()
}

/// The seeds of the table in a document.
pub fn seeds(docs: &Path) -> Result<Vec<u64>, FilesError> {
    let rows = rows(&files::read(docs)?);
    Ok(rows
        .iter()
        .filter_map(|row| row.seed().parse().ok())
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Folder(PathBuf);

    impl Drop for Folder {
        fn drop(&mut self) {
            let _ = std::fs::remove_dir_all(&self.0);
        }
    }

    fn folder(name: &str) -> Folder {
        let path = std::env::temp_dir().join(format!("veloid-{name}-{}", std::process::id()));
        files::create_folder(&path).expect("a folder");
        files::write(&path.join("proof.md"), "# Proof\n").expect("written");
        Folder(path)
    }

    fn register(folder: &Folder, work: &str, binary: &str) -> Register {
        Register {
            docs: folder.0.join("proof.md"),
            work: folder.0.join(work),
            seal: Seal::from_parts(["a", "b", "c", "d"], "0123456789"),
            origin: Origin::given("cafe", binary),
        }
    }

    #[test]
    fn a_run_is_listed_from_its_begin_and_an_aborted_one_stays() {
        let folder = folder("begun");
        let docs = || files::read(&folder.0.join("proof.md")).expect("read");
        let first = register(&folder, "work", "beef");
        first.begin("standard", 9).expect("begun");
        assert!(docs().contains("| beef |") && docs().contains("| 0 of 9 | begun |"));
        first
            .begin("standard", 9)
            .expect("goes on")
            .write("half", 4, 9)
            .expect("written");
        assert!(docs().contains("| 4 of 9 | begun |") && docs().contains("half"));
        let rebuilt = register(&folder, "work", "f00d");
        rebuilt
            .begin("standard", 9)
            .expect("goes on")
            .write("all", 9, 9)
            .expect("written");
        assert!(docs().contains("| beef, f00d |") && docs().contains("| 9 of 9 | whole |"));
        assert_eq!(rows(&docs()).len(), 1);
        assert_eq!(seeds(&first.docs).expect("read"), [first.seal.seed]);
    }

    #[test]
    fn a_second_run_from_scratch_is_a_repeat_and_shows_nothing() {
        let folder = folder("repeat");
        let docs = || files::read(&folder.0.join("proof.md")).expect("read");
        let run = |work: &str, suite: &str, text: &str| {
            let register = register(&folder, work, "beef");
            let begun = register.begin(suite, 9).expect("begun");
            begun.write(text, 9, 9).expect("written");
        };
        run("one", "standard", "the first");
        run("two", "standard", "the second");
        run("two", "clean300", "another suite");
        let text = docs();
        assert!(text.contains("| 9 of 9 | repeat, whole |"), "{text}");
        assert!(text.contains("the first") && text.contains("another suite"));
        assert!(!text.contains("the second"));
        assert_eq!(rows(&text).len(), 3);
    }
}
