//! Runs a binary on every ride as a user would.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use rayon::prelude::*;

use super::outcome::Outcome;
use crate::suite::files;

/// Identifies the rides of `folder`, as many at once as rayon has threads; outcomes in the order of `names`.
pub fn all(binary: &Path, folder: &Path, reports: &Path, names: &[String]) -> Vec<Outcome> {
    let done = AtomicUsize::new(0);
    names
        .par_iter()
        .map(|name| {
            let outcome = one(binary, folder, reports, name);
            let count = done.fetch_add(1, Ordering::Relaxed) + 1;
            eprintln!(
                "{count}/{} ride {name}: {} in {:.1} s",
                names.len(),
                outcome.verdict,
                outcome.seconds
            );
            outcome
        })
        .collect()
}

/// `BINARY identify RIDE --bike BIKE --json OUT`.
pub fn one(binary: &Path, folder: &Path, reports: &Path, name: &str) -> Outcome {
    let out: PathBuf = reports.join(format!("report_{name}.json"));
    let begun = Instant::now();
    let run = Command::new(binary)
        .arg("identify")
        .arg(folder.join(format!("ride_{name}.csv")))
        .arg("--bike")
        .arg(folder.join(format!("bike_{name}.json")))
        .arg("--json")
        .arg(&out)
        .stdin(Stdio::null())
        .output();
    let seconds = begun.elapsed().as_secs_f64();
    match run {
        Err(e) => Outcome::failed(format!("{}: {e}", binary.display()), seconds),
        Ok(done) if !done.status.success() => {
            let said = String::from_utf8_lossy(&done.stderr);
            Outcome::failed(
                format!(
                    "{}: {}",
                    done.status,
                    said.lines().last().unwrap_or_default()
                ),
                seconds,
            )
        }
        Ok(_) => match files::read_json(&out) {
            Ok(report) => Outcome::read(&report, seconds),
            Err(e) => Outcome::failed(e.to_string(), seconds),
        },
    }
}
