use std::path::PathBuf;

use clap::Args;

use super::CliError;
use super::storage::Storage;
use super::vault::{Vault, is_empty};

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
        if !is_empty(&self.folder).await? {
            return Err(CliError::NotEmpty(self.folder));
        }
        // What is in the copied database must not be erased before it is copied too.
        let _lock = self.storage.lock_for_erasure()?;
        let copied = from.copy_to(&Vault::in_folder(&self.folder).await?).await?;
        println!("{}: {copied}", self.folder.display());
        Ok(())
    }
}
