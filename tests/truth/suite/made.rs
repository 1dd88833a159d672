//! Rides are made once and taken as they are when the same program asks for the same ones again.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::folder;
use super::order::Order;
use crate::files::{self, FilesError};

/// What was asked for, of which program, and what came of it.
#[derive(PartialEq, Serialize, Deserialize)]
struct Stamp {
    seed: u64,
    one_in: usize,
    count: usize,
    /// SHA-256 of the program that made them, which may make others once it is changed.
    maker_sha256: String,
    key_sha256: String,
}

/// Makes the rides in `folder` unless they are there; returns the key's SHA-256.
pub fn once(folder: &Path, order: &Order) -> Result<String, FilesError> {
    let stamp = |key_sha256: String, maker_sha256: &str| Stamp {
        seed: order.seed,
        one_in: order.one_in,
        count: order.count,
        maker_sha256: maker_sha256.to_owned(),
        key_sha256,
    };
    let Some(maker) = this_program() else {
        return folder::make(folder, order);
    };
    let key = folder::key_path(folder)?;
    let path = key.with_file_name(format!("{}_made.json", order.name()));
    if let (Some(made), Ok(key)) = (stamped(&path), files::read_bytes(&key)) {
        let digest = files::digest(key);
        if made == stamp(digest.clone(), &maker) {
            return Ok(digest);
        }
    }
    let digest = folder::make(folder, order)?;
    let text = serde_json::json!(stamp(digest.clone(), &maker)).to_string();
    files::write_whole(&path, &text)?;
    Ok(digest)
}

/// SHA-256 of the program that runs.
pub fn this_program() -> Option<String> {
    let path = std::env::current_exe().ok()?;
    files::read_bytes(&path).ok().map(files::digest)
}

fn stamped(path: &Path) -> Option<Stamp> {
    serde_json::from_str(&files::read(path).ok()?).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::suite::order::Suite;

    #[test]
    fn rides_are_made_again_only_when_others_are_asked_for() {
        let work = std::env::temp_dir().join(format!("veloid-made-{}", std::process::id()));
        let folder = work.join("clean300");
        let order = |seed| Order {
            seed,
            one_in: 1,
            count: 1,
            suite: Suite::Clean300,
        };
        let ride = folder.join("ride_001.csv");
        let first = once(&folder, &order(5)).expect("made");
        files::write(&ride, "as it was left").expect("written");
        assert_eq!(once(&folder, &order(5)).expect("made"), first);
        assert_eq!(files::read(&ride).expect("there"), "as it was left");
        let other = once(&folder, &order(6)).expect("made");
        assert_ne!(other, first);
        assert_ne!(files::read(&ride).expect("there"), "as it was left");
        std::fs::remove_file(work.join("clean300_key.json")).expect("removed");
        files::write(&ride, "half a ri").expect("written");
        assert_eq!(once(&folder, &order(6)).expect("made"), other);
        assert_ne!(files::read(&ride).expect("there"), "half a ri");
        std::fs::remove_dir_all(&work).expect("removed");
    }
}
