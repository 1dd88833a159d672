//! `veloid`: turns a bicycle's ride log into its stiffness and damping, and says what physics the
//! model leaves out. See `docs/architecture.md` for the way through the folders.

mod allocator;
mod api;
mod bicycle;
mod built;
mod cli;
mod columns;
#[cfg(test)]
mod conformance;
mod crash;
mod decimal;
mod effects;
mod erasure;
mod exchanged;
mod export;
mod facts;
mod files;
mod fleet;
mod http;
mod installation;
mod jobs;
mod lru;
mod memo;
mod metrics;
mod options;
mod pages;
mod router;
mod seldom;
mod shorten;
#[cfg(test)]
#[path = "../tests/skips.rs"]
mod skips;
mod store;
mod time;
mod unique;
mod watch;
mod webhooks;

use std::process::ExitCode;

use clap::Parser;

/// The program `veloid`.
pub fn run() -> ExitCode {
    allocator::give_back_soon();
    // TLS towards receivers of webhooks and object storage. It fails only where a provider is installed already.
    #[cfg(any(feature = "s3", feature = "webhooks"))]
    let _ = rustls::crypto::ring::default_provider().install_default();
    match cli::Cli::parse().run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("veloid: {error}");
            ExitCode::from(error.exit_status())
        }
    }
}
