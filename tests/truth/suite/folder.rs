//! Writes a suite: rides and bikes in one folder, the sealed key outside it.

use std::path::{Path, PathBuf};

use rayon::prelude::*;
use serde_json::{Value, json};

use super::case::Case;
use super::order::{Order, ride_name};
use super::{plan, ride};
use crate::chance::Chance;
use crate::files::{FilesError, create_folder, digest, remove, write, write_whole};

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
