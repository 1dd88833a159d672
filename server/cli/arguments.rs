use std::io::{self, Write};
use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;
use serde_json::Map;
use veloid_engine::bicycle::Bike;

use super::CliError;
use crate::options::Options;

/// What one ride and several are arguments alike.
#[derive(Args)]
pub struct Arguments {
    /// Where to write the report; `-` is stdout, instead of the summary.
    #[arg(long)]
    json: Option<PathBuf>,
    /// Word for a missing value, such as NA; may be given more than once.
    #[arg(long, value_name = "WORD", allow_hyphen_values = true)]
    missing: Vec<String>,
    /// +1: d is the deflection u - z; -1: d is a sensor's distance to the road.
    #[arg(long, allow_negative_numbers = true)]
    deflection_sign: Option<f64>,
    /// Seed of the random numbers.
    #[arg(long)]
    seed: Option<u64>,
    /// Significance level of the diagnosis's tests. False alarms are rarer, since the held-out part has to confirm them
    /// (measured: docs/calibration.md).
    #[arg(long)]
    alpha: Option<f64>,
    /// Share of a ride, at its end, on which nothing is fitted.
    #[arg(long)]
    held_out: Option<f64>,
}

impl Arguments {
    /// Options with what is arguments here and the texts of further ones, by key.
    pub fn options(&self, given: &[(&str, &Vec<String>)]) -> Result<Options, CliError> {
        let mut options = options(&[given, &[("missing", &self.missing)]].concat())?;
        set(&mut options.reading.deflection_sign, self.deflection_sign);
        set(&mut options.settings.seed, self.seed);
        set(&mut options.settings.alpha, self.alpha);
        set(&mut options.settings.held_out, self.held_out);
        Ok(options)
    }

    /// The report to where it is wanted, and the summary to stdout unless the report goes there.
    pub fn write(&self, report: &impl Serialize, summary: &str) -> Result<(), CliError> {
        write(self.json.as_deref(), report, summary)
    }
}

/// Options from the texts of arguments, by key.
pub fn options(given: &[(&str, &Vec<String>)]) -> Result<Options, CliError> {
    let mut document = Map::new();
    for (key, texts) in given {
        for text in *texts {
            Options::add_pair(&mut document, key, text)?;
        }
    }
    Ok(Options::try_from(document)?)
}

/// A document to its file, and the summary to stdout unless the document goes there (`-`).
pub fn write(
    json: Option<&Path>,
    document: &impl Serialize,
    summary: &str,
) -> Result<(), CliError> {
    let text = || serde_json::to_string_pretty(document);
    match json {
        Some(path) if path.as_os_str() == "-" => writeln!(io::stdout(), "{}", text()?)?,
        other => {
            if let Some(path) = other {
                std::fs::write(path, text()? + "\n").map_err(CliError::of_file(path))?;
            }
            write!(io::stdout(), "{summary}")?;
        }
    }
    Ok(())
}

pub fn read_bike(path: &Path) -> Result<Bike, CliError> {
    let text = std::fs::read_to_string(path).map_err(CliError::of_file(path))?;
    Bike::from_json(&text).map_err(|source| CliError::Bike {
        path: path.to_owned(),
        source: source.into(),
    })
}

/// What a file is called: the whole path where it is alone or another file has the same name, else its name.
pub fn name(path: &Path, all: &[PathBuf]) -> String {
    let alike = all
        .iter()
        .filter(|other| other.file_name() == path.file_name());
    match path.file_name() {
        Some(name) if all.len() > 1 && alike.count() == 1 => name.to_string_lossy().into_owned(),
        _ => path.display().to_string(),
    }
}

pub fn set<T>(slot: &mut T, value: Option<T>) {
    if let Some(value) = value {
        *slot = value;
    }
}
