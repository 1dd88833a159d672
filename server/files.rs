//! The raw files, each named by the SHA-256 of its bytes: in a folder, or in object storage that
//! many machines reach. A file arrives under a temporary name on this machine; before anyone hears of
//! it, it is synced, renamed and the folder synced, or the object storage has said that it has it.

mod marker;

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use axum::body::Bytes;
use futures_util::stream::BoxStream;
use futures_util::{Stream, StreamExt, TryStreamExt};
use object_store::buffered::BufWriter;
use object_store::local::LocalFileSystem;
use object_store::prefix::PrefixStore;
use object_store::{GetResult, ObjectStore, ObjectStoreExt};
use sha2::{Digest, Sha256};
use tokio::fs::{self, File};
use tokio::io::AsyncWriteExt;
use url::Url;
use uuid::Uuid;

/// A file is locked this soon after it was begun, for as long as it arrives.
const BEGUN: Duration = Duration::from_secs(60);
/// What a store that takes uploads has room for at least (bytes).
const ROOM: usize = 64 << 10;

/// Why a raw file cannot be had.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    #[error("raw file {0} is missing in the store")]
    Missing(String),
    #[error("raw file {sha256} was altered in the store: its bytes have the SHA-256 {found}")]
    Altered { sha256: String, found: String },
    #[error("file store: {0}")]
    Store(#[from] io::Error),
}

#[derive(Clone)]
pub struct Files {
    incoming: PathBuf,
    kept: Arc<dyn ObjectStore>,
    /// Where `kept` is a folder: what has arrived is renamed into it.
    folder: Option<PathBuf>,
}

impl Files {
    /// Opens the store below a folder, making what is missing.
    pub async fn in_folder(root: &Path) -> io::Result<Self> {
        let folder = root.join("rides");
        fs::create_dir_all(&folder).await?;
        Ok(Self {
            incoming: incoming(root).await?,
            kept: Arc::new(LocalFileSystem::new_with_prefix(&folder)?),
            folder: Some(folder),
        })
    }

    /// Opens the store at `file:///folder` or, with what the `AWS_*` variables say, at
    /// `s3://bucket/prefix`. Files on their way to the latter lie below `root`.
    pub async fn at(url: &Url, root: &Path) -> io::Result<Self> {
        if let ("file", Ok(folder)) = (url.scheme(), url.to_file_path()) {
            return Self::in_folder(&folder).await;
        }
        let settings = std::env::vars_os()
            .filter_map(|(key, value)| Some((key.into_string().ok()?, value.into_string().ok()?)))
            .filter(|(key, _)| key.starts_with("AWS_"));
        let (store, prefix) = object_store::parse_url_opts(url, settings)?;
        Ok(Self {
            incoming: incoming(root).await?,
            kept: Arc::new(PrefixStore::new(store, prefix)),
            folder: None,
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
        if let Some(folder) = &self.folder {
            incoming.file.sync_all().await?;
            fs::rename(&incoming.path, folder.join(&kept.sha256)).await?;
            File::open(folder).await?.sync_all().await?;
        } else {
            let mut object = BufWriter::new(Arc::clone(&self.kept), name(&kept.sha256));
            tokio::io::copy(&mut File::open(&incoming.path).await?, &mut object).await?;
            object.shutdown().await?;
        }
        Ok(kept)
    }

    /// Whether the file is there.
    pub async fn has(&self, sha256: &str) -> io::Result<bool> {
        was_there(self.kept.head(&name(sha256)).await.map(drop))
    }

    /// Removes the file; false where it is not there.
    pub async fn remove(&self, sha256: &str) -> io::Result<bool> {
        was_there(self.kept.delete(&name(sha256)).await)
    }

    /// The SHA-256 of files that have lain there for so long.
    pub fn kept_for(&self, time: Duration) -> impl Stream<Item = io::Result<String>> {
        let until = jiff::Timestamp::now().as_second() - time.as_secs().cast_signed();
        let all = self.kept.list(None).map_err(io::Error::from);
        all.try_filter_map(move |file| {
            let name = file.location.to_string();
            let ours = name.len() == 64 && name.bytes().all(|byte| byte.is_ascii_hexdigit());
            let old = file.last_modified.timestamp() <= until;
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
        if let Some(folder) = &self.folder {
            self.verify(sha256).await?;
            return Ok(OnDisk::Kept(folder.join(sha256)));
        }
        let mut copy = self.begin().await?;
        let mut stream = self.open(sha256).await?.into_stream();
        while let Some(chunk) = stream.try_next().await.map_err(io::Error::from)? {
            copy.write(&chunk).await?;
        }
        copy.file.flush().await?;
        same(sha256, copy.sha256())?;
        Ok(OnDisk::Copy(Box::new(copy)))
    }

    /// Whether the bytes of a file are those that it is named by; how many they are.
    pub async fn verify(&self, sha256: &str) -> Result<u64, FileError> {
        let mut stream = self.open(sha256).await?.into_stream();
        let (mut sum, mut bytes) = (Sha256::new(), 0);
        while let Some(chunk) = stream.try_next().await.map_err(io::Error::from)? {
            bytes += chunk.len() as u64;
            sum.update(&chunk);
        }
        same(sha256, hex(&sum.finalize()))?;
        Ok(bytes)
    }

    async fn open(&self, sha256: &str) -> Result<GetResult, FileError> {
        match self.kept.get(&name(sha256)).await {
            Ok(found) => Ok(found),
            Err(object_store::Error::NotFound { .. }) => Err(FileError::Missing(sha256.to_owned())),
            Err(error) => Err(FileError::Store(error.into())),
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
    pub async fn stream(&self, sha256: &str) -> io::Result<BoxStream<'static, io::Result<Bytes>>> {
        let stream = self.kept.get(&name(sha256)).await?.into_stream();
        Ok(stream.map_err(io::Error::from).boxed())
    }
}

/// Whether something was there.
fn was_there(outcome: object_store::Result<()>) -> io::Result<bool> {
    match outcome {
        Ok(()) => Ok(true),
        Err(object_store::Error::NotFound { .. }) => Ok(false),
        Err(error) => Err(error.into()),
    }
}

fn name(sha256: &str) -> object_store::path::Path {
    object_store::path::Path::from(sha256)
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
    Copy(Box<Incoming>),
}

impl OnDisk {
    pub fn path(&self) -> &Path {
        match self {
            OnDisk::Kept(path) => path,
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    async fn keeps_abc(files: &Files) {
        let mut incoming = files.begin().await.unwrap();
        incoming.write(b"ab").await.unwrap();
        incoming.write(b"c").await.unwrap();
        let path = incoming.path().await.unwrap();
        assert_eq!(std::fs::read(path).unwrap(), b"abc");
        let kept = files.keep(incoming).await.unwrap();
        assert_eq!(
            kept.sha256,
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
        );
        assert_eq!(kept.bytes, 3);
        let lies = files.on_disk(&kept.sha256).await.unwrap();
        assert_eq!(std::fs::read(lies.path()).unwrap(), b"abc");
        drop(lies);
        let chunks = files.stream(&kept.sha256).await.unwrap();
        let chunks: Vec<Bytes> = chunks.try_collect().await.unwrap();
        assert_eq!(chunks.concat(), b"abc");
        drop(files.begin().await.unwrap());
        let left = std::fs::read_dir(&files.incoming).unwrap().count();
        assert_eq!(left, 0, "what is kept or abandoned is no longer on its way");
        let missing = files.on_disk("0").await.map(drop).unwrap_err();
        assert!(matches!(missing, FileError::Missing(name) if name == "0"));
        assert_eq!(files.verify(&kept.sha256).await.unwrap(), 3);
    }

    #[tokio::test]
    async fn a_file_is_there_until_it_is_removed_and_an_old_one_is_listed() {
        let root = std::env::temp_dir().join(format!("veloid-files-{}", Uuid::now_v7()));
        let files = Files::in_folder(&root).await.unwrap();
        keeps_abc(&files).await;
        std::fs::write(root.join("rides/README"), "no raw file").unwrap();
        let listed =
            async |time| -> Vec<String> { files.kept_for(time).try_collect().await.unwrap() };
        let [abc] = &listed(Duration::ZERO).await[..] else {
            panic!("one raw file");
        };
        assert!(listed(Duration::from_secs(3600)).await.is_empty());
        assert!(files.has(abc).await.unwrap());
        assert!(files.remove(abc).await.unwrap());
        assert!(!files.has(abc).await.unwrap() && !files.remove(abc).await.unwrap());
        std::fs::remove_dir_all(root).unwrap();
    }

    #[tokio::test]
    async fn a_kept_file_is_found_by_its_hash_and_an_abandoned_one_is_gone() {
        let root = std::env::temp_dir().join(format!("veloid-files-{}", Uuid::now_v7()));
        let shared = Url::from_file_path(root.join("shared")).unwrap();
        keeps_abc(&Files::in_folder(&root).await.unwrap()).await;
        keeps_abc(&Files::at(&shared, &root).await.unwrap()).await;
        assert_eq!(
            std::fs::read_dir(root.join("shared/rides"))
                .unwrap()
                .count(),
            1
        );
        let memory = "memory:///".parse().unwrap();
        keeps_abc(&Files::at(&memory, &root).await.unwrap()).await;
        std::fs::remove_dir_all(root).unwrap();
    }

    #[tokio::test]
    async fn altered_bytes_are_not_given_out() {
        let root = std::env::temp_dir().join(format!("veloid-files-{}", Uuid::now_v7()));
        let files = Files::in_folder(&root).await.unwrap();
        let mut incoming = files.begin().await.unwrap();
        incoming.write(b"abc").await.unwrap();
        let kept = files.keep(incoming).await.unwrap();
        std::fs::write(root.join("rides").join(&kept.sha256), "abd").unwrap();
        for fault in [
            files.on_disk(&kept.sha256).await.map(drop).unwrap_err(),
            files.verify(&kept.sha256).await.map(drop).unwrap_err(),
        ] {
            assert!(matches!(fault, FileError::Altered { .. }), "{fault}");
        }
        std::fs::remove_dir_all(root).unwrap();
    }

    #[tokio::test]
    async fn what_arrives_is_left_and_what_a_dead_process_left_goes() {
        let root = std::env::temp_dir().join(format!("veloid-files-{}", Uuid::now_v7()));
        let files = Files::in_folder(&root).await.unwrap();
        let arriving = files.begin().await.unwrap();
        let left = files.incoming.join("left");
        let long_ago = std::time::SystemTime::now() - 2 * BEGUN;
        for path in [&left, &arriving.path] {
            let file = std::fs::File::options()
                .create(true)
                .append(true)
                .open(path);
            file.unwrap().set_modified(long_ago).unwrap();
        }
        assert_eq!(files.clear().await.unwrap(), 1);
        assert!(arriving.path.exists() && !left.exists());
        std::fs::remove_dir_all(root).unwrap();
    }

    #[tokio::test]
    async fn a_file_larger_than_one_part_comes_back_whole() {
        let root = std::env::temp_dir().join(format!("veloid-files-{}", Uuid::now_v7()));
        let memory = "memory:///".parse().unwrap();
        let files = Files::at(&memory, &root).await.unwrap();
        let mut incoming = files.begin().await.unwrap();
        let block: Vec<u8> = (0..1 << 20).map(|i: u32| i.to_le_bytes()[1]).collect();
        for _ in 0..25 {
            incoming.write(&block).await.unwrap();
        }
        let kept = files.keep(incoming).await.unwrap();
        let copy = files.on_disk(&kept.sha256).await.unwrap();
        let bytes = std::fs::read(copy.path()).unwrap();
        assert_eq!(hex(&Sha256::digest(bytes)), kept.sha256);
        drop(copy);
        let left = std::fs::read_dir(&files.incoming).unwrap().count();
        assert_eq!(left, 0, "a copy goes with its reader");
        std::fs::remove_dir_all(root).unwrap();
    }
}
