use clap::Args;

use super::CliError;
use super::storage::Storage;

/// Joins a database and a store of raw files into one installation, unchanged.
///
/// For raw files whose database is lost, a folder that was copied without its id, or an upgrade that `serve` refuses. Neither
/// rides nor files are changed; `veloid check` lists what does not match. No server may run on either.
#[derive(Args)]
pub struct Adopt {
    #[command(flatten)]
    storage: Storage,
    /// Give both a new id, separate from the installation they were copied from.
    #[arg(long)]
    new: bool,
}

impl Adopt {
    pub async fn run(self) -> Result<(), CliError> {
        let id = self.storage.adopt(self.new).await?;
        println!("database and raw files are now installation {id}");
        Ok(())
    }
}
