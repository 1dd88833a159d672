//! Raw files in a folder.

use std::io;
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

use async_stream::try_stream;
use axum::body::Bytes;
use futures_util::StreamExt;
use futures_util::stream::BoxStream;
use tokio::fs::{self, File};
use tokio::io::AsyncWriteExt;
use tokio_util::io::ReaderStream;
use uuid::Uuid;

/// Bytes that are read at once.
const PIECE: usize = 256 << 10;

#[derive(Clone)]
pub struct Folder(PathBuf);

impl Folder {
    /// Opens the folder, making it where it is missing.
    pub async fn open(path: PathBuf) -> io::Result<Self> {
        fs::create_dir_all(&path).await?;
        Ok(Self(path))
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    /// Takes a file in under a name.
    pub async fn keep(&self, path: &Path, name: &str) -> io::Result<()> {
        File::open(path).await?.sync_all().await?;
        fs::rename(path, self.path(name)).await?;
        File::open(&self.0).await?.sync_all().await
    }

    pub async fn has(&self, name: &str) -> io::Result<bool> {
        fs::try_exists(self.path(name)).await
    }

    /// Removes a file; false where it is not there.
    pub async fn remove(&self, name: &str) -> io::Result<bool> {
        match fs::remove_file(self.path(name)).await {
            Ok(()) => Ok(true),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(false),
            Err(error) => Err(error),
        }
    }

    /// The bytes of a file.
    pub async fn get(&self, name: &str) -> io::Result<BoxStream<'static, io::Result<Bytes>>> {
        let file = File::open(self.path(name)).await?;
        Ok(ReaderStream::with_capacity(file, PIECE).boxed())
    }

    /// All files, and when they were written (epoch s).
    pub fn list(&self) -> BoxStream<'static, io::Result<(String, u64)>> {
        let folder = self.0.clone();
        let all = try_stream! {
            let mut entries = fs::read_dir(folder).await?;
            while let Some(entry) = entries.next_entry().await? {
                let metadata = match entry.metadata().await {
                    Ok(metadata) => metadata,
                    // Removed meanwhile.
                    Err(error) if error.kind() == io::ErrorKind::NotFound => continue,
                    Err(error) => Err(error)?,
                };
                if let (Ok(name), true) = (entry.file_name().into_string(), metadata.is_file()) {
                    let written = metadata.modified()?.duration_since(UNIX_EPOCH);
                    yield (name, written.unwrap_or_default().as_secs());
                }
            }
        };
        all.boxed()
    }

    /// Writes a file whose name must not be taken; after a power cut all of it is there, or nothing.
    pub async fn put_new(&self, name: &str, bytes: Vec<u8>) -> io::Result<()> {
        let part = self.path(&format!("{name}.{}", Uuid::now_v7().simple()));
        let linked = async {
            let mut file = File::create_new(&part).await?;
            file.write_all(&bytes).await?;
            file.sync_all().await?;
            // Fails where the name is taken, as a rename would not.
            fs::hard_link(&part, self.path(name)).await
        };
        let linked = linked.await;
        fs::remove_file(&part).await?;
        linked?;
        File::open(&self.0).await?.sync_all().await
    }
}
