//! The loggers that a lab describes itself: a folder of TOML files, in the order of their names.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use veloid_engine::ride::{Logger, parse_logger};

use super::CliError;

/// Most files of a folder, and bytes of a file.
const MOST_FILES: usize = 256;
const MOST_BYTES: u64 = 64 << 10;

/// The descriptions in a folder.
pub fn of_folder(folder: &Path) -> Result<Arc<[Logger]>, CliError> {
    let entries = std::fs::read_dir(folder).map_err(CliError::of_file(folder))?;
    let paths = entries.map(|entry| entry.map(|entry| entry.path()));
    let paths = paths.collect::<Result<Vec<PathBuf>, _>>();
    let mut paths = paths.map_err(CliError::of_file(folder))?;
    paths.retain(|path| {
        path.extension()
            .is_some_and(|extension| extension == "toml")
    });
    paths.sort();
    paths.truncate(MOST_FILES);
    paths.iter().map(|path| of_file(path)).collect()
}

fn of_file(path: &Path) -> Result<Logger, CliError> {
    let bad = |cause: String| CliError::Logger {
        path: path.to_owned(),
        cause,
    };
    let length = std::fs::metadata(path)
        .map_err(CliError::of_file(path))?
        .len();
    if length > MOST_BYTES {
        return Err(bad(format!(
            "{length} bytes, expected at most {MOST_BYTES}"
        )));
    }
    let text = std::fs::read_to_string(path).map_err(CliError::of_file(path))?;
    parse_logger(&text).map_err(|fault| bad(fault.to_string()))
}
