//! The files of a ride.

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

/// A file to read, or arrays that stand for one.
#[derive(Clone, Copy, Debug)]
pub struct RideFile<'a> {
    /// Only used to name the file in options and messages.
    pub name: &'a str,
    /// What it holds.
    pub content: Content<'a>,
}

/// What is to be read.
#[derive(Clone, Copy, Debug)]
pub enum Content<'a> {
    /// CSV in any dialect, MATLAB v4/v5/v7, Garmin FIT, GPX, TCX or the first sheet of an xlsx workbook; gzip or zstd around any of them.
    Bytes(&'a [u8]),
    /// Columns in memory.
    Arrays(Arrays<'a>),
}

/// One logger's record in memory.
#[derive(Clone, Copy, Debug, Default)]
pub struct Arrays<'a> {
    /// Columns of equal length under names as a file's header has them (`t`, `z_f [mm]`); NaN is a missing value.
    pub columns: &'a [(&'a str, &'a [f64])],
    /// Epoch (s since 1970) of the time 0, where it is known.
    pub epoch_s: Option<f64>,
}

impl<'a> RideFile<'a> {
    /// A file by its bytes.
    pub fn new(name: &'a str, bytes: &'a [u8]) -> Self {
        let content = Content::Bytes(bytes);
        Self { name, content }
    }

    /// SHA-256 (hex) of the bytes; of arrays that of each name, a line feed and the little-endian values, column by column.
    pub(super) fn sha256(&self) -> String {
        match self.content {
            Content::Bytes(bytes) => sha256(bytes),
            Content::Arrays(arrays) => {
                let mut digest = Sha256::new();
                for (name, values) in arrays.columns {
                    digest.update(name.as_bytes());
                    digest.update(b"\n");
                    values.iter().for_each(|v| digest.update(v.to_le_bytes()));
                }
                hex(&digest.finalize())
            }
        }
    }
}

/// One of several files of a ride.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct FileSummary {
    /// Name as given.
    pub name: String,
    /// SHA-256 of its bytes (hex).
    pub sha256: String,
    /// Format of the file, in words.
    pub format: String,
    /// Rows that were used.
    pub rows: usize,
    /// Whether its time stamps have a date; if not, the file begins together with the others.
    pub dated: bool,
    /// How much later it begins, as given by the user (s).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offset_s: Option<f64>,
    /// Offset added to its time stamps (s) to convert them to the ride's clock; `ride.clocks` is added to it.
    pub shift_s: f64,
    /// When it begins on the ride's clock (s).
    pub from_s: f64,
    /// When it ends on the ride's clock (s).
    pub to_s: f64,
    /// Why its clock was left unchanged, where it was not compared with another file's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub kept: Option<String>,
}

impl FileSummary {
    /// Whether its stamps or the user say when it began.
    pub(super) fn is_placed(&self) -> bool {
        self.dated || self.offset_s.is_some()
    }
}

/// SHA-256 (hex) that stands for files of these SHA-256 (hex): that of the one, or of all of them, one a line.
pub fn sha256_of(files: &[String]) -> String {
    match files {
        [one] => one.clone(),
        several => sha256((several.join("\n") + "\n").as_bytes()),
    }
}

fn sha256(bytes: &[u8]) -> String {
    hex(&Sha256::digest(bytes))
}

fn hex(digest: &[u8]) -> String {
    digest.iter().map(|b| format!("{b:02x}")).collect()
}
