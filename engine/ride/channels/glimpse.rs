//! What stands at the beginning of a column, for people to recognise it by.

use serde::{Deserialize, Serialize};
use veloid_core::document::format_number::Number;

/// Cells that are shown of a column.
const CELLS: usize = 3;
/// Most of a cell (characters).
const LONGEST: usize = 24;
const DIGITS: i32 = 6;
/// Most cells of a line that is shown.
const WIDEST: usize = 24;

/// A line of a text file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct PreviewLine {
    /// Counted from 1.
    pub number: usize,
    /// The first of its cells.
    pub cells: Vec<String>,
}

impl PreviewLine {
    pub fn new(number: usize, cells: &[String]) -> Self {
        let shown = |cell: &String| cell.chars().take(LONGEST).collect();
        Self {
            number,
            cells: cells.iter().take(WIDEST).map(shown).collect(),
        }
    }
}

/// The header and the first cells of a column, as they stand in the file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Glimpse {
    pub header: String,
    pub cells: Vec<String>,
}

impl Glimpse {
    /// Of a column of text.
    pub fn of_texts<'a>(header: &str, cells: impl Iterator<Item = &'a str>) -> Self {
        let cells = cells.filter(|cell| !cell.is_empty());
        let cells = cells.map(|cell| cell.chars().take(LONGEST).collect());
        Self::new(header, cells)
    }

    /// Of a column of numbers.
    pub fn of_numbers(header: &str, values: impl Iterator<Item = f64>) -> Self {
        let values = values.filter(|value| !value.is_nan());
        Self::new(
            header,
            values.map(|value| Number::rough(value, DIGITS).to_string()),
        )
    }

    fn new(header: &str, cells: impl Iterator<Item = String>) -> Self {
        Self {
            header: header.to_owned(),
            cells: cells.take(CELLS).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_cells_that_hold_something_are_shown() {
        let texts = Glimpse::of_texts("Zeit (s)", ["", "0,002", "", "0,004"].into_iter());
        assert_eq!(texts.cells, ["0,002", "0,004"]);
        let numbers = [f64::NAN, 1.5, 2.0, 1e-3, 7.0];
        let numbers = Glimpse::of_numbers("x", numbers.into_iter());
        assert_eq!(numbers.cells, ["1.5", "2", "0.001"]);
        let long = "1".repeat(100);
        let long = Glimpse::of_texts("x", [long.as_str()].into_iter());
        assert_eq!(long.cells[0].len(), LONGEST);
    }
}
