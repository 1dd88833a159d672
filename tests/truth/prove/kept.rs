//! Outcomes, kept ride by ride as they come, so that a proof that was stopped goes on.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::outcome::Outcome;
use crate::suite::files::{self, FilesError};

#[derive(Debug, thiserror::Error)]
pub enum KeptError {
    #[error(
        "{} holds the outcomes of {holds}, but this is {asked}; finish those, or name another folder \
         (--work), or delete this one to begin again", work.display()
    )]
    Other { work: PathBuf, holds: Of, asked: Of },
    #[error(transparent)]
    Files(#[from] FilesError),
}

/// Whose outcomes a work folder holds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Of {
    pub seed: u64,
    pub binary_sha256: String,
}

impl std::fmt::Display for Of {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        let short = self.binary_sha256.get(..12);
        let sha256 = short.unwrap_or(&self.binary_sha256);
        write!(f, "seed {} and a binary of SHA-256 {sha256}..", self.seed)
    }
}

/// The outcomes of one section in a work folder: one file per ride.
pub struct Kept {
    folder: PathBuf,
}

#[derive(Serialize, Deserialize)]
struct Entry {
    /// Of the ride and its bicycle; another ride of that name has no outcome yet.
    ride_sha256: String,
    outcome: Outcome,
}

impl Kept {
    /// Refuses a folder that holds outcomes of another binary or seed.
    pub fn open(work: &Path, section: &str, of: &Of) -> Result<Self, KeptError> {
        let folder = work.join(format!("{section}_kept"));
        files::create_folder(&folder)?;
        let path = work.join("kept_of.json");
        match found(&path)? {
            Some(holds) if holds != *of => Err(KeptError::Other {
                work: work.to_owned(),
                holds,
                asked: of.clone(),
            }),
            Some(_) => Ok(Self { folder }),
            None => {
                files::write_whole(&path, &serde_json::json!(of).to_string())?;
                Ok(Self { folder })
            }
        }
    }

    /// The outcome of a ride of that name and content.
    pub fn get(&self, name: &str, ride_sha256: &str) -> Result<Option<Outcome>, FilesError> {
        let entry: Option<Entry> = found(&self.path(name))?;
        let same = entry.filter(|entry| entry.ride_sha256 == ride_sha256);
        Ok(same.map(|entry| entry.outcome))
    }

    pub fn keep(&self, name: &str, ride_sha256: &str, of: &Outcome) -> Result<(), FilesError> {
        let entry = Entry {
            ride_sha256: ride_sha256.to_owned(),
            outcome: of.clone(),
        };
        let text = serde_json::json!(entry).to_string();
        files::write_whole(&self.path(name), &text)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.join(format!("ride_{name}.json"))
    }
}

/// Nothing where the file is missing, or broken as by a machine that lost power.
fn found<T: for<'a> Deserialize<'a>>(path: &Path) -> Result<Option<T>, FilesError> {
    match files::read(path) {
        Ok(text) => Ok(serde_json::from_str(&text).ok()),
        Err(FilesError::Read { source, .. }) if source.kind() == ErrorKind::NotFound => Ok(None),
        Err(error) => Err(error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(seed: u64, binary: &str) -> Of {
        Of {
            seed,
            binary_sha256: binary.to_owned(),
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
        assert_eq!(kept.get("001", "cafe").expect("read"), None);
        kept.keep("001", "cafe", &outcome).expect("kept");
        let again = Kept::open(&work, "standard", &of(7, "beef")).expect("opened");
        assert_eq!(again.get("001", "cafe").expect("read"), Some(outcome));
        assert_eq!(again.get("001", "f00d").expect("read"), None);
        let other = Kept::open(&work, "clean300", &of(7, "beef")).expect("opened");
        assert_eq!(other.get("001", "cafe").expect("read"), None);
        let broken = work.join("standard_kept/ride_001.json");
        files::write(&broken, "{\"ride_sha").expect("written");
        assert_eq!(again.get("001", "cafe").expect("read"), None);
        std::fs::remove_dir_all(&work).expect("removed");
    }

    #[test]
    fn outcomes_of_another_binary_or_seed_are_not_mixed_in() {
        let work = std::env::temp_dir().join(format!("veloid-mixed-{}", std::process::id()));
        Kept::open(&work, "standard", &of(7, "beef")).expect("opened");
        for other in [of(8, "beef"), of(7, "f00d")] {
            let refused = Kept::open(&work, "clean300", &other)
                .err()
                .expect("refused");
            let said = refused.to_string();
            assert!(said.contains("seed 7") && said.contains("--work"), "{said}");
        }
        std::fs::remove_dir_all(&work).expect("removed");
    }
}
