//! Raw files in object storage that many machines reach.

use std::io;
use std::path::Path;
use std::sync::Arc;

use axum::body::Bytes;
use futures_util::stream::BoxStream;
use futures_util::{StreamExt, TryStreamExt};
use object_store::buffered::BufWriter;
use object_store::prefix::PrefixStore;
use object_store::{Error, ObjectStore, ObjectStoreExt, PutMode};
use tokio::fs::File;
use tokio::io::AsyncWriteExt;
use url::Url;

#[derive(Clone)]
pub struct Objects(Arc<dyn ObjectStore>);

impl Objects {
    /// Opens the store at an address, with what the `AWS_*` variables say.
    pub fn open(url: &Url) -> io::Result<Self> {
        let settings = std::env::vars_os()
            .filter_map(|(key, value)| Some((key.into_string().ok()?, value.into_string().ok()?)))
            .filter(|(key, _)| key.starts_with("AWS_"));
        let (store, prefix) = object_store::parse_url_opts(url, settings)?;
        Ok(Self(Arc::new(PrefixStore::new(store, prefix))))
    }

    /// Takes a file in under a name.
    pub async fn keep(&self, path: &Path, name: &str) -> io::Result<()> {
        let mut object = BufWriter::new(Arc::clone(&self.0), name.into());
        tokio::io::copy(&mut File::open(path).await?, &mut object).await?;
        object.shutdown().await
    }

    pub async fn has(&self, name: &str) -> io::Result<bool> {
        was_there(self.0.head(&name.into()).await.map(drop))
    }

    /// Removes a file; false where it is not there.
    pub async fn remove(&self, name: &str) -> io::Result<bool> {
        was_there(self.0.delete(&name.into()).await)
    }

    /// The bytes of a file.
    pub async fn get(&self, name: &str) -> io::Result<BoxStream<'static, io::Result<Bytes>>> {
        let found = self.0.get(&name.into()).await?;
        Ok(found.into_stream().map_err(io::Error::from).boxed())
    }

    /// All files, and when they were written (epoch s).
    pub fn list(&self) -> BoxStream<'static, io::Result<(String, u64)>> {
        let all = self.0.list(None).map_err(io::Error::from);
        let named = all.map_ok(|file| {
            let written = u64::try_from(file.last_modified.timestamp());
            (file.location.to_string(), written.unwrap_or(0))
        });
        named.boxed()
    }

    /// Writes a file whose name must not be taken.
    pub async fn put_new(&self, name: &str, bytes: Vec<u8>) -> io::Result<()> {
        let options = PutMode::Create.into();
        let put = self.0.put_opts(&name.into(), bytes.into(), options).await;
        put.map(drop).map_err(|error| match error {
            Error::AlreadyExists { .. } => io::ErrorKind::AlreadyExists.into(),
            error => error.into(),
        })
    }
}

/// Whether something was there.
fn was_there(outcome: object_store::Result<()>) -> io::Result<bool> {
    match outcome {
        Ok(()) => Ok(true),
        Err(Error::NotFound { .. }) => Ok(false),
        Err(error) => Err(error.into()),
    }
}
