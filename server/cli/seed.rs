use std::time::Instant;

use clap::Args;

use super::CliError;
use super::storage::Storage;
use crate::store::ride;
use crate::store::season::{Season, Told};

/// Fills the database with a made-up season, to measure and to try the fleet's pages with.
///
/// Every bicycle rides now and then over the last 180 days. The first one's front tyre loses pressure,
/// the second one's rear tyre is changed at midsummer, the third one is much softer than the fleet.
/// The rides are only told of: they have parameters, but neither files nor reports.
#[derive(Args)]
pub struct Seed {
    #[command(flatten)]
    storage: Storage,
    /// Bicycles.
    #[arg(long, default_value_t = 40, value_parser = clap::value_parser!(u32).range(1..=1000))]
    bikes: u32,
    /// Rides of all bicycles together.
    #[arg(long, default_value_t = 1000, value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    rides: u32,
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Fill a database that holds real rides too.
    #[arg(long)]
    beside_real: bool,
}

impl Seed {
    pub async fn run(self) -> Result<(), CliError> {
        let (db, _files) = self.storage.open().await?;
        let real = ride::real(&db).await?;
        if real > 0 && !self.beside_real {
            return Err(CliError::RealRides(real));
        }
        let begin = Instant::now();
        let season = Season::new(self.bikes, self.rides, self.seed);
        let Told { rides, parameters } = season.tell(&db).await?;
        println!(
            "{rides} rides of {} bicycles with {parameters} parameters, in {:.1} s",
            self.bikes,
            begin.elapsed().as_secs_f64()
        );
        Ok(())
    }
}
