//! Holds files and rows against each other.

use super::prune::{EraseError, Prune};
use super::rows;
use crate::files::FileError;
use crate::installation::{ARRIVING, Census};
use crate::store::scrub;

/// Files that are asked for at once.
const PAGE: i64 = 500;

impl Prune<'_> {
    /// Says every finding in a line and how many there are; removes files that the database does not know, unless this is
    /// a dry run.
    pub async fn scrub(&self) -> Result<u64, EraseError> {
        let mut found = 0;
        let mut say = |line: String| {
            found += 1;
            (self.note)(&line);
        };
        let faults = scrub::integrity(self.db).await?;
        for fault in &faults {
            say(format!("database: {fault}"));
        }
        if !faults.is_empty() {
            return Ok(found);
        }
        rows::compare(self.db, &mut say).await?;
        let mut last = String::new();
        loop {
            let page = scrub::files(self.db, &last, PAGE).await?;
            let Some(end) = page.last() else { break };
            last.clone_from(&end.sha256);
            for file in &page {
                match self.files.verify(&file.sha256).await {
                    Ok(bytes) if bytes.cast_signed() == file.bytes => {}
                    Ok(bytes) => say(format!(
                        "raw file {} has {bytes} bytes, its rides state {}",
                        file.sha256, file.bytes
                    )),
                    Err(FileError::Store(error)) => return Err(error.into()),
                    Err(lost) => say(format!("{lost}; upload the same file again to replace it")),
                }
            }
        }
        Ok(found + self.unknown().await?)
    }

    /// Finds files that have lain in the store for an hour and belong to no ride, erased ones included.
    async fn unknown(&self) -> Result<u64, EraseError> {
        let Census { files, unknown } = Census::take(self.db, self.files, ARRIVING).await?;
        let mut found = 0;
        for sha256 in &unknown {
            found += u64::from(self.remove(sha256).await?);
        }
        if found > 0 {
            let share = 100.0 * unknown.len() as f64 / files as f64;
            (self.note)(&format!(
                "{found} of {files} raw files ({share:.1} %) belong to no ride of this database{}",
                match self.dry_run {
                    true => "; `--repair` removes them",
                    false => " and were removed",
                }
            ));
        }
        Ok(found)
    }
}
