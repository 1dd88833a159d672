use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use clap::{Args, ValueEnum};
use serde_json::Map;
use veloid_engine::bicycle::Bike;
use veloid_engine::report::summary;
use veloid_engine::ride::{Ride, RideFile};
use veloid_engine::{Objective, Progress, Settings};

use super::CliError;
use crate::options::Options;

/// Identifies one ride from start to finish, without a server.
///
/// Progress goes to stderr, a summary to stdout. Exit status: 0 done, 2 bad input, 1 anything else.
#[derive(Args)]
pub struct Identify {
    /// Ride file: CSV (also gzip or zstd) or MATLAB v5/v7. Several files are one ride, each on a clock of its own.
    #[arg(required = true, value_name = "RIDE")]
    rides: Vec<PathBuf>,
    /// Bike file (JSON).
    #[arg(long)]
    bike: PathBuf,
    /// Where to write the report; `-` is stdout, in place of the summary.
    #[arg(long)]
    json: Option<PathBuf>,
    /// Column of a channel, by header text or number, as `z_f=V2`; may be given more than once. With a file in front it
    /// is that file's column, else that of any file that has it.
    #[arg(long, value_name = "[FILE:]CHANNEL=COLUMN")]
    map: Vec<String>,
    /// Sampling rate of a file without a time column (Hz).
    #[arg(long, value_name = "[FILE:]HZ")]
    rate: Vec<String>,
    /// Data rows to use, counted from 0, the second exclusive.
    #[arg(long, value_name = "[FILE:]FROM:TO")]
    rows: Vec<String>,
    /// How much later a file begins than its time stamps say, or than the other files where these do not say when (s).
    #[arg(long, value_name = "FILE:SECONDS")]
    offset: Vec<String>,
    /// A word that stands for a missing value, as NA; may be given more than once.
    #[arg(long, value_name = "WORD", allow_hyphen_values = true)]
    missing: Vec<String>,
    /// +1: d is the deflection u - z; -1: d is a sensor's distance to the road.
    #[arg(long, allow_negative_numbers = true)]
    deflection_sign: Option<f64>,
    /// Seed of the first trial.
    #[arg(long)]
    seed: Option<u64>,
    /// Swarm trials.
    #[arg(long)]
    trials: Option<usize>,
    /// Particles of a swarm.
    #[arg(long)]
    particles: Option<usize>,
    /// Iterations of a swarm.
    #[arg(long)]
    iterations: Option<usize>,
    /// What the swarm minimises.
    #[arg(long, value_enum)]
    objective: Option<ObjectiveArg>,
    /// Bound f on the jerk of the observer (m/s^3); estimated when absent.
    #[arg(long)]
    jerk_bound: Option<f64>,
    /// Search box: a factor around the instrumental-variable estimate, both ways.
    #[arg(long)]
    search_factor: Option<f64>,
    /// Do not look for missing physics.
    #[arg(long)]
    no_diagnosis: bool,
    /// Family-wise false-alarm rate of the diagnosis.
    #[arg(long)]
    alpha: Option<f64>,
    /// Share of the ride, at its end, on which nothing is fitted.
    #[arg(long)]
    held_out: Option<f64>,
    /// Least share of the held-out error that a material effect removes.
    #[arg(long)]
    materiality: Option<f64>,
    /// Steps of the integrator that the search for missing physics may take for each sample of an axle.
    #[arg(long)]
    search_budget: Option<f64>,
    /// A law of one's own (TOML) that is looked for beside the library: docs/own-law.md.
    #[arg(long, value_name = "FILE")]
    law: Option<PathBuf>,
}

#[derive(Clone, Copy, ValueEnum)]
enum ObjectiveArg {
    Consistent,
    Paper,
    Gradient,
}

impl Identify {
    pub fn run(self) -> Result<(), CliError> {
        let options = self.options()?;
        options.validate()?;
        let bike = std::fs::read_to_string(&self.bike).map_err(|source| CliError::File {
            path: self.bike.clone(),
            source,
        })?;
        let bike = Bike::from_json(&bike).map_err(|source| CliError::Bike {
            path: self.bike.clone(),
            source,
        })?;
        let ride = self.ride(&bike, &options)?;
        let progress = Told::new(&options.settings);
        // What the reader doubted may be why nothing came of the ride.
        let doubts = |_: &_| {
            for warning in &ride.summary.warnings {
                eprintln!("warning: {warning}");
            }
        };
        let report = veloid_engine::identify(&ride, &bike, &options.settings, &progress)
            .inspect_err(doubts)?;
        match &self.json {
            Some(path) if path.as_os_str() == "-" => {
                writeln!(io::stdout(), "{}", serde_json::to_string_pretty(&report)?)?;
                return Ok(());
            }
            Some(path) => {
                let text = serde_json::to_string_pretty(&report)? + "\n";
                std::fs::write(path, text).map_err(|source| CliError::File {
                    path: path.clone(),
                    source,
                })?;
            }
            None => {}
        }
        write!(io::stdout(), "{}", summary(&report))?;
        Ok(())
    }

    fn ride(&self, bike: &Bike, options: &Options) -> Result<Ride, CliError> {
        let read = |path: &PathBuf| {
            let name = name(path, &self.rides);
            let bytes = std::fs::read(path).map_err(|source| CliError::File {
                path: path.clone(),
                source,
            })?;
            Ok((name, bytes))
        };
        let files = self.rides.iter().map(read);
        let files = files.collect::<Result<Vec<_>, CliError>>()?;
        let files: Vec<RideFile<'_>> = (files.iter())
            .map(|(name, bytes)| RideFile::new(name, bytes))
            .collect();
        Ok(veloid_engine::read(&files, bike, &options.reading)?)
    }

    fn options(&self) -> Result<Options, CliError> {
        let mut document = Map::new();
        for (key, texts) in [
            ("map", &self.map),
            ("rate_hz", &self.rate),
            ("rows", &self.rows),
            ("offset_s", &self.offset),
            ("missing", &self.missing),
        ] {
            for text in texts {
                Options::add_pair(&mut document, key, text)?;
            }
        }
        let mut options = Options::try_from(document)?;
        set(&mut options.reading.deflection_sign, self.deflection_sign);
        let settings = &mut options.settings;
        set(&mut settings.seed, self.seed);
        set(&mut settings.trials, self.trials);
        set(&mut settings.particles, self.particles);
        set(&mut settings.iterations, self.iterations);
        set(&mut settings.search_factor, self.search_factor);
        set(&mut settings.alpha, self.alpha);
        set(&mut settings.held_out, self.held_out);
        set(&mut settings.materiality, self.materiality);
        set(&mut settings.search_budget, self.search_budget);
        settings.law = (self.law.as_ref())
            .map(|path| {
                std::fs::read_to_string(path).map_err(|source| CliError::File {
                    path: path.clone(),
                    source,
                })
            })
            .transpose()?;
        settings.jerk_bound_m_s3 = self.jerk_bound;
        settings.diagnosis = !self.no_diagnosis;
        set(
            &mut settings.objective,
            self.objective.map(|objective| match objective {
                ObjectiveArg::Consistent => Objective::Consistent,
                ObjectiveArg::Paper => Objective::Paper,
                ObjectiveArg::Gradient => Objective::Gradient,
            }),
        );
        Ok(options)
    }
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

/// How often the search is spoken of.
const EVERY: Duration = Duration::from_secs(1);

/// Tells stderr how far it is.
pub struct Told {
    begin: Instant,
    trials: usize,
    iterations: usize,
    done: Mutex<usize>,
    /// When the search was last spoken of.
    spoke: Mutex<Instant>,
}

impl Told {
    pub fn new(settings: &Settings) -> Self {
        Self {
            begin: Instant::now(),
            trials: settings.trials,
            iterations: settings.iterations,
            done: Mutex::new(0),
            spoke: Mutex::new(Instant::now()),
        }
    }
}

impl Progress for Told {
    fn stage(&self, name: &str) {
        eprintln!("{:7.2} s  {name}", self.begin.elapsed().as_secs_f64());
    }

    fn iteration(&self, trial: usize, iteration: usize, best_cost: f64) {
        if iteration + 1 < self.iterations {
            return;
        }
        if let Ok(mut done) = self.done.lock() {
            *done += 1;
            eprintln!(
                "{:7.2} s  trial {trial}: best cost {best_cost:.6e} ({done} of {})",
                self.begin.elapsed().as_secs_f64(),
                self.trials
            );
        }
    }

    fn searched(&self, steps: u64, budget: u64) {
        let Ok(mut spoke) = self.spoke.lock() else {
            return;
        };
        if spoke.elapsed() > EVERY {
            *spoke = Instant::now();
            eprintln!(
                "{:7.2} s  searched {:.1} of {:.1} million steps that it may take",
                self.begin.elapsed().as_secs_f64(),
                1e-6 * steps as f64,
                1e-6 * budget as f64
            );
        }
    }
}
