use std::path::PathBuf;

use clap::Args;

use super::CliError;
use super::storage::Storage;
use super::vault::{Fresh, Vault};

/// Copies the database and the raw files into a new folder while the server runs.
///
/// The copy contains everything acknowledged before it begins. With PostgreSQL use pg_dump.
#[derive(Args)]
pub struct Backup {
    #[command(flatten)]
    storage: Storage,
    /// Where to write the backup: a new or empty folder.
    folder: PathBuf,
}

impl Backup {
    pub async fn run(self) -> Result<(), CliError> {
        let from = self.storage.vault().await?;
        let fresh = Fresh::at(&self.folder).await?;
        // What is in the copied database must not be erased before it is copied too.
        let _lock = self.storage.lock_for_erasure()?;
        let copy = async {
            let to = Vault::in_folder(&self.folder).await?;
            from.copy_to(&to, Some(&self.folder)).await
        };
        let copied = fresh.fill(from.bytes().await?, copy).await?;
        println!("{}: {}", self.folder.display(), copied.all()?);
        Ok(())
    }
}
