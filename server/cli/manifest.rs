//! The SHA-256 of everything in a backup, in a file that `sha256sum -c` reads.

use std::collections::BTreeMap;
use std::io::{self, Read};
use std::path::Path;

use sha2::{Digest, Sha256};
use tokio::fs::{self, File};
use tokio::io::AsyncWriteExt;

use super::CliError;
use crate::files::{MARKER, hex};

/// Name of the SQLite database in a data folder.
pub const DATABASE: &str = "veloid.db";
pub const MANIFEST: &str = "SHA256SUMS";
/// Folder of the raw files in a backup.
const RIDES: &str = "rides";
/// Bytes that are read at once.
const PIECE: usize = 256 << 10;

/// SHA-256 by path within the backup.
#[derive(Default)]
pub struct Manifest(BTreeMap<String, String>);

impl Manifest {
    pub fn add_database(&mut self, sha256: String) {
        self.0.insert(DATABASE.to_owned(), sha256);
    }

    pub fn add_marker(&mut self, sha256: String) {
        self.0.insert(format!("{RIDES}/{MARKER}"), sha256);
    }

    pub fn add_raw_file(&mut self, sha256: &str) {
        self.0
            .insert(format!("{RIDES}/{sha256}"), sha256.to_owned());
    }

    /// Writes it into a folder, whole or not at all.
    pub async fn write(&self, folder: &Path) -> io::Result<()> {
        let lines = self.0.iter().map(|(path, sum)| format!("{sum}  {path}\n"));
        let part = folder.join(MANIFEST).with_extension("part");
        let mut file = File::create(&part).await?;
        file.write_all(lines.collect::<String>().as_bytes()).await?;
        file.sync_all().await?;
        fs::rename(&part, folder.join(MANIFEST)).await
    }

    /// That of a folder, if it has one.
    pub async fn read(folder: &Path) -> Result<Option<Self>, CliError> {
        let path = folder.join(MANIFEST);
        let bytes = match fs::read(&path).await {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            read => read.map_err(CliError::of_file(&path))?,
        };
        let text = String::from_utf8_lossy(&bytes);
        let mut sums = BTreeMap::new();
        for (index, line) in text.lines().enumerate() {
            let Some((sum, path)) = line.split_once("  ") else {
                let line = index + 1;
                return Err(CliError::Manifest { path, line });
            };
            sums.insert(path.to_owned(), sum.to_owned());
        }
        Ok(Some(Self(sums)))
    }

    /// What of a backup is not as it was written, the raw files aside: they are compared when they are copied.
    pub async fn faults_without_raw_files(&self, folder: &Path) -> Result<Vec<String>, CliError> {
        let is_raw = |path: &str| path != DATABASE && !path.ends_with(MARKER);
        self.compare(folder, |path| !is_raw(path)).await
    }

    /// What of a backup is not as it was written.
    pub async fn faults(&self, folder: &Path) -> Result<Vec<String>, CliError> {
        let mut found = self.compare(folder, |_| true).await?;
        let rides = folder.join(RIDES);
        let mut entries = fs::read_dir(&rides)
            .await
            .map_err(CliError::of_file(&rides))?;
        while let Some(entry) = entries.next_entry().await? {
            let path = format!("{RIDES}/{}", entry.file_name().display());
            if !self.0.contains_key(&path) {
                found.push(format!("{path} is not in {MANIFEST}"));
            }
        }
        Ok(found)
    }

    async fn compare(
        &self,
        folder: &Path,
        which: impl Fn(&str) -> bool,
    ) -> Result<Vec<String>, CliError> {
        let mut found = Vec::new();
        if !self.0.contains_key(DATABASE) {
            found.push(format!("{MANIFEST} does not name {DATABASE}"));
        }
        for suffix in ["-wal", "-journal"] {
            let name = format!("{DATABASE}{suffix}");
            let metadata = fs::metadata(folder.join(&name)).await;
            if metadata.is_ok_and(|metadata| metadata.len() > 0) {
                found.push(format!("{name}: a program wrote to the database"));
            }
        }
        for (path, sum) in self.0.iter().filter(|(path, _)| which(path)) {
            match sha256_of_file(&folder.join(path)).await {
                Ok(is) if is == *sum => {}
                Ok(is) => found.push(format!(
                    "{path} was altered: its SHA-256 is {is}, {MANIFEST} has {sum}"
                )),
                Err(error) if error.kind() == io::ErrorKind::NotFound => {
                    found.push(format!("{path} is missing"));
                }
                Err(error) => found.push(format!("{path}: {error}")),
            }
        }
        Ok(found)
    }
}

pub async fn sha256_of_file(path: &Path) -> io::Result<String> {
    let path = path.to_owned();
    let read = move || {
        let (mut file, mut sum) = (std::fs::File::open(path)?, Sha256::new());
        let mut piece = vec![0; PIECE];
        loop {
            match file.read(&mut piece)? {
                0 => return Ok(hex(&sum.finalize())),
                read => sum.update(&piece[..read]),
            }
        }
    };
    tokio::task::spawn_blocking(read).await?
}
