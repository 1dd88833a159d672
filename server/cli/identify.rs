use std::path::PathBuf;

use clap::{Args, ValueEnum};
use veloid_engine::Objective;
use veloid_engine::bicycle::Bike;
use veloid_engine::report::{Report, summary};
use veloid_engine::ride::{Ride, RideFile};

use super::CliError;
use super::arguments::{Arguments, name, read_bike, set};
use super::loggers::of_folder;
use super::progress::ProgressLine;
use super::unread::explained;
use crate::export::{self, Format, IdentifiedModel};
use crate::options::Options;

/// Identifies one ride, without a server.
///
/// Progress goes to stderr, a summary to stdout. Exit status: 0 done, 2 bad input, 1 anything else.
#[derive(Args)]
pub struct Identify {
    /// Ride file: CSV (also gzip or zstd) or MATLAB v4 to v7. Several files are one ride, each on its own clock.
    #[arg(required = true, value_name = "RIDE")]
    rides: Vec<PathBuf>,
    /// Bike file (JSON).
    #[arg(long)]
    bike: PathBuf,
    #[command(flatten)]
    arguments: Arguments,
    /// Column of a channel, by header text or number, such as `z_f=V2`; may be given more than once. With a leading file name
    /// it is that file's column, otherwise that of any file with this column.
    #[arg(long, value_name = "[FILE:]CHANNEL=COLUMN")]
    map: Vec<String>,
    /// Sampling rate of a file without a time column (Hz).
    #[arg(long, value_name = "[FILE:]HZ")]
    rate: Vec<String>,
    /// Data rows to use, counted from 0, the second exclusive.
    #[arg(long, value_name = "[FILE:]FROM:TO")]
    rows: Vec<String>,
    /// How the table of a text file is laid out, where that is found wrong: `header_row=3`, `units_row=4` (0 for none), `first_row=6`,
    /// `separator=;` (or `tab`, `blanks`), `decimal=,`, `time_format=%d/%m/%Y %H:%M:%S%.f`; may be given more than once.
    #[arg(long, value_name = "[FILE:]KEY=VALUE")]
    layout: Vec<String>,
    /// How much later a file begins (s) than its time stamps state, or than the other files where the stamps have no date.
    #[arg(long, value_name = "FILE:SECONDS")]
    offset: Vec<String>,
    /// Folder with descriptions of further loggers (TOML): see docs/loggers.md.
    #[arg(long, value_name = "FOLDER")]
    loggers: Option<PathBuf>,
    /// Swarm trials.
    #[arg(long)]
    trials: Option<usize>,
    /// Particles of a swarm.
    #[arg(long)]
    particles: Option<usize>,
    /// Iterations of a swarm.
    #[arg(long)]
    iterations: Option<usize>,
    /// Objective that the swarm minimises.
    #[arg(long, value_enum)]
    objective: Option<ObjectiveArg>,
    /// Bound f on the jerk of the observer (m/s^3); estimated when absent.
    #[arg(long)]
    jerk_bound: Option<f64>,
    /// Search box: a factor around the instrumental-variable estimate, both ways.
    #[arg(long)]
    search_factor: Option<f64>,
    /// Do not search for missing physics.
    #[arg(long)]
    no_diagnosis: bool,
    /// Smallest share of the held-out error that a material effect removes.
    #[arg(long)]
    materiality: Option<f64>,
    /// Integrator steps that the search for missing physics may take per sample of an axle.
    #[arg(long)]
    search_budget: Option<f64>,
    /// Custom law (TOML) to test in addition to the library: see docs/own-law.md.
    #[arg(long, value_name = "FILE")]
    law: Option<PathBuf>,
    /// Stiffness k (N/m) or damping B (N s/m) of an axle (f, r) that the fits hold, such as `f.k=60000`; may be given more than once.
    #[arg(long, value_name = "AXLE.QUANTITY=VALUE")]
    fix: Vec<String>,
    /// Bounds of k (N/m) or B (N s/m) of an axle, such as `r.B=0:2000`; may be given more than once.
    #[arg(long, value_name = "AXLE.QUANTITY=LOW:HIGH")]
    bound: Vec<String>,
    /// Where to write the identified model: a script that simulates it (.py, .m), its numbers and laws (.json), or the ride for such
    /// a script (.csv); may be given more than once.
    #[arg(long, value_name = "FILE", value_parser = model_file)]
    model: Vec<(PathBuf, Format)>,
    /// Where to write what every set of effects leaves of held-out windows of a bench record (JSON), and nothing else: the evidence on
    /// which rules of a verdict can be tried (docs/decisions/judge.md).
    #[arg(long, value_name = "FILE", conflicts_with_all = ["model", "json"])]
    scores: Option<PathBuf>,
}

fn model_file(text: &str) -> Result<(PathBuf, Format), String> {
    let path = PathBuf::from(text);
    match Format::of(&path) {
        Some(format) => Ok((path, format)),
        None => Err("expected a name that ends in .json, .m, .py or .csv".to_owned()),
    }
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
        let bike = read_bike(&self.bike)?;
        let ride = self.ride(&bike, &options)?;
        let progress = ProgressLine::new(&options.settings);
        // What the reader doubted may be why nothing came of the ride.
        let doubts = |_: &_| {
            for assumed in &ride.summary.reading {
                eprintln!("read: {assumed}");
            }
            for warning in &ride.summary.warnings {
                eprintln!("warning: {warning}");
            }
        };
        if let Some(path) = &self.scores {
            let scores = veloid_engine::scores(&ride, &bike, &options.settings, &progress)
                .inspect_err(doubts)?;
            if scores.iter().next().is_none() {
                eprintln!(
                    "warning: no scores: a road drives every axle, or the record is too short for windows"
                );
            }
            let text = serde_json::to_string(&scores)?;
            return std::fs::write(path, text).map_err(CliError::of_file(path));
        }
        let report = veloid_engine::identify(&ride, &bike, &options.settings, &progress)
            .inspect_err(doubts)?;
        self.arguments.write(&report, &summary(&report))?;
        for (path, format) in &self.model {
            let text = self.model_text(*format, &report, &ride)?;
            std::fs::write(path, text).map_err(CliError::of_file(path))?;
        }
        Ok(())
    }

    fn model_text(&self, format: Format, report: &Report, ride: &Ride) -> Result<String, CliError> {
        let file = name(&self.rides[0], &self.rides);
        Ok(match format {
            Format::Json => serde_json::to_string_pretty(&IdentifiedModel::of(report.clone()))?,
            Format::Matlab => export::matlab(report, &file)?,
            Format::Python => export::python(report, &file)?,
            Format::Csv => export::table(ride),
        })
    }

    fn ride(&self, bike: &Bike, options: &Options) -> Result<Ride, CliError> {
        let read = |path: &PathBuf| {
            let name = name(path, &self.rides);
            let bytes = std::fs::read(path).map_err(CliError::of_file(path))?;
            Ok((name, bytes))
        };
        let files = self.rides.iter().map(read);
        let files = files.collect::<Result<Vec<_>, CliError>>()?;
        let files: Vec<RideFile<'_>> = (files.iter())
            .map(|(name, bytes)| RideFile::new(name, bytes))
            .collect();
        veloid_engine::read(&files, bike, &options.reading)
            .map_err(|fault| explained(fault, &files, &options.reading))
    }

    fn options(&self) -> Result<Options, CliError> {
        let mut options = self.arguments.options(&[
            ("map", &self.map),
            ("rate_hz", &self.rate),
            ("rows", &self.rows),
            ("layout", &self.layout),
            ("offset_s", &self.offset),
            ("fix", &self.fix),
            ("bound", &self.bound),
        ])?;
        if let Some(folder) = &self.loggers {
            options.reading.loggers = of_folder(folder)?;
        }
        let settings = &mut options.settings;
        set(&mut settings.trials, self.trials);
        set(&mut settings.particles, self.particles);
        set(&mut settings.iterations, self.iterations);
        set(&mut settings.search_factor, self.search_factor);
        set(&mut settings.materiality, self.materiality);
        set(&mut settings.search_budget, self.search_budget);
        settings.law = (self.law.as_ref())
            .map(|path| std::fs::read_to_string(path).map_err(CliError::of_file(path)))
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
