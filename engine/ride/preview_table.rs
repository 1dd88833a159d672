//! A file of a preview, column by column, whether something was recognised in them or not.

use serde::{Deserialize, Serialize};

use super::channels::glimpse::PreviewLine;
use super::channels::table::{Spec, Table};
use super::table_layout::TableLayout;

/// A file with all its columns.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct PreviewTable {
    /// As it was given.
    pub name: String,
    /// How the file is written, in words.
    pub format: String,
    /// Rows of numbers in it.
    pub rows: usize,
    /// Its columns, in order.
    pub columns: Vec<PreviewColumn>,
    /// The first lines of a text file.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub lines: Vec<PreviewLine>,
    /// How a text file was taken to be laid out.
    #[serde(default)]
    pub layout: TableLayout,
}

/// A column as it stands in the file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct PreviewColumn {
    /// Counted from 1.
    pub number: usize,
    /// Header text as in the file.
    pub header: String,
    /// The first values that are not blank, as they stand in the file.
    pub first: Vec<String>,
    /// Channel that is read from it, if any.
    pub channel: Option<String>,
    /// Unit that it is read in.
    pub unit: Option<String>,
}

impl PreviewTable {
    pub(super) fn new(name: &str, table: &Table) -> Self {
        let spec = |number: usize| -> Option<&Spec> {
            let mut specs = table.columns.iter().map(|(spec, _)| spec);
            specs.find(|spec| spec.number == number)
        };
        let columns = (1..).zip(&table.glimpses).map(|(number, glimpse)| {
            let spec = spec(number);
            PreviewColumn {
                number,
                header: glimpse.header.clone(),
                first: glimpse.cells.clone(),
                channel: spec.map(|spec| spec.channel.name().to_owned()),
                unit: spec.map(|spec| spec.unit.name.clone()),
            }
        });
        Self {
            name: name.to_owned(),
            format: table.format.clone(),
            rows: table.rows,
            columns: columns.collect(),
            lines: table.lines.clone(),
            layout: table.layout.clone(),
        }
    }
}
