//! The cells of a line of text, and whether they are numbers.

use crate::channels::unit::Unit;
use crate::formats::moment::Moment;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Separator {
    Byte(u8),
    /// Runs of blanks and tabs.
    Blanks,
}

/// `01 0`: what is left where blanks separate and a comma is the decimal sign.
pub fn is_two_numbers(cell: &str) -> bool {
    let mut parts = cell.split_ascii_whitespace();
    matches!((parts.next(), parts.next()), (Some(a), Some(b)) if is_number(a) && is_number(b))
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

/// A number with either decimal sign, `nan` and `inf` too, or a time of day.
pub fn is_number(cell: &str) -> bool {
    if Moment::parse(cell.as_bytes()).is_some() {
        return true;
    }
    let text = cell.replacen(',', ".", 1);
    fast_float2::parse::<f64, _>(text.trim_start_matches('+')).is_ok()
}

pub fn is_numeric(cells: &[String]) -> bool {
    cells.iter().all(|c| c.is_empty() || is_number(c))
}

pub fn is_units(cells: &[String]) -> bool {
    let bare = |c: &String| c.trim_matches(['[', ']', '(', ')', ' ']).to_owned();
    cells.iter().all(|c| c.is_empty() || !is_number(c))
        && cells.iter().any(|c| Unit::is_one(&bare(c)))
}
