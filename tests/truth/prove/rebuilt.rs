//! Whether another binary says the same of stored rides as the one that a work folder began with.

use std::path::{Path, PathBuf};

use super::identify;
use crate::files::{self, FilesError};

/// Stored reports that a rebuild has to reproduce.
const COMPARED: usize = 3;

/// A report that is stored, and the ride that it is about.
#[derive(Clone, Debug)]
pub struct Stored {
    rides: PathBuf,
    report: PathBuf,
    name: String,
}

/// The first ride of which the binary reports anything else than what is stored, byte for byte; `None` where all agree.
pub fn differs(binary: &Path, sha256: &str, work: &Path) -> Result<Option<String>, FilesError> {
    for stored in picked(stored(work)?, sha256) {
        let part = stored.report.with_extension("json.again");
        let done = identify::ride(binary, &stored.rides, &stored.name, &part);
        let again = files::read_bytes(&part).ok();
        let _ = std::fs::remove_file(&part);
        let same = done.is_ok_and(|done| done.status.success())
            && again == Some(files::read_bytes(&stored.report)?);
        if !same {
            return Ok(Some(format!("{} {}", stored.rides.display(), stored.name)));
        }
    }
    Ok(None)
}

/// Which, is settled by a hash that includes the binary's, so that nobody chooses.
fn picked(mut all: Vec<Stored>, sha256: &str) -> Vec<Stored> {
    let order = |s: &Stored| {
        let folder = s.rides.file_name().unwrap_or_default().to_string_lossy();
        files::digest(format!("{sha256} {folder} {}", s.name))
    };
    all.sort_by_cached_key(order);
    all.truncate(COMPARED);
    all
}

/// All reports under `work` whose ride is at hand.
fn stored(work: &Path) -> Result<Vec<Stored>, FilesError> {
    let mut all = Vec::new();
    for folder in entries(work)? {
        let rides = match folder.to_string_lossy().strip_suffix("_reports") {
            Some(rides) => PathBuf::from(rides),
            None => folder.clone(),
        };
        if !folder.is_dir() {
            continue;
        }
        for report in entries(&folder)? {
            let name = report.file_name().unwrap_or_default().to_string_lossy();
            let name = name
                .strip_prefix("report_")
                .and_then(|n| n.strip_suffix(".json"));
            let Some(name) = name.map(str::to_owned) else {
                continue;
            };
            if rides.join(format!("ride_{name}.csv")).exists() {
                let rides = rides.clone();
                all.push(Stored {
                    rides,
                    report,
                    name,
                });
            }
        }
    }
    Ok(all)
}

/// What is in a folder.
fn entries(folder: &Path) -> Result<Vec<PathBuf>, FilesError> {
    let read = |source| FilesError::Read {
        path: folder.to_owned(),
        source,
    };
    let found = std::fs::read_dir(folder).map_err(read)?;
    found.map(|entry| Ok(entry.map_err(read)?.path())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reports_are_picked_by_the_hash_of_the_binary() {
        let all: Vec<Stored> = (0..50)
            .map(|i| Stored {
                rides: PathBuf::from("work/standard"),
                report: PathBuf::new(),
                name: format!("{i:03}"),
            })
            .collect();
        let names = |sha256: &str, all: Vec<Stored>| {
            let picked = picked(all, sha256);
            picked.into_iter().map(|s| s.name).collect::<Vec<_>>()
        };
        let first = names("beef", all.clone());
        assert_eq!(first.len(), 3);
        let backwards = all.iter().rev().cloned().collect();
        assert_eq!(names("beef", backwards), first);
        assert_ne!(names("f00d", all), first);
    }
}
