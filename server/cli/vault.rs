//! A data folder's content, copied into an empty one: a backup is a data folder, and a restore copies it
//! back. The database goes first, since its rides' files are there before they are in it and stay; its
//! copy gets its name last, so that a folder with a database holds all that it should.

use std::future::Future;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use futures_util::TryStreamExt;
use tokio::fs::{self, File};

use super::CliError;
use super::manifest::{DATABASE, MANIFEST, Manifest, sha256_of_file};
use crate::files::{FileError, Files};
use crate::store::is_full;
use crate::store::snapshot::{SnapshotError, size, snapshot};

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

    /// Bytes of the database and of all raw files.
    pub async fn bytes(&self) -> Result<u64, CliError> {
        Ok(size(&self.database).await?)
    }

    /// Copies everything into a vault that has no database yet, with a manifest in a folder if one is wanted.
    /// A raw file that is missing or damaged holds up no other.
    pub async fn copy_to(&self, to: &Vault, manifest: Option<&Path>) -> Result<Copied, CliError> {
        let part = to.database.with_extension("part");
        let written = self.write(to, &part, manifest).await;
        if written.is_err() {
            // SQLite leaves a journal beside a copy that it could not end. They may not have been made.
            let _ = fs::remove_file(&part).await;
            let _ = fs::remove_file(part.with_extension("part-journal")).await;
        }
        written
    }

    async fn write(
        &self,
        to: &Vault,
        part: &Path,
        manifest: Option<&Path>,
    ) -> Result<Copied, CliError> {
        let names = snapshot(&self.database, part).await?;
        let mut sums = Manifest::default();
        if let Some(id) = self.files.installation().await? {
            sums.add_marker(to.files.replace_installation(id).await?);
        }
        let mut copied = Copied {
            of: names.len(),
            ..Copied::default()
        };
        for sha256 in &names {
            match copy(&self.files, &to.files, sha256).await? {
                Ok(size) => {
                    copied.bytes += size;
                    sums.add_raw_file(sha256);
                }
                Err(error) => {
                    eprintln!("veloid: {error}");
                    copied.lost += 1;
                }
            }
        }
        File::open(part).await?.sync_all().await?;
        if let Some(folder) = manifest {
            sums.add_database(sha256_of_file(part).await?);
            sums.write(folder).await?;
        }
        fs::rename(part, &to.database).await?;
        if let Some(folder) = to.database.parent() {
            File::open(folder).await?.sync_all().await?;
        }
        Ok(copied)
    }
}

/// What was copied beside the database.
#[derive(Default)]
pub struct Copied {
    of: usize,
    lost: usize,
    bytes: u64,
}

impl Copied {
    /// In one line, or that something could not be copied.
    pub fn all(&self) -> Result<String, CliError> {
        let Self { of, lost, bytes } = *self;
        match lost {
            0 => Ok(format!("the database and {of} raw files of {bytes} bytes")),
            lost => Err(CliError::FilesLost { lost, of }),
        }
    }
}

/// Copies a raw file, if its bytes are those that it is named by; how many they are.
async fn copy(from: &Files, to: &Files, sha256: &str) -> std::io::Result<Result<u64, FileError>> {
    let mut stream = match from.open(sha256).await {
        Ok(stream) => stream,
        Err(lost) => return Ok(Err(lost)),
    };
    let mut incoming = to.begin().await?;
    loop {
        match stream.try_next().await {
            Ok(Some(chunk)) => incoming.write(&chunk).await?,
            Ok(None) => break,
            Err(error) => return Ok(Err(FileError::Store(error))),
        }
    }
    match incoming.is(sha256) {
        Ok(()) => Ok(Ok(to.keep(incoming).await?.bytes)),
        Err(altered) => Ok(Err(altered)),
    }
}

/// A folder with nothing in it, or none yet, that is left so where a copy into it fails.
pub struct Fresh {
    folder: PathBuf,
    existed: bool,
}

impl Fresh {
    pub async fn at(folder: &Path) -> Result<Self, CliError> {
        let existed = match fs::read_dir(folder).await {
            Ok(mut entries) => match entries.next_entry().await? {
                Some(_) => return Err(CliError::NotEmpty(folder.to_owned())),
                None => true,
            },
            Err(error) if error.kind() == ErrorKind::NotFound => false,
            Err(error) => return Err(CliError::of_file(folder)(error)),
        };
        let folder = folder.to_owned();
        Ok(Self { folder, existed })
    }

    /// Has it filled with so many bytes.
    pub async fn fill(
        self,
        bytes: u64,
        copy: impl Future<Output = Result<Copied, CliError>>,
    ) -> Result<Copied, CliError> {
        let error = match copy.await {
            Ok(copied) => return Ok(copied),
            Err(error) => error,
        };
        let part = format!("{MANIFEST}.part");
        for ours in ["rides", "incoming", MANIFEST, &part] {
            let path = self.folder.join(ours);
            // What was not made cannot be removed.
            let _ = match path.is_dir() {
                true => fs::remove_dir_all(path).await,
                false => fs::remove_file(path).await,
            };
        }
        if !self.existed {
            let _ = fs::remove_dir(&self.folder).await;
        }
        let folder = self.folder;
        Err(match is_of_full_disk(&error) {
            true => CliError::NoRoom { folder, bytes },
            false => error,
        })
    }
}

fn is_of_full_disk(error: &CliError) -> bool {
    match error {
        CliError::Io(error) => {
            matches!(
                error.kind(),
                ErrorKind::StorageFull | ErrorKind::QuotaExceeded
            )
        }
        CliError::Snapshot(SnapshotError::Database(error)) => is_full(error),
        _ => false,
    }
}
