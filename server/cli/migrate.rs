use clap::Args;

use super::CliError;
use super::storage::Storage;

/// Brings the database schema up to date.
#[derive(Args)]
pub struct Migrate {
    #[command(flatten)]
    storage: Storage,
}

impl Migrate {
    pub async fn run(self) -> Result<(), CliError> {
        self.storage.begin().await?;
        println!("schema is up to date");
        Ok(())
    }
}
