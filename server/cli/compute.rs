use clap::Args;

use super::CliError;
use crate::jobs::Child;

/// Computes what its parent process, a server or a worker, requests on standard input.
#[derive(Args)]
pub struct Compute {
    #[arg(long)]
    threads: usize,
    #[arg(long)]
    nice: i32,
    /// Memory limit of a job (bytes).
    #[arg(long)]
    memory: u64,
}

impl Compute {
    pub fn run(self) -> Result<(), CliError> {
        let child = Child {
            threads: self.threads,
            nice: self.nice,
            memory: self.memory,
        };
        Ok(child.run()?)
    }
}
