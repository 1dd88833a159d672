//! The cells of a line of text, and whether they are numbers.

use crate::channels::unit::Unit;
use crate::formats::number::{is_number, with_unit};
use crate::formats::times::is_time;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Separator {
    Byte(u8),
    /// Runs of blanks and tabs.
    Blanks,
}

impl Separator {
    pub fn as_char(self) -> char {
        match self {
            Self::Byte(byte) => char::from(byte),
            Self::Blanks => ' ',
        }
    }

    pub fn name(self) -> String {
        match self {
            Self::Byte(b'\t') => "tab".to_owned(),
            Self::Blanks => "blanks".to_owned(),
            other => other.as_char().to_string(),
        }
    }
}

/// `01 0`: what is left where blanks separate and a comma is the decimal sign. Between other separators `5 001` is one number.
pub fn is_two_numbers(cell: &str, separator: Separator) -> bool {
    if separator != Separator::Byte(b',') && is_number(cell) {
        return false;
    }
    let mut parts = cell.split_ascii_whitespace();
    matches!((parts.next(), parts.next()), (Some(a), Some(b)) if is_cell_number(a) && is_cell_number(b))
}

/// The cells of a line, trimmed and without quotes.
pub fn split(line: &str, separator: Separator) -> Vec<String> {
    match separator {
        Separator::Byte(b) => split_at(line, b),
        Separator::Blanks => split_blanks(line),
    }
}

fn split_at(line: &str, separator: u8) -> Vec<String> {
    let (mut cells, mut cell, mut quoted) = (Vec::new(), String::new(), false);
    for c in line.chars() {
        if c == '"' && (quoted || cell.trim().is_empty()) {
            quoted = !quoted;
        } else if c == '"' && cell == "=" {
            // `="0.005"`: a formula that keeps a spreadsheet from reading a number.
            cell.clear();
            quoted = true;
        } else if c == separator as char && !quoted {
            cells.push(cell.trim().to_owned());
            cell.clear();
        } else {
            cell.push(c);
        }
    }
    cells.push(cell.trim().to_owned());
    cells
}

/// `t [s]  z_f [mm]` has two cells: a bracket belongs to the name before it.
fn split_blanks(line: &str) -> Vec<String> {
    let mut cells: Vec<String> = Vec::new();
    for word in line.split_ascii_whitespace() {
        let word = word.trim_matches('"');
        match cells.last_mut() {
            Some(name) if word.starts_with(['[', '(']) => {
                name.push(' ');
                name.push_str(word);
            }
            _ => cells.push(word.to_owned()),
        }
    }
    cells
}

/// Cells that two blanks or a tab keep apart.
pub fn split_wide(line: &str) -> Vec<String> {
    line.split("  ")
        .flat_map(|part| part.split('\t'))
        .map(|cell| cell.trim().to_owned())
        .filter(|cell| !cell.is_empty())
        .collect()
}

/// A number with either decimal sign, `nan` and `inf` too, perhaps with its unit, or a time.
pub fn is_cell_number(cell: &str) -> bool {
    is_number(cell) || with_unit(cell).is_some() || is_time(cell)
}

/// Whether cells are units: at least half of those that are not blank, and none is a number.
pub fn is_units(cells: &[String]) -> bool {
    let there = || cells.iter().filter(|cell| !cell.is_empty());
    let is_unit = |cell: &&String| Unit::is_one(cell.trim_matches(['[', ']', '(', ')', ' ']));
    let units = there().filter(is_unit).count();
    units > 0 && 2 * units >= there().count() && !there().any(|cell| is_cell_number(cell))
}
