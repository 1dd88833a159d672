use clap::Args;

use super::CliError;
use super::storage::Storage;

/// Makes a database and a store of raw files one installation, as they are.
///
/// For raw files whose database is lost, a folder that was copied without its id, an upgrade that `serve` refuses. Neither
/// rides nor files are changed; `veloid check` lists what does not belong together. No server may run on either.
#[derive(Args)]
pub struct Adopt {
    #[command(flatten)]
    storage: Storage,
    /// Give both a new id, so that they are an installation apart from the one that they were copied from.
    #[arg(long)]
    new: bool,
}

impl Adopt {
    pub async fn run(self) -> Result<(), CliError> {
        let id = self.storage.adopt(self.new).await?;
        println!("database and raw files are installation {id}");
        Ok(())
    }
}
