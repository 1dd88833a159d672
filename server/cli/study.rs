use std::io::{self, Write};
use std::path::PathBuf;

use clap::Args;
use serde_json::Map;
use veloid_engine::Ridden;
use veloid_engine::bicycle::Bike;
use veloid_engine::ride::{Ride, RideFile};

use super::CliError;
use super::identify::{Told, name, set};
use crate::options::Options;

/// Identifies several rides of one bicycle as one: what they have in common, and which ride differs.
///
/// Progress goes to stderr, a summary to stdout. Exit status: 0 done, 2 bad input, 1 anything else.
#[derive(Args)]
pub struct Study {
    /// Ride files, each a ride of its own: 2 to 64.
    #[arg(required = true, num_args = 2..=64, value_name = "RIDE")]
    rides: Vec<PathBuf>,
    /// Bike file (JSON); one for all rides, or one for each in their order where the masses differ.
    #[arg(long, required = true, value_name = "BIKE")]
    bike: Vec<PathBuf>,
    /// Where to write the report; `-` is stdout, in place of the summary.
    #[arg(long)]
    json: Option<PathBuf>,
    /// Column of a channel in every file, by header text or number, as `z_f=V2`; may be given more than once.
    #[arg(long, value_name = "CHANNEL=COLUMN")]
    map: Vec<String>,
    /// Sampling rate of files without a time column (Hz).
    #[arg(long, value_name = "HZ")]
    rate: Vec<String>,
    /// A word that stands for a missing value, as NA; may be given more than once.
    #[arg(long, value_name = "WORD", allow_hyphen_values = true)]
    missing: Vec<String>,
    /// +1: d is the deflection u - z; -1: d is a sensor's distance to the road.
    #[arg(long, allow_negative_numbers = true)]
    deflection_sign: Option<f64>,
    /// Seed of what is drawn.
    #[arg(long)]
    seed: Option<u64>,
    /// Family-wise false-alarm rate.
    #[arg(long)]
    alpha: Option<f64>,
    /// Share of every ride, at its end, on which nothing is fitted.
    #[arg(long)]
    held_out: Option<f64>,
}

impl Study {
    pub fn run(self) -> Result<(), CliError> {
        let options = self.options()?;
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
        let progress = Told::new(&options.settings);
        let report = veloid_engine::study(&ridden, &options.settings, &progress)?;
        let json = || serde_json::to_string_pretty(&report);
        match &self.json {
            Some(path) if path.as_os_str() == "-" => writeln!(io::stdout(), "{}", json()?)?,
            other => {
                if let Some(path) = other {
                    std::fs::write(path, json()? + "\n").map_err(CliError::of_file(path))?;
                }
                write!(io::stdout(), "{}", report.summary())?;
            }
        }
        Ok(())
    }

    /// One bicycle, or as many as there are rides.
    fn bikes(&self) -> Result<Vec<Bike>, CliError> {
        if self.bike.len() != 1 && self.bike.len() != self.rides.len() {
            return Err(CliError::Bikes {
                bikes: self.bike.len(),
                rides: self.rides.len(),
            });
        }
        let read = |path: &PathBuf| {
            let text = std::fs::read_to_string(path).map_err(CliError::of_file(path))?;
            Bike::from_json(&text).map_err(|source| CliError::Bike {
                path: path.clone(),
                source,
            })
        };
        self.bike.iter().map(read).collect()
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

    fn options(&self) -> Result<Options, CliError> {
        let mut document = Map::new();
        let given = [
            ("map", &self.map),
            ("rate_hz", &self.rate),
            ("missing", &self.missing),
        ];
        for (key, texts) in given {
            for text in texts {
                Options::add_pair(&mut document, key, text)?;
            }
        }
        let mut options = Options::try_from(document)?;
        set(&mut options.reading.deflection_sign, self.deflection_sign);
        set(&mut options.settings.seed, self.seed);
        set(&mut options.settings.alpha, self.alpha);
        set(&mut options.settings.held_out, self.held_out);
        Ok(options)
    }
}
