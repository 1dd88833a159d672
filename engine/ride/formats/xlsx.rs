//! Excel workbooks (.xlsx): the first sheet with a table as the text that it would be saved as, so that it is read as any other table.
//!
//! What `calamine` gets of a workbook is looked through before ([`sifted`]), and the text that comes of it has a bound too.

use std::fmt::Write;
use std::io::Cursor;

use calamine::{DataRef, ExcelDateTime, Reader, Xlsx, XlsxError};

use crate::error::Problem;
use crate::formats::markup::corrupt;
use crate::formats::workbook::{ROWS, sifted};
use crate::options::Limits;

/// Excel's number of 1970-01-01 in its two calendars.
const SINCE_1900: f64 = 25_569.0;
const SINCE_1904: f64 = 24_107.0;
/// Rows that make a table: so many with two numbers, or so many with one.
const ROWS_OF_TWO: usize = 2;
const ROWS_OF_ONE: usize = 10;

type Book<'a> = Xlsx<Cursor<&'a [u8]>>;

/// The sheet that is read, as text with cells apart by tabs and one row on each line.
pub struct Read {
    pub text: String,
    /// That it is not the first one, if it is not.
    pub warning: Option<String>,
}

/// The text of the sheet that is read.
pub fn text(bytes: &[u8], limits: &Limits) -> Result<String, Problem> {
    sheet(bytes, limits).map(|read| read.text)
}

/// The first sheet that has a table of numbers. `calamine` counts rows and columns without a check, which ends a debug build where a
/// reference overflows.
pub fn sheet(bytes: &[u8], limits: &Limits) -> Result<Read, Problem> {
    let parts = sifted(bytes, limits)?;
    let read = || first_table(&parts, bytes.len(), limits);
    std::panic::catch_unwind(read).unwrap_or_else(|_| Err(corrupt(&"a reference overflows")))
}

fn first_table(parts: &[u8], packed: usize, limits: &Limits) -> Result<Read, Problem> {
    let mut book: Xlsx<_> = Xlsx::new(Cursor::new(parts)).map_err(|e: XlsxError| corrupt(&e))?;
    let names = book.sheet_names();
    let Some((first, others)) = names.split_first() else {
        return Err(Problem::EmptyFile);
    };
    let sheet = written(&mut book, first, packed, limits)?;
    if sheet.has_table() {
        has_values(&mut book, first, &sheet)?;
        return Ok(Read {
            text: sheet.text,
            warning: None,
        });
    }
    for name in others {
        // A chart is no sheet of cells; what is damaged is not asked for.
        let Ok(other) = written(&mut book, name, packed, limits) else {
            continue;
        };
        if other.has_table() {
            has_values(&mut book, name, &other)?;
            return Ok(Read {
                text: other.text,
                warning: Some(format!(
                    "the first sheet, \"{first}\", has no table of numbers: the sheet \"{name}\" is read"
                )),
            });
        }
    }
    has_values(&mut book, first, &sheet)?;
    Ok(Read {
        text: sheet.text,
        warning: None,
    })
}

fn written(
    book: &mut Book<'_>,
    name: &str,
    packed: usize,
    limits: &Limits,
) -> Result<Sheet, Problem> {
    let zero = match book.has_1904_epoch() {
        true => SINCE_1904,
        false => SINCE_1900,
    };
    let mut cells = (book.worksheet_cells_reader(name)).map_err(|e| corrupt(&e))?;
    let mut sheet = Sheet::new(packed, limits);
    while let Some(cell) = cells.next_cell().map_err(|e| corrupt(&e))? {
        sheet.go_to(cell.get_position())?;
        let value = cell.get_value();
        sheet.numbers += usize::from(is_number(value));
        if matches!(value, DataRef::Empty) {
            sheet.blank.push(cell.get_position());
        }
        write(&mut sheet.text, value, zero);
    }
    sheet.end_row();
    Ok(sheet)
}

/// Refuses a sheet in which half as many formulas as rows of numbers have no stored value.
fn has_values(book: &mut Book<'_>, name: &str, sheet: &Sheet) -> Result<(), Problem> {
    if sheet.blank.is_empty() {
        return Ok(());
    }
    let mut cells = (book.worksheet_cells_reader(name)).map_err(|e| corrupt(&e))?;
    let mut formulas = 0;
    while let Some(cell) = cells.next_formula().map_err(|e| corrupt(&e))? {
        let is_blank = sheet.blank.binary_search(&cell.get_position()).is_ok();
        formulas += usize::from(is_blank && !cell.get_value().is_empty());
    }
    match formulas > 0 && 2 * formulas >= sheet.rows_of_one {
        true => Err(Problem::NoFormulaValues {
            sheet: name.to_owned(),
            formulas,
        }),
        false => Ok(()),
    }
}

/// Whether a cell is a number, or a text that is one.
fn is_number(value: &DataRef<'_>) -> bool {
    let is_one = |text: &str| text.trim().replace(',', ".").parse::<f64>().is_ok();
    match value {
        DataRef::Int(_) | DataRef::Float(_) | DataRef::DateTime(_) => true,
        DataRef::String(text) => is_one(text),
        DataRef::SharedString(text) => is_one(text),
        _ => false,
    }
}

/// A sheet as it is written, row by row.
struct Sheet {
    text: String,
    row: u32,
    column: u32,
    /// Columns of the widest row so far: sheets leave out blank cells at the end of a row.
    width: u32,
    most_columns: usize,
    packed: usize,
    most: usize,
    /// Numbers in this row, and rows with one or more, and two or more.
    numbers: usize,
    rows_of_one: usize,
    rows_of_two: usize,
    /// Cells without a value, in order.
    blank: Vec<(u32, u32)>,
}

impl Sheet {
    fn new(packed: usize, limits: &Limits) -> Self {
        Self {
            text: String::new(),
            row: 0,
            column: 0,
            width: 0,
            most_columns: limits.columns,
            packed,
            most: ((16 << 20) + 8 * packed).min(limits.bytes as usize),
            numbers: 0,
            rows_of_one: 0,
            rows_of_two: 0,
            blank: Vec::new(),
        }
    }

    fn has_table(&self) -> bool {
        self.rows_of_two >= ROWS_OF_TWO || self.rows_of_one >= ROWS_OF_ONE
    }

    /// Ends rows and cells up to this one.
    fn go_to(&mut self, (row, column): (u32, u32)) -> Result<(), Problem> {
        if (row, column) < (self.row, self.column) {
            return Err(corrupt(&"its cells are out of order"));
        }
        if row >= ROWS || column as usize >= self.most_columns {
            let (what, limit) = match row >= ROWS {
                true => ("rows", ROWS as usize),
                false => ("columns", self.most_columns),
            };
            return Err(Problem::TooMany { what, limit });
        }
        while self.row < row {
            self.end_row();
        }
        while self.column < column {
            self.text.push('\t');
            self.column += 1;
        }
        if self.text.len() > self.most {
            return Err(Problem::GzipBomb {
                packed: self.packed,
                what: "bytes",
                limit: self.most as u64,
            });
        }
        Ok(())
    }

    fn end_row(&mut self) {
        let begun = self.text.ends_with(|last| last != '\n');
        if begun {
            self.width = self.width.max(self.column);
            for _ in self.column..self.width {
                self.text.push('\t');
            }
        }
        self.text.push('\n');
        self.row += 1;
        self.column = 0;
        self.rows_of_one += usize::from(self.numbers >= 1);
        self.rows_of_two += usize::from(self.numbers >= 2);
        self.numbers = 0;
    }
}

/// Writes a cell; a date becomes the seconds since 1970, a time without a date those of its day.
fn write(text: &mut String, value: &DataRef<'_>, zero: f64) {
    let _ = match value {
        DataRef::Int(v) => write!(text, "{v}"),
        DataRef::Float(v) => write!(text, "{v:?}"),
        DataRef::DateTime(v) => write!(text, "{:.6}", seconds(v, zero)),
        DataRef::String(v) => write!(text, "{}", plain(v)),
        DataRef::SharedString(v) => write!(text, "{}", plain(v)),
        DataRef::DateTimeIso(v) | DataRef::DurationIso(v) => write!(text, "{}", plain(v)),
        DataRef::Bool(v) => write!(text, "{v}"),
        DataRef::Error(v) => write!(text, "{v}"),
        DataRef::Empty => Ok(()),
    };
}

fn seconds(time: &ExcelDateTime, zero: f64) -> f64 {
    let days = time.as_f64();
    let since = match time.is_duration() || days < 1.0 {
        true => 0.0,
        false => zero,
    };
    86_400.0 * (days - since)
}

/// A text in one line and one cell.
fn plain(text: &str) -> String {
    let odd = |c: char| c.is_control() || c == '"';
    text.replace(odd, " ")
}

#[cfg(test)]
pub mod tests;
