//! Writes a suite: rides and bikes in one folder, the sealed key outside it.

use std::fs;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use rayon::prelude::*;
use serde_json::{Value, json};
use sha2::{Digest, Sha256};

use super::case::{Case, Suite};
use super::{plan, ride};
use crate::chance::Chance;

#[derive(Debug, thiserror::Error)]
pub enum FilesError {
    #[error("cannot write {path}: {source}")]
    Write {
        path: PathBuf,
        source: std::io::Error,
    },
    #[error("cannot read {path}: {source}")]
    Read {
        path: PathBuf,
        source: std::io::Error,
    },
    #[error("{path} is not JSON: {source}")]
    Parse {
        path: PathBuf,
        source: serde_json::Error,
    },
    #[error("{0} has no folder beside which the key could be kept")]
    NoParent(PathBuf),
}

/// Which rides to make.
#[derive(Clone, Copy, Debug)]
pub struct Order {
    pub seed: u64,
    /// Every n-th ride of the plan; 1 for all.
    pub one_in: usize,
    /// At most so many.
    pub count: usize,
    pub suite: Suite,
}

impl Order {
    /// Names of the rides, as their files have them.
    pub fn names(&self) -> Vec<String> {
        let cases = self.cases();
        cases.iter().map(|(number, _)| ride_name(*number)).collect()
    }

    /// The planned rides with their numbers. A sample keeps the numbers, and so the bytes, of the whole suite.
    pub fn cases(&self) -> Vec<(u64, Case)> {
        let chance = &mut Chance::new(self.seed, 0);
        let numbered = self
            .suite
            .cases(chance)
            .into_iter()
            .enumerate()
            .map(|(i, c)| (i as u64, c));
        numbered.step_by(self.one_in).take(self.count).collect()
    }

    pub fn name(&self) -> &'static str {
        self.suite.name()
    }
}

fn ride_name(number: u64) -> String {
    format!("{:03}", number + 1)
}

/// Where the key of the rides in `folder` is kept.
pub fn key_path(folder: &Path) -> Result<PathBuf, FilesError> {
    let name = folder
        .file_name()
        .ok_or_else(|| FilesError::NoParent(folder.to_owned()))?;
    Ok(folder.with_file_name(format!("{}_key.json", name.to_string_lossy())))
}

/// Makes the rides in `folder`, the key beside it, and returns the key's SHA-256.
pub fn make(folder: &Path, order: &Order) -> Result<String, FilesError> {
    create_folder(folder)?;
    // A key that is there says that all of its rides are.
    remove(&key_path(folder)?)?;
    let truths: Vec<Value> = order
        .cases()
        .par_iter()
        .map(|(number, case)| write_ride(folder, case, &ride_name(*number), order.seed, *number))
        .collect::<Result<_, FilesError>>()?;
    let key = format!(
        "{:#}\n",
        json!({"suite": order.name(), "seed": order.seed, "rides": truths})
    );
    write_whole(&key_path(folder)?, &key)?;
    Ok(digest(&key))
}

/// Writes the ride and the bike, returns the truth.
fn write_ride(
    folder: &Path,
    case: &Case,
    name: &str,
    seed: u64,
    number: u64,
) -> Result<Value, FilesError> {
    let made = ride::make(case, name, seed, number);
    write(&folder.join(format!("ride_{name}.csv")), &made.log.to_csv())?;
    write(
        &folder.join(format!("bike_{name}.json")),
        &format!("{:#}\n", made.bike_file),
    )?;
    Ok(made.truth)
}

/// Makes the rides on which time is measured; returns their names, classes and durations (s).
pub fn make_timing(
    folder: &Path,
    seed: u64,
) -> Result<Vec<(String, &'static str, f64)>, FilesError> {
    create_folder(folder)?;
    plan::timing(&mut Chance::new(seed, 0))
        .par_iter()
        .enumerate()
        .map(|(i, case)| {
            let name = format!("time_{:03}", i + 1);
            write_ride(folder, case, &name, seed, 1_000_000 + i as u64)?;
            Ok((name, case.class.name(), case.duration_s))
        })
        .collect()
}

/// SHA-256 in hexadecimal.
pub fn digest(bytes: impl AsRef<[u8]>) -> String {
    let sum = Sha256::digest(bytes);
    sum.iter().map(|byte| format!("{byte:02x}")).collect()
}

pub fn create_folder(path: &Path) -> Result<(), FilesError> {
    fs::create_dir_all(path).map_err(|source| FilesError::Write {
        path: path.to_owned(),
        source,
    })
}

pub fn write(path: &Path, text: &str) -> Result<(), FilesError> {
    fs::write(path, text).map_err(|source| FilesError::Write {
        path: path.to_owned(),
        source,
    })
}

/// The whole text or what was there before, whenever the process is killed.
pub fn write_whole(path: &Path, text: &str) -> Result<(), FilesError> {
    let mut part = path.as_os_str().to_owned();
    part.push(format!(".{}.part", std::process::id()));
    let written = fs::File::create(&part).and_then(|mut file| {
        file.write_all(text.as_bytes())?;
        file.sync_all()?;
        fs::rename(&part, path)
    });
    written.map_err(|source| FilesError::Write {
        path: path.to_owned(),
        source,
    })
}

/// Removes a file, if it is there.
fn remove(path: &Path) -> Result<(), FilesError> {
    match fs::remove_file(path) {
        Err(source) if source.kind() != ErrorKind::NotFound => Err(FilesError::Write {
            path: path.to_owned(),
            source,
        }),
        _ => Ok(()),
    }
}

pub fn read(path: &Path) -> Result<String, FilesError> {
    fs::read_to_string(path).map_err(|source| FilesError::Read {
        path: path.to_owned(),
        source,
    })
}

pub fn read_bytes(path: &Path) -> Result<Vec<u8>, FilesError> {
    fs::read(path).map_err(|source| FilesError::Read {
        path: path.to_owned(),
        source,
    })
}

pub fn read_json(path: &Path) -> Result<Value, FilesError> {
    serde_json::from_str(&read(path)?).map_err(|source| FilesError::Parse {
        path: path.to_owned(),
        source,
    })
}
