use std::path::PathBuf;

use clap::Args;

use super::CliError;
use super::manifest::{DATABASE, MANIFEST, Manifest};
use super::storage::Storage;
use super::vault::Vault;

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
        match Manifest::read(&self.folder).await? {
            Some(manifest) => self.is_as_written(&manifest).await?,
            None => eprintln!(
                "veloid: {}: there is no {MANIFEST}, so the database is not compared with what was written",
                self.folder.display()
            ),
        }
        let fresh = self.storage.fresh().await?;
        let from = Vault::in_folder(&self.folder).await?;
        let copy = async {
            let to = self.storage.vault_to_fill().await?;
            from.copy_to(&to, None).await
        };
        let copied = fresh.fill(from.bytes().await?, copy).await?;
        println!("restored: {}", copied.all()?);
        Ok(())
    }

    async fn is_as_written(&self, manifest: &Manifest) -> Result<(), CliError> {
        let faults = manifest.faults_without_raw_files(&self.folder).await?;
        for fault in &faults {
            eprintln!("veloid: {fault}");
        }
        let (folder, count) = (self.folder.clone(), faults.len());
        match count {
            0 => Ok(()),
            count => Err(CliError::NotAsWritten { folder, count }),
        }
    }
}
