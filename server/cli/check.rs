use clap::Args;

use super::CliError;
use super::keeping::Keeping;
use super::manifest::{MANIFEST, Manifest};
use super::prune::by_command;
use super::storage::Storage;
use crate::erasure::Prune;

/// Checks the raw files against the database, and a SQLite database for damage.
///
/// Prints one line for each problem: files that are missing, were altered or belong to no ride, rows that are missing or do not
/// agree with others, reports that were altered, faults of the database; in a backup, what is not as it was written. Exit status:
/// the number of problems, at most 100. A server may be running.
#[derive(Args)]
pub struct Check {
    #[command(flatten)]
    storage: Storage,
    /// Remove files that have belonged to no ride for an hour. Other problems need manual work: a lost file is recovered by
    /// uploading it again.
    #[arg(long)]
    repair: bool,
}

impl Check {
    pub async fn run(self) -> Result<(), CliError> {
        if let Some(manifest) = Manifest::read(self.storage.folder()).await? {
            return self.backup(&manifest).await;
        }
        let policy = Keeping::default().policy();
        let scrub = async |prune: &Prune<'_>| prune.scrub().await;
        match by_command(&self.storage, &policy, !self.repair, scrub).await? {
            0 => {
                println!("no problems found");
                Ok(())
            }
            found => Err(CliError::Found(found)),
        }
    }

    /// A backup is compared with what was written; its database is not opened, which would alter it.
    async fn backup(&self, manifest: &Manifest) -> Result<(), CliError> {
        let faults = manifest.faults(self.storage.folder()).await?;
        for fault in &faults {
            println!("{fault}");
        }
        match faults.len() as u64 {
            0 => {
                println!("the backup is as it was written");
                Ok(())
            }
            found => {
                println!("if the folder is not a backup any more, remove its {MANIFEST}");
                Err(CliError::Found(found))
            }
        }
    }
}
