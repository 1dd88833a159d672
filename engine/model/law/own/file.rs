//! A law as it is written: TOML.

use std::collections::BTreeMap;

use serde::Deserialize;

use super::error::LawError;

/// Bytes that a law may have.
const MOST_BYTES: usize = 8192;

/// Where a law may act.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Where {
    Front,
    Rear,
    /// On each axle for itself, with numbers of its own.
    #[default]
    Each,
    /// On both axles at once, with the same numbers.
    Both,
}

/// The file's keys.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct File {
    pub id: String,
    #[serde(default)]
    pub axle: Where,
    /// The force on the axle mass (N).
    pub force: String,
    pub parameters: BTreeMap<String, Written>,
    /// The derivative of each state.
    #[serde(default)]
    pub states: BTreeMap<String, String>,
    /// The law in a few plain words.
    pub words: Option<String>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Written {
    #[serde(default)]
    pub unit: String,
    pub start: Start,
    pub range: [f64; 2],
}

/// One value to start from, or several.
#[derive(Debug, Deserialize)]
#[serde(untagged)]
pub enum Start {
    One(f64),
    Several(Vec<f64>),
}

/// Reads the text of a law.
pub fn read(text: &str) -> Result<File, LawError> {
    if text.len() > MOST_BYTES {
        return Err(LawError::Long {
            bytes: text.len(),
            most: MOST_BYTES,
        });
    }
    toml::from_str(text).map_err(|error| {
        let before = error
            .span()
            .map_or("", |span| text.get(..span.start).unwrap_or(""));
        let line = before.matches('\n').count() + 1;
        let column = before.chars().rev().take_while(|c| *c != '\n').count() + 1;
        LawError::Toml {
            line,
            column,
            problem: error.message().to_owned(),
        }
    })
}
