//! The recognised columns of a file as numbers, before anything is made of them.

use crate::channels::channel::Channel;
use crate::channels::glimpse::{Glimpse, PreviewLine};
use crate::channels::unit::Unit;
use crate::error::{Problem, ReadError};
use crate::table_layout::TableLayout;

/// Largest magnitude that a measurement may have in the file's unit.
pub const LARGEST: f64 = 1e15;

/// What a recognised column is.
#[derive(Clone, Debug, PartialEq)]
pub struct Spec {
    /// Counted from 1.
    pub number: usize,
    pub header: String,
    pub channel: Channel,
    pub unit: Unit,
    /// Whether words of the header alone say that it is this channel.
    pub is_guess: bool,
}

impl Spec {
    /// Names the column in `problem`.
    pub fn blame(&self, problem: Problem) -> ReadError {
        ReadError::from(problem).in_column(self.number, &self.header)
    }
}

/// Refuses what no measurement is, with its place; whether NaN is a missing value depends on the format.
pub fn measured(values: &[f64], nan_is_missing: bool) -> Result<(), (usize, Problem)> {
    let wrong = |v: &f64| !(v.abs() <= LARGEST || v.is_nan() && nan_is_missing);
    let Some(at) = values.iter().position(wrong) else {
        return Ok(());
    };
    let problem = match values[at] {
        value if value.is_finite() => Problem::OutOfRange {
            value,
            limit: LARGEST,
        },
        other => Problem::NotFinite {
            cell: other.to_string(),
        },
    };
    Err((at, problem))
}

/// Columns of equal length; a blank cell is NaN, and nothing else is.
#[derive(Debug, Default)]
pub struct Table {
    pub columns: Vec<(Spec, Vec<f64>)>,
    pub rows: usize,
    pub places: Places,
    /// Epoch (s) of the time 0, where the stamps say when they were taken.
    pub epoch_s: Option<f64>,
    /// Channels of the mapping whose column is not here, but may be in another file.
    pub unfound: Vec<String>,
    pub ignored: Vec<String>,
    /// Every column of the file, in order.
    pub glimpses: Vec<Glimpse>,
    /// The first lines of a text file, and how it is laid out.
    pub lines: Vec<PreviewLine>,
    pub layout: TableLayout,
    pub warnings: Vec<String>,
    /// What was assumed while the file was read, in sentences.
    pub reading: Vec<String>,
    /// Format of the file, in words.
    pub format: String,
}

/// Where each row stands in the file.
#[derive(Debug, Default)]
pub struct Places {
    /// (row, line) wherever a row does not follow on the next line; empty for a file without lines.
    jumps: Vec<(u32, u32)>,
    next_line: u32,
}

impl Places {
    /// Row `row` stands on `line`. Rows come in order.
    pub fn push(&mut self, row: usize, line: usize) {
        let (row, line) = (row as u32, line as u32);
        if self.next_line != line || self.jumps.is_empty() {
            self.jumps.push((row, line));
        }
        self.next_line = line + 1;
    }

    /// Those of some rows, in their order.
    pub fn of_rows(&self, rows: &[usize]) -> Self {
        let mut out = Self::default();
        for (place, row) in rows.iter().enumerate() {
            if let Some(line) = self.line(*row) {
                out.push(place, line);
            }
        }
        out
    }

    fn line(&self, row: usize) -> Option<usize> {
        let after = self.jumps.partition_point(|(r, _)| *r as usize <= row);
        let (first, line) = self.jumps[after.checked_sub(1)?];
        Some(line as usize + row - first as usize)
    }

    /// Names the place of `row` in `error`.
    pub fn blame(&self, row: usize, error: impl Into<ReadError>) -> ReadError {
        match self.line(row) {
            Some(line) => error.into().at_line(line),
            None => error.into().at_sample(row + 1),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_find_their_lines() {
        let mut places = Places::default();
        for (row, line) in [3, 4, 5, 8, 9, 20].into_iter().enumerate() {
            places.push(row, line);
        }
        let line = |row| places.blame(row, Problem::EmptyFile).line();
        assert_eq!([0, 2, 3, 4, 5].map(line), [3, 5, 8, 9, 20].map(Some));
        assert_eq!(places.jumps.len(), 3);
        assert_eq!(
            Places::default()
                .blame(4, Problem::EmptyFile)
                .to_string()
                .find("sample 5"),
            Some(2)
        );
    }
}
