//! The id of the one installation that a store of raw files belongs to: an object of the store whose name cannot be
//! that of a raw file.

use std::io;

use futures_util::TryStreamExt;
use sha2::{Digest, Sha256};
use uuid::Uuid;

use super::{Files, hex, in_store};
use crate::exchanged::Exchanged;

pub const MARKER: &str = "installation";

impl Files {
    /// The id that the store has.
    pub async fn installation(&self) -> io::Result<Option<Uuid>> {
        let mut stream = match in_store!(&self.kept, store => store.get(MARKER).await) {
            Ok(found) => found,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(error),
        };
        let mut bytes = Vec::new();
        while let Some(chunk) = stream.try_next().await? {
            bytes.extend_from_slice(&chunk);
        }
        let text = String::from_utf8_lossy(&bytes);
        let id = Uuid::try_parse(text.trim());
        let bad = |error| {
            let bytes = bytes.len();
            let text = format!("`{MARKER}` ({bytes} bytes) contains no UUID: {error}");
            io::Error::new(io::ErrorKind::InvalidData, text)
        };
        id.map(Some).map_err(bad)
    }

    /// From now on the store must have this id.
    pub fn belong_to(&self, id: Uuid) {
        let _ = self.owner.set(id);
    }

    /// The id that the store must have.
    pub fn owner(&self) -> Option<Uuid> {
        self.owner.get().copied()
    }

    /// Whether the store has the id that it must have.
    pub async fn check(&self) -> Result<(), Exchanged> {
        let Some(owner) = self.owner() else {
            return Ok(());
        };
        let why = match self.installation().await {
            Ok(Some(found)) if found == owner => return Ok(()),
            Ok(Some(found)) => format!("it belongs to installation {found}"),
            Ok(None) => "it is empty or missing".to_owned(),
            Err(error) => format!("its id cannot be read: {error}"),
        };
        Err(Exchanged::Store(format!(
            "{why}; mount or put back that of installation {owner}"
        )))
    }

    /// Gives the store an id unless it has one; the id that it then has.
    pub async fn keep_installation(&self, id: Uuid) -> io::Result<Uuid> {
        match in_store!(&self.kept, store => store.put_new(MARKER, text(id)).await) {
            Ok(()) => Ok(id),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
                let found = self.installation().await?;
                found.ok_or_else(|| io::ErrorKind::NotFound.into())
            }
            Err(error) => Err(error),
        }
    }

    /// Gives the store this id in place of any other; the SHA-256 of the object that has it.
    pub async fn replace_installation(&self, id: Uuid) -> io::Result<String> {
        self.remove(MARKER).await?;
        let id = self.keep_installation(id).await?;
        Ok(hex(&Sha256::digest(text(id))))
    }
}

fn text(id: Uuid) -> Vec<u8> {
    format!("{id}\n").into_bytes()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[tokio::test]
    async fn a_store_keeps_its_first_id_until_it_is_replaced() {
        let root = std::env::temp_dir().join(format!("veloid-marker-{}", Uuid::now_v7()));
        let folder = Files::in_folder(&root).await.unwrap();
        let mut stores = vec![folder.clone()];
        if cfg!(feature = "s3") {
            let memory = "memory:///".parse().unwrap();
            stores.push(Files::at(&memory, &root).await.unwrap());
        }
        for files in stores {
            let [a, b] = [1, 2].map(Uuid::from_u128);
            assert_eq!(files.installation().await.unwrap(), None);
            assert_eq!(files.keep_installation(a).await.unwrap(), a);
            assert_eq!(files.keep_installation(b).await.unwrap(), a);
            files.replace_installation(b).await.unwrap();
            assert_eq!(files.installation().await.unwrap(), Some(b));
            assert!(!files.has_any().await.unwrap(), "it is no raw file");
        }
        let entries = std::fs::read_dir(root.join("rides")).unwrap().count();
        assert_eq!(entries, 1);
        assert_eq!(folder.check().await, Ok(()), "none is expected");
        folder.belong_to(Uuid::from_u128(2));
        assert_eq!(folder.check().await, Ok(()));
        folder
            .replace_installation(Uuid::from_u128(3))
            .await
            .unwrap();
        assert!(folder.check().await.is_err(), "another installation's");
        std::fs::write(root.join("rides").join(MARKER), "?").unwrap();
        let error = folder.installation().await.unwrap_err();
        assert!(error.to_string().contains("1 bytes"), "{error}");
        std::fs::remove_dir_all(root).unwrap();
    }
}
