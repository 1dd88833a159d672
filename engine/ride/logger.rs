//! A logger whose files are known: how to recognise them and what their columns hold.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::table_layout::TableLayout;

/// How the text files of one logger are read. What the user says comes first, then what the file's own column names say.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Logger {
    /// Its name, for `ride.reading`.
    pub name: String,
    /// Texts all of which stand in the first 8 KiB of its files.
    pub recognise: Vec<String>,
    /// Column names, without a unit, and the channel that each holds, perhaps with the unit to read it in: `v [km/h]`.
    #[serde(default)]
    pub columns: BTreeMap<String, String>,
    /// Words for missing values.
    #[serde(default)]
    pub missing: Vec<String>,
    /// Where the table stands and how it is written.
    #[serde(default)]
    pub layout: TableLayout,
    /// What its user has to say or to know, as a sentence of `ride.reading`.
    #[serde(default)]
    pub note: Option<String>,
}
