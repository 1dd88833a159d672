//! The raw files, each named by the SHA-256 of its bytes: in a folder, or in object storage that
//! many machines reach. A file arrives under a temporary name on this machine; before anyone hears of
//! it, it is synced, renamed and the folder synced, or the object storage has said that it has it.

mod folder;
mod marker;
#[cfg(feature = "s3")]
mod objects;
#[cfg(test)]
mod tests;

use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use axum::body::Bytes;
use futures_util::stream::BoxStream;
use futures_util::{Stream, StreamExt, TryStreamExt};
use sha2::{Digest, Sha256};
use tokio::fs::{self, File};
use tokio::io::AsyncWriteExt;
use url::Url;
use uuid::Uuid;

use self::folder::Folder;
pub use self::marker::MARKER;
#[cfg(feature = "s3")]
use self::objects::Objects;
#[cfg(not(feature = "s3"))]
use crate::built::NotBuilt;

/// A file is locked this soon after it was begun, for as long as it arrives.
const BEGUN: Duration = Duration::from_secs(60);
/// What a store that takes uploads has room for at least (bytes).
const ROOM: usize = 64 << 10;

/// Why a raw file cannot be had.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    #[error("raw file {0} is missing from the store")]
    Missing(String),
    #[error("raw file {sha256} was altered in the store: the SHA-256 of its bytes is {found}")]
    Altered { sha256: String, found: String },
    #[error("file store: {0}")]
    Store(#[from] io::Error),
}

#[derive(Clone)]
pub struct Files {
    incoming: PathBuf,
    kept: Store,
    /// The id of the installation that they belong to, once that is known.
    owner: Arc<OnceLock<Uuid>>,
}

/// Where files are kept.
#[derive(Clone)]
enum Store {
    Folder(Folder),
    #[cfg(feature = "s3")]
    Objects(Objects),
}

/// Runs a body on whichever store there is.
macro_rules! in_store {
    ($kept:expr, $store:ident => $body:expr) => {
        match $kept {
            $crate::files::Store::Folder($store) => $body,
            #[cfg(feature = "s3")]
            $crate::files::Store::Objects($store) => $body,
        }
    };
}
use in_store;

type Chunks = BoxStream<'static, io::Result<Bytes>>;

impl Files {
    /// Opens the store below a folder, making what is missing.
    pub async fn in_folder(root: &Path) -> io::Result<Self> {
        Ok(Self {
            kept: Store::Folder(Folder::open(root.join("rides")).await?),
            incoming: incoming(root).await?,
            owner: Arc::default(),
        })
    }

    /// Opens the store at `file:///folder` or, with what the `AWS_*` variables say, at
    /// `s3://bucket/prefix`. Files on their way to the latter lie below `root`.
    pub async fn at(url: &Url, root: &Path) -> io::Result<Self> {
        if let ("file", Ok(folder)) = (url.scheme(), url.to_file_path()) {
            return Self::in_folder(&folder).await;
        }
        Ok(Self {
            kept: objects(url)?,
            incoming: incoming(root).await?,
            owner: Arc::default(),
        })
    }

    /// Begins a file whose bytes are yet to come.
    pub async fn begin(&self) -> io::Result<Incoming> {
        let path = self.incoming.join(Uuid::now_v7().simple().to_string());
        let file = std::fs::File::create_new(&path)?;
        // Until it has arrived or its process is gone.
        file.try_lock()?;
        Ok(Incoming {
            file: file.into(),
            path,
            sha256: Sha256::new(),
            bytes: 0,
        })
    }

    /// Makes the file durable under its SHA-256.
    pub async fn keep(&self, mut incoming: Incoming) -> io::Result<Kept> {
        incoming.file.flush().await?;
        let kept = Kept {
            sha256: incoming.sha256(),
            bytes: incoming.bytes,
        };
        let (path, name) = (&incoming.path, &kept.sha256);
        in_store!(&self.kept, store => store.keep(path, name).await)?;
        Ok(kept)
    }

    /// Whether the file is there.
    pub async fn has(&self, sha256: &str) -> io::Result<bool> {
        in_store!(&self.kept, store => store.has(sha256).await)
    }

    /// Removes the file; false where it is not there.
    pub async fn remove(&self, sha256: &str) -> io::Result<bool> {
        in_store!(&self.kept, store => store.remove(sha256).await)
    }

    /// The SHA-256 of files that have lain there for so long.
    pub fn kept_for(&self, time: Duration) -> impl Stream<Item = io::Result<String>> {
        let now = SystemTime::now().duration_since(UNIX_EPOCH);
        let until = now.unwrap_or_default().saturating_sub(time).as_secs();
        let all = in_store!(&self.kept, store => store.list());
        all.try_filter_map(move |(name, written)| {
            let ours = name.len() == 64 && name.bytes().all(|byte| byte.is_ascii_hexdigit());
            let old = written <= until;
            std::future::ready(Ok((ours && old).then_some(name)))
        })
    }

    /// Whether the store has any raw file.
    pub async fn has_any(&self) -> io::Result<bool> {
        let first = self.kept_for(Duration::ZERO).boxed().try_next().await?;
        Ok(first.is_some())
    }

    /// A file as it lies on this machine, copied there if need be; its bytes are those that it is named by.
    pub async fn on_disk(&self, sha256: &str) -> Result<OnDisk, FileError> {
        match &self.kept {
            Store::Folder(folder) => {
                self.verify(sha256).await?;
                Ok(OnDisk::Kept(folder.path(sha256)))
            }
            #[cfg(feature = "s3")]
            Store::Objects(_) => {
                let mut copy = self.begin().await?;
                let mut stream = self.open(sha256).await?;
                while let Some(chunk) = stream.try_next().await? {
                    copy.write(&chunk).await?;
                }
                copy.file.flush().await?;
                same(sha256, copy.sha256())?;
                Ok(OnDisk::Copy(Box::new(copy)))
            }
        }
    }

    /// Whether the bytes of a file are those that it is named by; how many they are.
    pub async fn verify(&self, sha256: &str) -> Result<u64, FileError> {
        let mut stream = self.open(sha256).await?;
        let (mut sum, mut bytes) = (Sha256::new(), 0);
        while let Some(chunk) = stream.try_next().await? {
            bytes += chunk.len() as u64;
            sum.update(&chunk);
        }
        same(sha256, hex(&sum.finalize()))?;
        Ok(bytes)
    }

    /// The bytes of a file, whatever they are, or that it is missing.
    pub async fn open(&self, sha256: &str) -> Result<Chunks, FileError> {
        match self.stream(sha256).await {
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                // Where the store is another one, the file may still be in the right one.
                self.check().await.map_err(io::Error::from)?;
                Err(FileError::Missing(sha256.to_owned()))
            }
            opened => Ok(opened?),
        }
    }

    /// Whether there is room for an upload.
    pub async fn has_room(&self) -> io::Result<()> {
        let mut incoming = self.begin().await?;
        incoming.write(&[0; ROOM]).await?;
        incoming.file.flush().await?;
        incoming.file.sync_data().await
    }

    /// Removes what arrived for processes that are gone; how many files.
    pub async fn clear(&self) -> io::Result<u64> {
        clear(&self.incoming).await
    }

    /// The bytes of a file, whatever they are.
    pub async fn stream(&self, sha256: &str) -> io::Result<Chunks> {
        in_store!(&self.kept, store => store.get(sha256).await)
    }
}

#[cfg(feature = "s3")]
fn objects(url: &Url) -> io::Result<Store> {
    Objects::open(url).map(Store::Objects)
}

#[cfg(not(feature = "s3"))]
fn objects(url: &Url) -> io::Result<Store> {
    let what = format!("raw files at {}://", url.scheme());
    Err(io::Error::new(
        io::ErrorKind::Unsupported,
        NotBuilt::of("s3", what),
    ))
}

/// Refuses bytes that are not those of their name.
fn same(sha256: &str, found: String) -> Result<(), FileError> {
    if found == sha256 {
        return Ok(());
    }
    let sha256 = sha256.to_owned();
    Err(FileError::Altered { sha256, found })
}

/// The folder of files on their way, cleared of what crashed uploads left.
async fn incoming(root: &Path) -> io::Result<PathBuf> {
    let folder = root.join("incoming");
    fs::create_dir_all(&folder).await?;
    clear(&folder).await?;
    Ok(folder)
}

/// Removes the files that no process holds.
async fn clear(folder: &Path) -> io::Result<u64> {
    let (mut entries, mut removed) = (fs::read_dir(folder).await?, 0);
    while let Some(entry) = entries.next_entry().await? {
        // Another process may have removed it, or be done with it, meanwhile.
        let Ok(file) = std::fs::File::open(entry.path()) else {
            continue;
        };
        let age = file.metadata()?.modified()?.elapsed();
        if age.is_ok_and(|age| age > BEGUN) && file.try_lock().is_ok() {
            removed += u64::from(fs::remove_file(entry.path()).await.is_ok());
        }
    }
    Ok(removed)
}

/// A file that is safe.
pub struct Kept {
    pub sha256: String,
    pub bytes: u64,
}

/// A kept file on this machine, where a process can open it.
pub enum OnDisk {
    Kept(PathBuf),
    /// A copy that goes with this.
    #[cfg(feature = "s3")]
    Copy(Box<Incoming>),
}

impl OnDisk {
    pub fn path(&self) -> &Path {
        match self {
            OnDisk::Kept(path) => path,
            #[cfg(feature = "s3")]
            OnDisk::Copy(copy) => &copy.path,
        }
    }
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

    /// Refuses what was received so far unless it has this name.
    pub fn is(&self, sha256: &str) -> Result<(), FileError> {
        same(sha256, self.sha256())
    }

    /// Where what was received so far can be read.
    pub async fn path(&mut self) -> io::Result<&Path> {
        self.file.flush().await?;
        Ok(&self.path)
    }
}

impl Drop for Incoming {
    fn drop(&mut self) {
        // Renamed into a folder, it is gone already.
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
