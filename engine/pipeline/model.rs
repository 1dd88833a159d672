//! A model from what commands and the server wrote.

use serde_json::Value;

use veloid_report::{IdentifiedModel, Report};

/// Why a document is not a model.
#[derive(Debug, thiserror::Error)]
#[error(
    "neither a report nor a model as `veloid identify --json` and `--model MODEL.json` write them (the model comes first, then rides): {0}"
)]
pub struct ModelError(#[from] serde_json::Error);

/// The model of a report or of an exported model, both JSON.
///
/// # Errors
/// The text is neither.
pub fn read_model(json: &str) -> Result<IdentifiedModel, ModelError> {
    let document: Value = serde_json::from_str(json)?;
    Ok(match document.get("settings") {
        Some(_) => IdentifiedModel::of(serde_json::from_value::<Report>(document)?),
        None => serde_json::from_value(document)?,
    })
}
