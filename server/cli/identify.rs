use std::io::{self, Write};
use std::path::PathBuf;
use std::sync::Mutex;
use std::time::Instant;

use clap::{Args, ValueEnum};
use veloid_engine::bicycle::Bike;
use veloid_engine::ride;
use veloid_engine::{Objective, Progress, Settings};

use super::CliError;
use super::summary::summary;
use crate::options::{Options, channel_and_column, once, rows};

/// Identifies one ride from start to finish, without a server.
///
/// Progress goes to stderr, a summary to stdout. Exit status: 0 done, 2 bad input, 1 anything else.
#[derive(Args)]
pub struct Identify {
    /// Ride file: CSV (also gzip or zstd) or MATLAB v5/v7.
    ride: PathBuf,
    /// Bike file (JSON).
    #[arg(long)]
    bike: PathBuf,
    /// Where to write the report; `-` is stdout, in place of the summary.
    #[arg(long)]
    json: Option<PathBuf>,
    /// Column of a channel, by header text or number, as `z_f=V2`; may be given more than once.
    #[arg(long, value_name = "CHANNEL=COLUMN")]
    map: Vec<String>,
    /// Sampling rate of a file without a time column (Hz).
    #[arg(long, value_name = "HZ")]
    rate: Option<f64>,
    /// Data rows to use, counted from 0, the second exclusive.
    #[arg(long, value_name = "FROM:TO")]
    rows: Option<String>,
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
        let bytes = std::fs::read(&self.ride).map_err(|source| CliError::File {
            path: self.ride.clone(),
            source,
        })?;
        let name = self.ride.display().to_string();
        let ride = ride::read(&bytes, &name, &bike, &options.reading)?;
        drop(bytes);
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

    fn options(&self) -> Result<Options, CliError> {
        let mut options = Options::default();
        let reading = &mut options.reading;
        for text in &self.map {
            let (channel, column) = channel_and_column(text)?;
            let before = reading.map.insert(channel.clone(), column.clone());
            once(channel, before.as_deref(), column)?;
        }
        reading.rate_hz = self.rate;
        reading.rows = self.rows.as_deref().map(rows).transpose()?;
        set(&mut reading.deflection_sign, self.deflection_sign);
        let settings = &mut options.settings;
        set(&mut settings.seed, self.seed);
        set(&mut settings.trials, self.trials);
        set(&mut settings.particles, self.particles);
        set(&mut settings.iterations, self.iterations);
        set(&mut settings.search_factor, self.search_factor);
        set(&mut settings.alpha, self.alpha);
        set(&mut settings.held_out, self.held_out);
        set(&mut settings.materiality, self.materiality);
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

fn set<T>(slot: &mut T, value: Option<T>) {
    if let Some(value) = value {
        *slot = value;
    }
}

/// Tells stderr how far it is.
struct Told {
    begin: Instant,
    trials: usize,
    iterations: usize,
    done: Mutex<usize>,
}

impl Told {
    fn new(settings: &Settings) -> Self {
        Self {
            begin: Instant::now(),
            trials: settings.trials,
            iterations: settings.iterations,
            done: Mutex::new(0),
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
}
