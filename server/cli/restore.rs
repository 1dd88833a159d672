use std::path::PathBuf;

use clap::Args;

use super::CliError;
use super::storage::Storage;
use super::vault::{DATABASE, Vault};

/// Copies what `veloid backup` wrote into an empty data folder.
///
/// A server that is started there afterwards takes up the jobs that had not ended.
#[derive(Args)]
pub struct Restore {
    #[command(flatten)]
    storage: Storage,
    /// The folder that the backup was written into.
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
