use std::path::PathBuf;

use clap::Args;
use veloid_engine::Ridden;
use veloid_engine::bicycle::Bike;
use veloid_engine::ride::{Ride, RideFile};

use super::CliError;
use super::arguments::{Arguments, name, read_bike};
use super::progress::ProgressLine;
use crate::options::Options;

/// Identifies several rides of one bicycle jointly: what they have in common, and which ride differs.
///
/// Progress goes to stderr, a summary to stdout. Exit status: 0 done, 2 bad input, 1 anything else.
#[derive(Args)]
pub struct Study {
    /// Ride files, each a separate ride: 2 to 64.
    #[arg(required = true, num_args = 2..=64, value_name = "RIDE")]
    rides: Vec<PathBuf>,
    /// Bike file (JSON): one for all rides, or one for each, in the same order, if the masses differ.
    #[arg(long, required = true, value_name = "BIKE")]
    bike: Vec<PathBuf>,
    #[command(flatten)]
    arguments: Arguments,
    /// Column of a channel in every file, by header text or number, such as `z_f=V2`; may be given more than once.
    #[arg(long, value_name = "CHANNEL=COLUMN")]
    map: Vec<String>,
    /// Sampling rate of files without a time column (Hz).
    #[arg(long, value_name = "HZ")]
    rate: Vec<String>,
}

impl Study {
    pub fn run(self) -> Result<(), CliError> {
        let options = (self.arguments).options(&[("map", &self.map), ("rate_hz", &self.rate)])?;
        options.validate()?;
        let bikes = self.bikes()?;
        let rides = self.rides(&bikes, &options)?;
        let ridden: Vec<Ridden> = (self.rides.iter().zip(&rides).enumerate())
            .map(|(i, (path, ride))| Ridden {
                name: name(path, &self.rides),
                ride,
                bike: &bikes[i % bikes.len()],
            })
            .collect();
        let progress = ProgressLine::new(&options.settings);
        let report = veloid_engine::study(&ridden, &options.settings, &progress)?;
        self.arguments.write(&report, &report.summary())
    }

    /// One bicycle, or as many as there are rides.
    fn bikes(&self) -> Result<Vec<Bike>, CliError> {
        if self.bike.len() != 1 && self.bike.len() != self.rides.len() {
            return Err(CliError::Bikes {
                bikes: self.bike.len(),
                rides: self.rides.len(),
            });
        }
        self.bike.iter().map(|path| read_bike(path)).collect()
    }

    fn rides(&self, bikes: &[Bike], options: &Options) -> Result<Vec<Ride>, CliError> {
        let read = |(i, path): (usize, &PathBuf)| {
            let bytes = std::fs::read(path).map_err(CliError::of_file(path))?;
            let name = name(path, &self.rides);
            let file = RideFile::new(&name, &bytes);
            Ok(veloid_engine::read(
                &[file],
                &bikes[i % bikes.len()],
                &options.reading,
            )?)
        };
        self.rides.iter().enumerate().map(read).collect()
    }
}
