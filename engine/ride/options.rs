//! What the user may say about a ride file.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::error::Problem;
use super::logger::Logger;
use super::table_layout::TableLayout;
use crate::clocks::rates::{RATES, RATES_HZ};

/// How to read a ride file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
#[serde(default, deny_unknown_fields)]
pub struct ReadOptions {
    /// Channel name to column: a header text or a number counted from 1, perhaps with the unit to read it in behind:
    /// `Weg vorne mm [mm]`.
    pub map: BTreeMap<String, String>,
    /// Sampling rate of a file without a time column (Hz).
    pub rate_hz: Option<f64>,
    /// Data rows to use, counted from 0, the second exclusive.
    #[cfg_attr(feature = "openapi", schema(value_type = Option<Vec<usize>>, min_items = 2, max_items = 2))]
    pub rows: Option<(usize, usize)>,
    /// +1: d is the deflection u - z; -1: d is a sensor's distance to the road, -(u - z).
    pub deflection_sign: f64,
    /// Band (Hz) to which z and u are filtered where z is computed from acceleration; by default from 0.5 Hz to 0.45 of the
    /// slowest sensor's rate.
    #[cfg_attr(feature = "openapi", schema(value_type = Option<Vec<f64>>, min_items = 2, max_items = 2))]
    pub band_hz: Option<(f64, f64)>,
    /// Words for a missing value, in addition to a blank cell, such as `NA`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub missing: Vec<String>,
    /// Where the table of a text file stands and how it is written.
    #[serde(skip_serializing_if = "TableLayout::is_empty")]
    pub layout: TableLayout,
    /// Options for single files of several, by file name.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub files: BTreeMap<String, FileOptions>,
    /// Loggers of the lab. Set by the program, never by the sender.
    #[serde(skip)]
    pub loggers: Arc<[Logger]>,
    /// Channels of columns that the file's logger names. Set by the reader, never by the sender.
    #[serde(skip)]
    pub named: BTreeMap<String, String>,
    /// Sizes beyond which a file is refused. Set by the program, never by the sender.
    #[serde(skip)]
    pub limits: Limits,
    /// Channels of `map` whose column may stand in another file. Set by the reader, never by the sender.
    #[serde(skip)]
    pub elsewhere: BTreeSet<String>,
}

/// How to read one of several files; absent options are those of the ride.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
#[serde(default, deny_unknown_fields)]
pub struct FileOptions {
    /// Channel name to column of this file.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub map: BTreeMap<String, String>,
    /// Sampling rate, without a time column (Hz).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rate_hz: Option<f64>,
    /// Data rows to use, counted from 0, the second exclusive.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "openapi", schema(value_type = Option<Vec<usize>>, min_items = 2, max_items = 2))]
    pub rows: Option<(usize, usize)>,
    /// How much later (s) the file begins than its time stamps state, or than the other files where the stamps have no date.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub offset_s: Option<f64>,
    /// Where the table of this file stands and how it is written.
    #[serde(skip_serializing_if = "TableLayout::is_empty")]
    pub layout: TableLayout,
}

impl Default for ReadOptions {
    fn default() -> Self {
        Self {
            map: BTreeMap::new(),
            rate_hz: None,
            rows: None,
            deflection_sign: 1.0,
            band_hz: None,
            missing: Vec::new(),
            layout: TableLayout::default(),
            files: BTreeMap::new(),
            elsewhere: BTreeSet::new(),
            loggers: Arc::default(),
            named: BTreeMap::new(),
            limits: Limits::default(),
        }
    }
}

impl ReadOptions {
    pub(super) fn validate(&self) -> Result<(), Problem> {
        let bad = |name, value: String, expected| {
            Err(Problem::BadOption {
                name,
                value,
                expected,
            })
        };
        let rates = self.files.values().filter_map(|file| file.rate_hz);
        if let Some(rate) = (self.rate_hz.into_iter().chain(rates)).find(|r| !RATES_HZ.contains(r))
        {
            return bad("rate_hz", format!("{rate:?} Hz"), RATES);
        }
        if self.deflection_sign.abs() != 1.0 {
            let value = format!("{:?}", self.deflection_sign);
            return bad("deflection_sign", value, "1 or -1");
        }
        if let Some((low, high)) = self.band_hz
            && !(low >= 0.01 && low < high && high <= 1e6)
        {
            return bad(
                "band_hz",
                format!("{low:?} to {high:?}"),
                "0.01 Hz <= low < high",
            );
        }
        let rows = self.files.values().filter_map(|file| file.rows);
        if let Some((from, to)) = (self.rows.into_iter().chain(rows)).find(|(from, to)| from >= to)
        {
            return bad("rows", format!("{from}:{to}"), "FROM before TO");
        }
        let layouts = self.files.values().map(|file| &file.layout);
        for layout in layouts.chain([&self.layout]) {
            layout.validate()?;
        }
        let mut offsets = self.files.values().filter_map(|file| file.offset_s);
        if let Some(offset) = offsets.find(|s| !(s.abs() <= FURTHEST_S)) {
            return bad("offset_s", format!("{offset:?} s"), "at most 1e9 s");
        }
        Ok(())
    }

    /// What is said of the file `name` alone: under its name, or a path that ends with it.
    pub(super) fn own(&self, name: &str) -> Option<(&str, &FileOptions)> {
        let last = |path: &str| path.rsplit(['/', '\\']).next() == Some(name);
        let mut named = self.files.iter();
        let found = named.find(|(path, _)| *path == name || last(path));
        found.map(|(path, options)| (path.as_str(), options))
    }

    /// How the file `name`, one of `count`, is read.
    pub(super) fn of_file(&self, name: &str, count: usize) -> Self {
        let own = self
            .own(name)
            .map(|(_, own)| own.clone())
            .unwrap_or_default();
        let elsewhere = |channel: &&String| count > 1 && !own.map.contains_key(*channel);
        Self {
            elsewhere: self.map.keys().filter(elsewhere).cloned().collect(),
            map: self.map.clone().into_iter().chain(own.map).collect(),
            rate_hz: own.rate_hz.or(self.rate_hz),
            rows: own.rows.or(self.rows),
            layout: own.layout.or(&self.layout),
            ..self.clone()
        }
    }

    /// Whether the user says that this word stands for a missing value.
    pub(super) fn is_missing(&self, cell: &[u8]) -> bool {
        self.missing
            .iter()
            .any(|word| word.trim().as_bytes() == cell)
    }
}

/// Furthest that a file may be moved in time (s): some thirty years.
const FURTHEST_S: f64 = 1e9;

/// Sizes beyond which a file is refused. Set by the program, never by the file or its sender.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Of a file, as it lies there and unpacked.
    pub bytes: u64,
    /// Rows of a table.
    pub rows: usize,
    /// Numbers of a table that is packed in the file.
    pub numbers: usize,
    /// Columns of a table.
    pub columns: usize,
    /// Files of one ride.
    pub files: usize,
    /// Bytes of a line.
    pub line_bytes: usize,
    /// Fewest samples on the common clock.
    pub least_samples: usize,
}

impl Limits {
    /// How many numbers may be made of a packed file of so many bytes; plain text bounds them by itself.
    pub(super) fn most_numbers(&self, packed: usize) -> usize {
        self.numbers.min((2 << 20) + packed / 2)
    }

    /// Most bytes that a packed file of so many may unpack to.
    pub(super) fn most_unpacked(&self, packed: usize) -> u64 {
        self.bytes.min((64 << 20) + 50 * packed as u64)
    }

    /// The same where all of it is held at once.
    pub(super) fn most_held(&self, packed: usize) -> u64 {
        self.bytes.min((32 << 20) + 8 * packed as u64)
    }
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            bytes: 2 << 30,
            rows: 20_000_000,
            numbers: usize::MAX,
            columns: 512,
            files: 16,
            line_bytes: 64 << 10,
            least_samples: 50,
        }
    }
}
