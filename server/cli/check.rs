use clap::Args;

use super::CliError;
use super::keeping::Keeping;
use super::prune::by_command;
use super::storage::Storage;
use crate::erasure::Prune;

/// Checks the raw files against the database, and a SQLite database for damage.
///
/// Prints one line for each problem: files that are missing, were altered or belong to no ride, jobs that succeeded without a
/// report, faults of the database. Exit status: the number of problems, at most 100. A server may be running.
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
}
