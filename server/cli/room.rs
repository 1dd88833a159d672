//! Free space on the disks of database and files.

use std::error::Error;
use std::iter::successors;
use std::path::Path;

use rustix::fs::statvfs;

use super::CliError;

/// A disk with less room is full: a database's journal and its index take some hundred kB (bytes).
const LEAST: u64 = 1 << 20;

/// The error or, where it may come of a full disk below one of these folders, that.
pub fn blame(error: CliError, folders: &[&Path]) -> CliError {
    let full = folders.iter().find_map(|folder| {
        let bytes = free(folder).filter(|bytes| *bytes < LEAST)?;
        Some((folder.to_path_buf(), bytes))
    });
    match full.filter(|_| is_of_storage(&error)) {
        Some((path, bytes)) => CliError::Full {
            path,
            bytes,
            source: Box::new(error),
        },
        None => error,
    }
}

/// Free space where a folder is, or is to be made (bytes).
fn free(folder: &Path) -> Option<u64> {
    let found = folder.ancestors().find_map(|folder| statvfs(folder).ok())?;
    Some(found.f_bavail.saturating_mul(found.f_frsize))
}

/// Whether an error comes from a file or the database.
fn is_of_storage(error: &CliError) -> bool {
    let mut causes = successors(error.source(), |&error| error.source());
    causes.any(|cause| cause.is::<std::io::Error>() || cause.is::<sqlx::Error>())
}
