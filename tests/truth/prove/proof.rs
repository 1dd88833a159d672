//! One proof from start to finish.

use std::path::PathBuf;
use std::time::Instant;

use serde_json::{Value, json};

use super::begun::{BegunError, Register};
use super::budget::Budget;
use super::kept::{Asked, Kept, KeptError};
use super::origin::{self, OriginError};
use super::run::Runs;
use super::score::{Case, Scored, score};
use super::{document, tables};
use crate::baselines;
use crate::files::{self, FilesError};
use crate::outcome::Outcome;
use crate::refit::known::{self, Known, KnownError};
use crate::suite::order::Order;
use crate::suite::{folder, made};

#[derive(Debug, thiserror::Error)]
pub enum ProveError {
    #[error(transparent)]
    Files(#[from] FilesError),
    #[error(transparent)]
    Kept(#[from] KeptError),
    #[error(transparent)]
    Known(#[from] KnownError),
    #[error(transparent)]
    Origin(#[from] OriginError),
    #[error(transparent)]
    Begun(#[from] BegunError),
    #[error("short of what was demanded, by more than so few rides make likely:\n{}\n{text}", rows.join("\n"))]
    Short { rows: Vec<String>, text: String },
    #[error("cannot write JSON: {0}")]
    Json(#[from] serde_json::Error),
}

/// What to prove, with which binary, and where things go.
pub struct Proof {
    pub binary: PathBuf,
    pub order: Order,
    /// Rides are made in `work/<suite>`, the key and the outcomes beside it; what is there already is not done again.
    pub work: PathBuf,
    /// Lists the run and shows its tables; none of a seed that somebody chose.
    pub register: Option<Register>,
    pub budget: Budget,
    /// A row fails that falls so far short of its demand that it would do so by chance with less than this.
    pub doubt: Option<f64>,
}

/// Rides and key that are made, and the outcomes that are in.
struct Made {
    digest: String,
    kept: Kept,
}

/// Tables of the rides that are in, as Markdown.
pub struct Shown {
    pub text: String,
    pub rides: usize,
    pub planned: usize,
}

impl Shown {
    pub fn is_whole(&self) -> bool {
        self.rides == self.planned
    }

    /// The text, and how to go on where rides are missing.
    pub fn said(self, section: &str) -> String {
        if self.is_whole() {
            return self.text;
        }
        format!(
            "{}\nThe budget is used: {} rides of `{section}` are in. The same command goes on.\n",
            self.text,
            document::of(self.rides, self.planned)
        )
    }
}

impl Proof {
    /// Makes rides, runs the binary, opens the key, scores.
    pub fn run(&self) -> Result<Shown, ProveError> {
        let made = self.make()?;
        self.judge(&made)
    }

    fn make(&self) -> Result<Made, ProveError> {
        let sha256 = origin::sha256(&self.binary)?;
        let asked = Asked {
            seed: self.order.seed,
            binary: &self.binary,
            sha256: &sha256,
        };
        let kept = Kept::open(&self.work, self.order.name(), &asked)?;
        let digest = made::once(&self.work.join(self.order.name()), &self.order)?;
        eprintln!("SHA-256 of the key: {digest}");
        Ok(Made { digest, kept })
    }

    /// Runs the binary on the rides that were made until the budget is used, opens the key, scores what is in.
    fn judge(&self, made: &Made) -> Result<Shown, ProveError> {
        let suite = self.order.name();
        let planned = self.order.names();
        let listed = match &self.register {
            Some(register) => Some(register.begin(suite, planned.len())?),
            None => None,
        };
        let folder = self.work.join(suite);
        let begun = Instant::now();
        let stage = |what: &str| eprintln!("{what} after {:.0} s", begun.elapsed().as_secs_f64());
        let reports = self.work.join(format!("{suite}_reports"));
        files::create_folder(&reports)?;
        let runs = Runs {
            binary: &self.binary,
            folder: &folder,
            reports: &reports,
            kept: &made.kept,
            budget: self.budget,
        };
        let all = runs.all(&planned)?;
        stage("binary run");
        let key = only(&files::read_json(&folder::key_path(&folder)?)?, &all);
        let names: Vec<String> = planned
            .iter()
            .zip(&all)
            .filter(|(_, outcome)| outcome.is_some())
            .map(|(name, _)| name.clone())
            .collect();
        let outcomes: Vec<Outcome> = all.into_iter().flatten().collect();
        let shown = |text: String| Shown {
            text,
            rides: outcomes.len(),
            planned: planned.len(),
        };
        if outcomes.is_empty() {
            return Ok(shown(String::new()));
        }
        let baselines = baselines::all(&folder, &names)?;
        stage("baselines run");
        let known = if self.order.suite.is_clean() {
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
        let record = json!({"key_sha256": made.digest, "rides": ours.len(), "of": planned.len(),
                            "veloid": ours, "known": known,
                            "baselines": others.iter().map(|(n, s)| json!({"name": n, "rides": s})).collect::<Vec<_>>()});
        files::write_whole(
            &self.work.join(format!("{suite}_outcomes.json")),
            &serde_json::to_string(&record)?,
        )?;
        let origin = self.register.as_ref().map(|register| &register.origin);
        let text = document::section(&self.order, &made.digest, &ours, &others, origin);
        if let Some(listed) = listed {
            listed.write(&text, ours.len(), planned.len())?;
        }
        let rows = self
            .doubt
            .map(|doubt| tables::short(&ours, self.order.suite, doubt));
        match rows {
            Some(rows) if !rows.is_empty() => Err(ProveError::Short { rows, text }),
            _ => Ok(shown(text)),
        }
    }
}

/// The key of the rides that have an outcome.
fn only(key: &Value, outcomes: &[Option<Outcome>]) -> Value {
    let rides = key["rides"].as_array().into_iter().flatten();
    let known = rides.zip(outcomes).filter(|(_, outcome)| outcome.is_some());
    json!({"rides": known.map(|(ride, _)| ride).collect::<Vec<_>>()})
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
