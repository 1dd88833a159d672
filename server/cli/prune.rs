use std::io::Write;

use clap::Args;

use super::CliError;
use super::keeping::Keeping;
use super::storage::Storage;
use crate::erasure::Prune;
use crate::jobs::Queue;
use crate::store::audit::Actor;

/// Erases now what was deleted long enough ago, and raw files that no ride has.
///
/// A running server does so every hour. Give it the same days as the server, or the same environment.
#[derive(Args)]
pub struct PruneNow {
    #[command(flatten)]
    storage: Storage,
    #[command(flatten)]
    keeping: Keeping,
    /// Say what would be erased, and erase nothing.
    #[arg(long)]
    dry_run: bool,
}

impl PruneNow {
    pub async fn run(self) -> Result<(), CliError> {
        let (db, files) = self.storage.open().await?;
        let _lock = self.storage.lock_for_erasure()?;
        let prune = Prune {
            queue: &Queue(db.river().build()?),
            db: &db,
            files: &files,
            policy: &self.keeping.policy(),
            actor: Actor::Command,
            dry_run: self.dry_run,
            // Nobody may be reading; what is erased does not depend on it.
            tell: &|line| drop(writeln!(std::io::stdout(), "{line}")),
        };
        let erased = prune.run().await?;
        println!(
            "{}erased: {} rides, {} jobs, {} bikes, {} raw files",
            if self.dry_run { "would be " } else { "" },
            erased.rides,
            erased.jobs,
            erased.bikes,
            erased.files
        );
        Ok(())
    }
}
