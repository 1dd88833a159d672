use clap::Args;

use super::CliError;
use super::keeping::Keeping;
use super::prune::by_command;
use super::storage::Storage;
use crate::erasure::Prune;

/// Holds raw files and rows against each other, and SQLite's database against itself.
///
/// Says in a line each: files that are missing, were altered or belong to no ride, jobs that succeeded without a
/// report, faults of the database. Exit status: how many, at most 100. A server may run meanwhile.
#[derive(Args)]
pub struct Check {
    #[command(flatten)]
    storage: Storage,
    /// Remove files that no ride has for an hour. What else is found needs somebody who knows more: a lost file is
    /// back when it is uploaded again.
    #[arg(long)]
    repair: bool,
}

impl Check {
    pub async fn run(self) -> Result<(), CliError> {
        let policy = Keeping::default().policy();
        let scrub = async |prune: &Prune<'_>| prune.scrub().await;
        match by_command(&self.storage, &policy, !self.repair, scrub).await? {
            0 => {
                println!("nothing is wrong");
                Ok(())
            }
            found => Err(CliError::Found(found)),
        }
    }
}
