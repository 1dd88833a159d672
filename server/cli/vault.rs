//! A data folder's content, copied into an empty one: a backup is a data folder, and a restore copies it
//! back. The database goes first, since its rides' files are there before they are in it and stay; its
//! copy gets its name last, so that a folder with a database holds all that it should.

use std::path::{Path, PathBuf};

use futures_util::TryStreamExt;
use tokio::fs::{self, File};

use super::CliError;
use crate::files::Files;
use crate::store::snapshot::snapshot;

/// Name of the SQLite database in a data folder.
pub const DATABASE: &str = "veloid.db";

/// A database and its raw files.
pub struct Vault {
    pub database: PathBuf,
    pub files: Files,
}

impl Vault {
    /// What lies in a data folder.
    pub async fn in_folder(folder: &Path) -> Result<Self, CliError> {
        Ok(Self {
            database: folder.join(DATABASE),
            files: Files::in_folder(folder).await?,
        })
    }

    /// Copies everything into a vault that has no database yet, and says in one line what it was.
    /// A raw file that is missing or damaged holds up no other.
    pub async fn copy_to(&self, to: &Vault) -> Result<String, CliError> {
        let part = to.database.with_extension("part");
        let names = snapshot(&self.database, &part).await?;
        if let Some(id) = self.files.installation().await? {
            to.files.replace_installation(id).await?;
        }
        let (mut bytes, mut lost) = (0, 0);
        for sha256 in &names {
            match copy(&self.files, &to.files, sha256).await {
                Ok(size) => bytes += size,
                Err(error) => {
                    eprintln!("veloid: raw file {sha256}: {error}");
                    lost += 1;
                }
            }
        }
        File::open(&part).await?.sync_all().await?;
        fs::rename(&part, &to.database).await?;
        if let Some(folder) = to.database.parent() {
            File::open(folder).await?.sync_all().await?;
        }
        if lost > 0 {
            let of = names.len();
            return Err(CliError::FilesLost { lost, of });
        }
        let count = names.len();
        Ok(format!(
            "the database and {count} raw files of {bytes} bytes"
        ))
    }
}

/// Copies a raw file, if its bytes are those that it is named by; how many they are.
async fn copy(from: &Files, to: &Files, sha256: &str) -> std::io::Result<u64> {
    let mut stream = from.stream(sha256).await?;
    let mut incoming = to.begin().await?;
    while let Some(chunk) = stream.try_next().await? {
        incoming.write(&chunk).await?;
    }
    let found = incoming.sha256();
    if found != sha256 {
        return Err(std::io::Error::other(format!(
            "the SHA-256 of its bytes is {found}"
        )));
    }
    Ok(to.keep(incoming).await?.bytes)
}

/// Whether there is nothing at a path, or an empty folder.
pub async fn is_empty(folder: &Path) -> std::io::Result<bool> {
    match fs::read_dir(folder).await {
        Ok(mut entries) => Ok(entries.next_entry().await?.is_none()),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(true),
        Err(error) => Err(error),
    }
}
