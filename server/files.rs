//! The raw files: one folder, each file named by the SHA-256 of its bytes. A file is written under
//! a temporary name, synced, renamed, and the folder synced, before anyone hears of it.

use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use sha2::{Digest, Sha256};
use tokio::fs::{self, File};
use tokio::io::AsyncWriteExt;
use uuid::Uuid;

/// A temporary file this old was left behind by a process that is gone.
const STALE: Duration = Duration::from_secs(24 * 3600);

#[derive(Clone)]
pub struct Files {
    folder: PathBuf,
    incoming: PathBuf,
}

impl Files {
    /// Opens the store below `data`, making its folders and clearing what crashed uploads left.
    pub async fn open(data: &Path) -> io::Result<Self> {
        let files = Self {
            folder: data.join("rides"),
            incoming: data.join("incoming"),
        };
        fs::create_dir_all(&files.folder).await?;
        fs::create_dir_all(&files.incoming).await?;
        let mut entries = fs::read_dir(&files.incoming).await?;
        while let Some(entry) = entries.next_entry().await? {
            let modified = entry.metadata().await?.modified()?;
            if SystemTime::now()
                .duration_since(modified)
                .is_ok_and(|age| age > STALE)
            {
                fs::remove_file(entry.path()).await?;
            }
        }
        Ok(files)
    }

    /// Begins a file whose bytes are yet to come.
    pub async fn begin(&self) -> io::Result<Incoming> {
        let path = self.incoming.join(Uuid::now_v7().simple().to_string());
        Ok(Incoming {
            file: File::create_new(&path).await?,
            path,
            sha256: Sha256::new(),
            bytes: 0,
        })
    }

    /// Makes the file durable under its SHA-256.
    pub async fn keep(&self, mut incoming: Incoming) -> io::Result<Kept> {
        incoming.file.flush().await?;
        incoming.file.sync_all().await?;
        let kept = Kept {
            sha256: incoming.sha256(),
            bytes: incoming.bytes,
        };
        fs::rename(&incoming.path, self.path(&kept.sha256)).await?;
        File::open(&self.folder).await?.sync_all().await?;
        Ok(kept)
    }

    pub async fn read(&self, sha256: &str) -> io::Result<Vec<u8>> {
        fs::read(self.path(sha256)).await
    }

    pub async fn stream(&self, sha256: &str) -> io::Result<File> {
        File::open(self.path(sha256)).await
    }

    fn path(&self, sha256: &str) -> PathBuf {
        self.folder.join(sha256)
    }
}

/// A file that is safe on disk.
pub struct Kept {
    pub sha256: String,
    pub bytes: u64,
}

/// A file being received; dropped before it is kept, it is removed.
pub struct Incoming {
    file: File,
    path: PathBuf,
    sha256: Sha256,
    bytes: u64,
}

impl Incoming {
    pub async fn write(&mut self, chunk: &[u8]) -> io::Result<()> {
        self.sha256.update(chunk);
        self.bytes += chunk.len() as u64;
        self.file.write_all(chunk).await
    }

    /// Bytes received so far.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// SHA-256 of what was received so far (hex).
    pub fn sha256(&self) -> String {
        hex(&self.sha256.clone().finalize())
    }

    /// What was received so far.
    pub async fn contents(&mut self) -> io::Result<Vec<u8>> {
        self.file.flush().await?;
        fs::read(&self.path).await
    }
}

impl Drop for Incoming {
    fn drop(&mut self) {
        // After `keep` the name is gone already.
        let _ = std::fs::remove_file(&self.path);
    }
}

/// Lower-case hexadecimal.
pub fn hex(bytes: &[u8]) -> String {
    use std::fmt::Write;
    bytes.iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[tokio::test]
    async fn a_kept_file_is_found_by_its_hash_and_an_abandoned_one_is_gone() {
        let data = std::env::temp_dir().join(format!("veloid-files-{}", Uuid::now_v7()));
        let files = Files::open(&data).await.unwrap();
        let mut incoming = files.begin().await.unwrap();
        incoming.write(b"ab").await.unwrap();
        incoming.write(b"c").await.unwrap();
        assert_eq!(incoming.contents().await.unwrap(), b"abc");
        let kept = files.keep(incoming).await.unwrap();
        assert_eq!(
            kept.sha256,
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
        );
        assert_eq!(kept.bytes, 3);
        assert_eq!(files.read(&kept.sha256).await.unwrap(), b"abc");
        drop(files.begin().await.unwrap());
        assert_eq!(std::fs::read_dir(data.join("incoming")).unwrap().count(), 0);
        std::fs::remove_dir_all(data).unwrap();
    }
}
