//! `veloid bench`: how fast this machine is at what veloid does.

mod engine;
mod figure;
mod machine;
mod service;
mod table;

use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Args;
use jiff::Timestamp;
use veloid_engine::bicycle::Bike;
use veloid_engine::ride;
use veloid_engine::swarm;

use super::CliError;
use crate::options::Options;
use machine::Machine;
use table::Figures;

/// Measures this machine's performance, as a Markdown table and as JSON.
///
/// Times the engine's steps, then a server: one that it starts on a free port with a temporary data folder, or the one given by
/// `--server`.
#[derive(Args)]
pub struct Bench {
    /// Where to write the figures as JSON; `-` is stdout, instead of the table.
    #[arg(long)]
    json: Option<PathBuf>,
    /// Repetitions of each measurement.
    #[arg(long, default_value_t = 7, value_parser = clap::value_parser!(u32).range(1..=1000))]
    runs: u32,
    /// Address of a running server, such as `http://127.0.0.1:8080`.
    #[arg(long, value_name = "URL")]
    server: Option<String>,
    /// Commit of the build, reported with the figures.
    #[arg(long, env = "VELOID_COMMIT")]
    commit: Option<String>,
    /// Time only one part.
    #[arg(long, value_enum)]
    only: Option<Part>,
    /// Run only the swarm on this ride, as other implementations are timed, and print one line of JSON.
    #[arg(long, value_name = "RIDE", conflicts_with_all = ["json", "server", "only"])]
    swarm: Option<PathBuf>,
}

#[derive(Clone, Copy, PartialEq, clap::ValueEnum)]
enum Part {
    Engine,
    Service,
}

impl Bench {
    pub fn run(self) -> Result<(), CliError> {
        if let Some(path) = &self.swarm {
            return swarm_alone(path);
        }
        let runs = self.runs as usize;
        let mut figures = Vec::new();
        if self.only != Some(Part::Service) {
            eprintln!("timing the engine");
            figures.extend(engine::figures(runs)?);
        }
        if self.only != Some(Part::Engine) {
            eprintln!("timing a server");
            figures.extend(service::figures(self.server, runs)?);
        }
        let measured = Figures {
            veloid: env!("CARGO_PKG_VERSION"),
            commit: self.commit,
            date: Timestamp::now().strftime("%F").to_string(),
            machine: Machine::this(),
            figures,
        };
        let mut out = std::io::stdout();
        let json = serde_json::to_string_pretty(&measured)? + "\n";
        match self.json {
            Some(path) if path.as_os_str() == "-" => return Ok(out.write_all(json.as_bytes())?),
            Some(path) => {
                std::fs::write(&path, json).map_err(|source| CliError::File { path, source })?;
            }
            None => {}
        }
        Ok(write!(out, "{measured}")?)
    }
}

fn swarm_alone(path: &Path) -> Result<(), CliError> {
    let bytes = std::fs::read(path).map_err(|source| CliError::File {
        path: path.to_owned(),
        source,
    })?;
    let name = path.display().to_string();
    let ride = ride::read(&bytes, &name, &Bike::default(), &Options::default().reading)?;
    let line = swarm::benchmark(&ride)?;
    writeln!(std::io::stdout(), "{}", serde_json::to_string(&line)?)?;
    Ok(())
}
