//! The command line: one file per subcommand.

mod adopt;
mod arguments;
mod backup;
mod bench;
mod check;
mod client;
mod compute;
mod demo;
mod effects;
mod error;
mod form;
mod health;
mod identify;
mod keeping;
mod key;
mod loggers;
mod manifest;
mod migrate;
mod openapi;
mod progress;
mod prune;
mod restore;
mod ride_csv;
mod room;
mod runtime;
mod serve;
mod simulate;
mod split;
mod storage;
mod study;
mod unread;
mod validate;
mod vault;
mod webhook_options;
mod worker;

use std::io::IsTerminal;

use clap::{Parser, Subcommand};
pub use error::CliError;
use runtime::runtime;
use tracing_subscriber::filter::dynamic_filter_fn;
use tracing_subscriber::prelude::*;
use tracing_subscriber::{EnvFilter, Layer};

use crate::{built, seldom};

/// Identifies a bicycle's stiffness and damping from a ride log, and names the physics the model leaves out.
#[derive(Parser)]
#[command(version, long_version = built::VERSION, propagate_version = true)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
    /// What to log to stderr, such as `info` or `veloid=debug,sqlx=warn`.
    #[arg(
        long,
        global = true,
        env = "VELOID_LOG",
        default_value = "info,riverqueue=warn"
    )]
    log: String,
    /// Log as JSON lines.
    #[arg(long, global = true, env = "VELOID_LOG_JSON")]
    log_json: bool,
}

#[derive(Subcommand)]
enum Command {
    Serve(serve::Serve),
    Worker(worker::Worker),
    Identify(identify::Identify),
    Study(study::Study),
    Validate(validate::Validate),
    Simulate(simulate::Simulate),
    Migrate(migrate::Migrate),
    Backup(backup::Backup),
    Restore(restore::Restore),
    Prune(prune::PruneNow),
    Adopt(adopt::Adopt),
    Check(check::Check),
    Health(health::Health),
    Openapi(openapi::Openapi),
    Effects(effects::Effects),
    Key(key::Key),
    Bench(bench::Bench),
    #[command(hide = true)]
    Compute(compute::Compute),
}

impl Cli {
    pub fn run(self) -> Result<(), CliError> {
        self.start_log();
        match self.command {
            Command::Serve(command) => runtime()?.block_on(command.run()),
            Command::Worker(command) => runtime()?.block_on(command.run()),
            Command::Identify(command) => command.run(),
            Command::Study(command) => command.run(),
            Command::Validate(command) => command.run(),
            Command::Simulate(command) => command.run(),
            Command::Migrate(command) => runtime()?.block_on(command.run()),
            Command::Backup(command) => runtime()?.block_on(command.run()),
            Command::Restore(command) => runtime()?.block_on(command.run()),
            Command::Prune(command) => runtime()?.block_on(command.run()),
            Command::Adopt(command) => runtime()?.block_on(command.run()),
            Command::Check(command) => runtime()?.block_on(command.run()),
            Command::Health(command) => runtime()?.block_on(command.run()),
            Command::Openapi(command) => command.run(),
            Command::Effects(command) => command.run(),
            Command::Key(command) => runtime()?.block_on(command.run()),
            Command::Bench(command) => command.run(),
            Command::Compute(command) => command.run(),
        }
    }

    fn start_log(&self) {
        let layer = tracing_subscriber::fmt::layer()
            .with_ansi(std::io::stderr().is_terminal())
            .with_writer(std::io::stderr);
        let layer = match self.log_json {
            true => layer.json().boxed(),
            false => layer.boxed(),
        };
        let library = seldom::Callsites::default();
        let is_due = dynamic_filter_fn(move |metadata, _| {
            !metadata.target().starts_with("riverqueue") || library.is_due(metadata)
        });
        tracing_subscriber::registry()
            .with(
                layer
                    .with_filter(is_due)
                    .with_filter(EnvFilter::new(&self.log)),
            )
            .init();
    }
}
