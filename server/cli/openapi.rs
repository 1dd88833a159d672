use std::io::Write;

use clap::Args;

use super::CliError;

/// Prints the OpenAPI document.
#[derive(Args)]
pub struct Openapi {}

impl Openapi {
    pub fn run(self) -> Result<(), CliError> {
        let text = serde_json::to_string_pretty(&crate::router::document())?;
        writeln!(std::io::stdout(), "{text}")?;
        Ok(())
    }
}
