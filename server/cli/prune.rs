use std::io::Write;

use clap::Args;

use super::CliError;
use super::keeping::Keeping;
use super::storage::Storage;
use crate::erasure::{EraseError, Policy, Prune};
use crate::jobs::Queue;
use crate::store::audit::Actor;

/// Erases data whose days of grace have passed, and raw files that belong to no ride.
///
/// A running server does so every hour. Use the same days as the server, or the same environment.
#[derive(Args)]
pub struct PruneNow {
    #[command(flatten)]
    storage: Storage,
    #[command(flatten)]
    keeping: Keeping,
    /// Report what would be erased, without erasing it.
    #[arg(long)]
    dry_run: bool,
}

/// Has work done on a storage that nobody else erases from meanwhile; what it shows goes to the standard output.
pub async fn by_command<T>(
    storage: &Storage,
    policy: &Policy,
    dry_run: bool,
    work: impl AsyncFnOnce(&Prune<'_>) -> Result<T, EraseError>,
) -> Result<T, CliError> {
    let (db, files) = storage.open().await?;
    let _lock = storage.lock_for_erasure()?;
    let prune = Prune {
        queue: &Queue(db.river().build()?),
        db: &db,
        files: &files,
        policy,
        actor: Actor::Command,
        dry_run,
        // Nobody may be reading; what is done does not depend on it.
        note: &|line| drop(writeln!(std::io::stdout(), "{line}")),
    };
    Ok(work(&prune).await?)
}

impl PruneNow {
    pub async fn run(self) -> Result<(), CliError> {
        let policy = self.keeping.policy();
        let erase = async |prune: &Prune<'_>| prune.run().await;
        let erased = by_command(&self.storage, &policy, self.dry_run, erase).await?;
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
