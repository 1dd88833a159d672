//! Outcomes, kept ride by ride as they come, so that a proof that was stopped goes on.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::rebuilt;
use crate::files::{self, FilesError};

#[derive(Debug, thiserror::Error)]
pub enum KeptError {
    #[error(
        "{} holds the outcomes of seed {holds}, but this is seed {asked}; finish those, or name another folder \
         (--work), or delete this one to begin again", work.display()
    )]
    Seed {
        work: PathBuf,
        holds: u64,
        asked: u64,
    },
    #[error(
        "{} holds the outcomes of another binary, which reported otherwise of {ride}; go on with that one, or name another \
         folder (--work), or delete this one to begin again", work.display()
    )]
    Binary { work: PathBuf, ride: String },
    #[error(transparent)]
    Files(#[from] FilesError),
}

/// Whose outcomes a work folder holds: of one seed, and of binaries that report the same.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Of {
    seed: u64,
    #[serde(default)]
    binaries_sha256: Vec<String>,
}

/// Who asks for outcomes.
#[derive(Clone, Copy, Debug)]
pub struct Asked<'a> {
    pub seed: u64,
    pub binary: &'a Path,
    pub sha256: &'a str,
}

/// The outcomes of one section in a work folder: one file per ride.
pub struct Kept {
    folder: PathBuf,
}

#[derive(Serialize, Deserialize)]
struct Entry<T> {
    /// Of the ride and its bicycle; another ride of that name has no outcome yet.
    ride_sha256: String,
    outcome: T,
}

impl Kept {
    /// Refuses a folder that holds outcomes of another seed, or of a binary whose reports this one does not reproduce.
    pub fn open(work: &Path, section: &str, asked: &Asked) -> Result<Self, KeptError> {
        let folder = work.join(format!("{section}_kept"));
        files::create_folder(&folder)?;
        let path = work.join("kept_of.json");
        let mut of = found(&path)?.unwrap_or_else(|| Of {
            seed: asked.seed,
            binaries_sha256: Vec::new(),
        });
        if of.seed != asked.seed {
            return Err(KeptError::Seed {
                work: work.to_owned(),
                holds: of.seed,
                asked: asked.seed,
            });
        }
        let known = &mut of.binaries_sha256;
        if !known.iter().any(|sha256| sha256 == asked.sha256) {
            if let Some(ride) = rebuilt::differs(asked.binary, asked.sha256, work)? {
                let work = work.to_owned();
                return Err(KeptError::Binary { work, ride });
            }
            known.push(asked.sha256.to_owned());
            files::write_whole(&path, &serde_json::json!(of).to_string())?;
        }
        Ok(Self { folder })
    }

    /// The outcome of a ride of that name and content.
    pub fn get<T: DeserializeOwned>(
        &self,
        name: &str,
        ride_sha256: &str,
    ) -> Result<Option<T>, FilesError> {
        let entry: Option<Entry<T>> = found(&self.path(name))?;
        let same = entry.filter(|entry| entry.ride_sha256 == ride_sha256);
        Ok(same.map(|entry| entry.outcome))
    }

    pub fn keep<T: Serialize>(
        &self,
        name: &str,
        ride_sha256: &str,
        outcome: T,
    ) -> Result<(), FilesError> {
        let entry = Entry {
            ride_sha256: ride_sha256.to_owned(),
            outcome,
        };
        let text = serde_json::json!(entry).to_string();
        files::write_whole(&self.path(name), &text)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.join(format!("ride_{name}.json"))
    }
}

/// Nothing where the file is missing, or broken as by a machine that lost power.
fn found<T: DeserializeOwned>(path: &Path) -> Result<Option<T>, FilesError> {
    match files::read(path) {
        Ok(text) => Ok(serde_json::from_str(&text).ok()),
        Err(FilesError::Read { source, .. }) if source.kind() == ErrorKind::NotFound => Ok(None),
        Err(error) => Err(error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outcome::Outcome;

    fn of(seed: u64, sha256: &str) -> Asked<'_> {
        Asked {
            seed,
            binary: Path::new("no binary"),
            sha256,
        }
    }

    #[test]
    fn an_outcome_is_there_again_for_the_same_ride_alone() {
        let work = std::env::temp_dir().join(format!("veloid-kept-{}", std::process::id()));
        let kept = Kept::open(&work, "standard", &of(7, "beef")).expect("opened");
        let outcome = Outcome {
            seconds: 0.1 + 0.2,
            stiffness: [Some((1e5, None)), None],
            ..Outcome::named(vec![("hysteresis".to_owned(), "front".to_owned())])
        };
        assert_eq!(kept.get("001", "cafe").expect("read"), None::<Outcome>);
        kept.keep("001", "cafe", &outcome).expect("kept");
        let again = Kept::open(&work, "standard", &of(7, "beef")).expect("opened");
        assert_eq!(again.get("001", "cafe").expect("read"), Some(outcome));
        assert_eq!(again.get("001", "f00d").expect("read"), None::<Outcome>);
        let other = Kept::open(&work, "clean300", &of(7, "beef")).expect("opened");
        assert_eq!(other.get("001", "cafe").expect("read"), None::<Outcome>);
        let broken = work.join("standard_kept/ride_001.json");
        files::write(&broken, "{\"ride_sha").expect("written");
        assert_eq!(again.get("001", "cafe").expect("read"), None::<Outcome>);
        std::fs::remove_dir_all(&work).expect("removed");
    }

    #[test]
    fn outcomes_of_another_seed_or_of_a_binary_that_says_otherwise_are_not_mixed_in() {
        let work = std::env::temp_dir().join(format!("veloid-mixed-{}", std::process::id()));
        let refused = |asked: Asked| {
            let refused = Kept::open(&work, "clean300", &asked).err();
            let said = refused.expect("refused").to_string();
            assert!(said.contains("--work"), "{said}");
            said
        };
        Kept::open(&work, "standard", &of(7, "beef")).expect("opened");
        assert!(refused(of(8, "beef")).contains("seed 7"));
        Kept::open(&work, "standard", &of(7, "f00d")).expect("nothing is in yet");
        for folder in ["standard", "standard_reports"] {
            files::create_folder(&work.join(folder)).expect("a folder");
        }
        files::write(&work.join("standard/ride_001.csv"), "t").expect("written");
        files::write(&work.join("standard_reports/report_001.json"), "{}").expect("written");
        assert!(refused(of(7, "cafe")).contains("standard 001"));
        Kept::open(&work, "standard", &of(7, "beef")).expect("one that is known");
        std::fs::remove_dir_all(&work).expect("removed");
    }
}
