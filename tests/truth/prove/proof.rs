//! One proof from start to finish.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use serde_json::{Value, json};

use super::document::Timed;
use super::outcome::Outcome;
use super::score::{Case, Mark, Scored, score};
use super::{document, run};
use crate::baselines;
use crate::refit::known::{self, Known, KnownError};
use crate::suite::files::{self, FilesError, Order};

#[derive(Debug, thiserror::Error)]
pub enum ProveError {
    #[error(transparent)]
    Files(#[from] FilesError),
    #[error(transparent)]
    Known(#[from] KnownError),
    #[error("the key's SHA-256 is {made}, but {committed} was committed")]
    Commitment { made: String, committed: String },
    #[error(
        "{right} of {of} judged rides are right, {percent:.1} %; at least {least} % were demanded\n{text}"
    )]
    Short {
        right: usize,
        of: usize,
        percent: f64,
        least: usize,
        text: String,
    },
    #[error("cannot write JSON: {0}")]
    Json(#[from] serde_json::Error),
}

/// What to prove, with which binary, and where things go.
pub struct Proof {
    pub binary: PathBuf,
    pub order: Order,
    /// Rides are made in `work/<suite>`, the key and the outcomes beside it.
    pub work: PathBuf,
    pub docs: Option<PathBuf>,
    /// SHA-256 of the key that was committed before the run.
    pub committed: Option<String>,
    /// Percentage of the clean rides and of those that show what they conceal that must be right.
    pub least_right: usize,
}

impl Proof {
    /// Makes rides, runs the binary, opens the key, scores; returns the tables as Markdown.
    pub fn run(&self) -> Result<String, ProveError> {
        let suite = self.order.name();
        let folder = self.work.join(suite);
        let begun = Instant::now();
        let stage = |what: &str| eprintln!("{what} after {:.0} s", begun.elapsed().as_secs_f64());
        let digest = files::make(&folder, &self.order)?;
        println!("SHA-256 of the sealed key: {digest}");
        if let Some(committed) = self.committed.as_ref().filter(|c| **c != digest) {
            return Err(ProveError::Commitment {
                made: digest,
                committed: committed.clone(),
            });
        }
        stage("rides made");
        let reports = self.work.join(format!("{suite}_reports"));
        fs::create_dir_all(&reports).map_err(|source| FilesError::Write {
            path: reports.clone(),
            source,
        })?;
        let names: Vec<String> = self
            .order
            .cases()
            .iter()
            .map(|(number, _)| format!("{:03}", number + 1))
            .collect();
        let timing = self.timing(&reports)?;
        let outcomes = run::all(&self.binary, &folder, &reports, &names);
        stage("binary run");
        let baselines = baselines::all(&folder, &names)?;
        stage("baselines run");

        let key = files::read_json(&files::key_path(&folder)?)?;
        let known = if self.order.clean300 {
            Vec::new()
        } else {
            known::all(&folder, &key)?
        };
        stage("truth refitted");
        let scored = |outcomes: &[Outcome]| scored(&key, &known, outcomes);
        let ours = scored(&outcomes);
        let others: Vec<(&str, Vec<Scored>)> = baselines
            .iter()
            .map(|(name, o)| (*name, scored(o)))
            .collect();
        let record = json!({"key_sha256": digest, "veloid": ours, "known": known,
                            "baselines": others.iter().map(|(n, s)| json!({"name": n, "rides": s})).collect::<Vec<_>>()});
        files::write(
            &self.work.join(format!("{suite}_outcomes.json")),
            &serde_json::to_string(&record)?,
        )?;
        let text = document::section(&self.order, &digest, &ours, &others, &timing);
        if let Some(docs) = &self.docs {
            document::insert(docs, suite, &text)?;
        }
        let judged = || ours.iter().filter(|r| r.class == "clean" || r.shown);
        let right = judged().filter(|r| r.mark == Mark::Right).count();
        let (of, least) = (judged().count(), self.least_right);
        let percent = 100.0 * right as f64 / of.max(1) as f64;
        if percent < least as f64 {
            return Err(ProveError::Short {
                right,
                of,
                percent,
                least,
                text,
            });
        }
        Ok(text)
    }

    /// Wall-clock time of the binary, alone on the machine.
    fn timing(&self, reports: &Path) -> Result<Vec<Timed>, FilesError> {
        let folder = self.work.join("timing");
        let rides = files::make_timing(&folder, self.order.seed)?;
        let time = |(name, duration_s): &(String, f64)| Timed {
            duration_s: *duration_s,
            outcome: run::one(&self.binary, &folder, reports, name),
        };
        Ok(rides.iter().map(time).collect())
    }
}

fn scored(key: &Value, known: &[Option<Known>], outcomes: &[Outcome]) -> Vec<Scored> {
    let rides = key["rides"].as_array().cloned().unwrap_or_default();
    rides
        .iter()
        .zip(outcomes)
        .enumerate()
        .map(|(i, (truth, outcome))| {
            score(
                &Case {
                    truth,
                    known: known.get(i).and_then(Option::as_ref),
                },
                outcome,
            )
        })
        .collect()
}
