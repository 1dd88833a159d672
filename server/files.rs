//! The raw files, each named by the SHA-256 of its bytes: in a folder, or in object storage that
//! many machines reach. A file arrives under a temporary name on this machine; before anyone hears of
//! it, it is synced, renamed and the folder synced, or the object storage has said that it has it.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, SystemTime};

use axum::body::Bytes;
use futures_util::stream::BoxStream;
use futures_util::{Stream, StreamExt, TryStreamExt};
use object_store::buffered::BufWriter;
use object_store::local::LocalFileSystem;
use object_store::prefix::PrefixStore;
use object_store::{ObjectStore, ObjectStoreExt};
use sha2::{Digest, Sha256};
use tokio::fs::{self, File};
use tokio::io::AsyncWriteExt;
use url::Url;
use uuid::Uuid;

/// A temporary file this old was left behind by a process that is gone.
const STALE: Duration = Duration::from_secs(24 * 3600);

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

    pub async fn read(&self, sha256: &str) -> io::Result<Vec<u8>> {
        Ok(self.kept.get(&name(sha256)).await?.bytes().await?.into())
    }

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

/// The folder of files on their way, cleared of what crashed uploads left.
async fn incoming(root: &Path) -> io::Result<PathBuf> {
    let folder = root.join("incoming");
    fs::create_dir_all(&folder).await?;
    let mut entries = fs::read_dir(&folder).await?;
    while let Some(entry) = entries.next_entry().await? {
        let modified = entry.metadata().await?.modified()?;
        if SystemTime::now()
            .duration_since(modified)
            .is_ok_and(|age| age > STALE)
        {
            fs::remove_file(entry.path()).await?;
        }
    }
    Ok(folder)
}

/// A file that is safe.
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
        assert_eq!(incoming.contents().await.unwrap(), b"abc");
        let kept = files.keep(incoming).await.unwrap();
        assert_eq!(
            kept.sha256,
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
        );
        assert_eq!(kept.bytes, 3);
        assert_eq!(files.read(&kept.sha256).await.unwrap(), b"abc");
        let chunks = files.stream(&kept.sha256).await.unwrap();
        let chunks: Vec<Bytes> = chunks.try_collect().await.unwrap();
        assert_eq!(chunks.concat(), b"abc");
        drop(files.begin().await.unwrap());
        let left = std::fs::read_dir(&files.incoming).unwrap().count();
        assert_eq!(left, 0, "what is kept or abandoned is no longer on its way");
        let missing = files.read("0").await.unwrap_err();
        assert_eq!(missing.kind(), io::ErrorKind::NotFound);
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
        assert_eq!(
            hex(&Sha256::digest(files.read(&kept.sha256).await.unwrap())),
            kept.sha256
        );
        std::fs::remove_dir_all(root).unwrap();
    }
}
