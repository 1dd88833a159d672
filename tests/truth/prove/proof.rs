//! One proof from start to finish.

use std::path::{Path, PathBuf};
use std::time::Instant;

use serde_json::{Value, json};

use super::origin::{self, Origin, OriginError};
use super::outcome::Outcome;
use super::score::{Case, Scored, score};
use super::{document, run, tables};
use crate::baselines;
use crate::refit::known::{self, Known, KnownError};
use crate::suite::files::{self, FilesError, Order};

#[derive(Debug, thiserror::Error)]
pub enum ProveError {
    #[error(transparent)]
    Files(#[from] FilesError),
    #[error(transparent)]
    Known(#[from] KnownError),
    #[error(transparent)]
    Origin(#[from] OriginError),
    #[error("seed {0} was used before; a blind run needs one that was not")]
    Used(u64),
    #[error("short of what was demanded, by more than so few rides make likely:\n{}\n{text}", rows.join("\n"))]
    Short { rows: Vec<String>, text: String },
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
    /// Where the binary comes from, for the document.
    pub origin: Option<Origin>,
    /// A row fails that falls so far short of its demand that it would do so by chance with less than this.
    pub doubt: Option<f64>,
}

impl Proof {
    /// Makes rides, runs the binary, opens the key, scores; returns the tables as Markdown.
    pub fn run(&self) -> Result<String, ProveError> {
        let digest = self.make()?;
        self.judge(&digest)
    }

    /// Makes rides and key; where a document is to be written, the key has to be sealed.
    pub fn make(&self) -> Result<String, ProveError> {
        let digest = files::make(&self.work.join(self.order.name()), &self.order)?;
        println!("SHA-256 of the sealed key: {digest}");
        if let Some(docs) = &self.docs {
            origin::sealed(Path::new("."), docs, &digest)?;
        }
        Ok(digest)
    }

    /// Runs the binary on the rides that were made, opens the key, scores.
    pub fn judge(&self, digest: &str) -> Result<String, ProveError> {
        let suite = self.order.name();
        let folder = self.work.join(suite);
        let begun = Instant::now();
        let stage = |what: &str| eprintln!("{what} after {:.0} s", begun.elapsed().as_secs_f64());
        let reports = self.work.join(format!("{suite}_reports"));
        files::create_folder(&reports)?;
        let names: Vec<String> = self
            .order
            .cases()
            .iter()
            .map(|(number, _)| format!("{:03}", number + 1))
            .collect();
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
        let text = document::section(&self.order, digest, &ours, &others, self.origin.as_ref());
        if let Some(docs) = &self.docs {
            document::insert(docs, suite, &text)?;
        }
        let rows = self
            .doubt
            .map(|doubt| tables::short(&ours, self.order.clean300, doubt));
        match rows {
            Some(rows) if !rows.is_empty() => Err(ProveError::Short { rows, text }),
            _ => Ok(text),
        }
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
