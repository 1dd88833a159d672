use std::io::Write;

use clap::Args;

use super::CliError;
use crate::api;

/// Prints the OpenAPI document.
#[derive(Args)]
pub struct Openapi {}

impl Openapi {
    pub fn run(self) -> Result<(), CliError> {
        let text = serde_json::to_string_pretty(&api::document())?;
        writeln!(std::io::stdout(), "{text}")?;
        Ok(())
    }
}
