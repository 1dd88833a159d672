use std::path::PathBuf;

use clap::Args;

use super::CliError;
use super::storage::Storage;
use super::vault::{DATABASE, Vault};

/// Copies a backup of `veloid backup` into an empty data folder.
///
/// A server started there afterwards resumes unfinished jobs.
#[derive(Args)]
pub struct Restore {
    #[command(flatten)]
    storage: Storage,
    /// The folder of the backup.
    folder: PathBuf,
}

impl Restore {
    pub async fn run(self) -> Result<(), CliError> {
        let database = self.folder.join(DATABASE);
        if !database.is_file() {
            return Err(CliError::NoDatabase(database));
        }
        let to = self.storage.empty_vault().await?;
        let from = Vault::in_folder(&self.folder).await?;
        println!("restored: {}", from.copy_to(&to).await?);
        Ok(())
    }
}
