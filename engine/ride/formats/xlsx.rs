//! Excel workbooks (.xlsx): the first sheet as the text that it would be saved as, so that it is read as any other table.
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

/// The first sheet, cells apart by tabs, one row on each line. `calamine` counts rows and columns without a check, which ends a
/// debug build where a reference overflows.
pub fn text(bytes: &[u8], limits: &Limits) -> Result<String, Problem> {
    let parts = sifted(bytes, limits)?;
    let read = || first_sheet(&parts, bytes.len(), limits);
    std::panic::catch_unwind(read).unwrap_or_else(|_| Err(corrupt(&"a reference overflows")))
}

fn first_sheet(parts: &[u8], packed: usize, limits: &Limits) -> Result<String, Problem> {
    let mut book: Xlsx<_> = Xlsx::new(Cursor::new(parts)).map_err(|e: XlsxError| corrupt(&e))?;
    let Some(name) = book.sheet_names().into_iter().next() else {
        return Err(Problem::EmptyFile);
    };
    let zero = match book.has_1904_epoch() {
        true => SINCE_1904,
        false => SINCE_1900,
    };
    let mut cells = book
        .worksheet_cells_reader(&name)
        .map_err(|e| corrupt(&e))?;
    let mut sheet = Sheet::new(packed, limits);
    while let Some(cell) = cells.next_cell().map_err(|e| corrupt(&e))? {
        sheet.go_to(cell.get_position())?;
        write(&mut sheet.text, cell.get_value(), zero);
    }
    sheet.end_row();
    Ok(sheet.text)
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
            most: (16 << 20) + 8 * packed,
        }
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
pub mod tests {
    #![allow(clippy::unwrap_used)]
    use std::io::Write as _;

    use proptest::prelude::*;
    use zip::ZipWriter;
    use zip::write::SimpleFileOptions;

    use super::*;
    use crate::formats::spreadsheet::is_xlsx;
    use crate::options::most_numbers;

    const RELATIONS: &str = "http://schemas.openxmlformats.org/officeDocument/2006/relationships";
    const MAIN: &str = "http://schemas.openxmlformats.org/spreadsheetml/2006/main";

    fn archive(parts: &[(&str, String)]) -> Vec<u8> {
        let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
        for (name, text) in parts {
            zip.start_file(*name, SimpleFileOptions::default()).unwrap();
            zip.write_all(text.as_bytes()).unwrap();
        }
        zip.finish().unwrap().into_inner()
    }

    fn with_sheet(sheet: String) -> Vec<u8> {
        let book = format!(
            "<workbook xmlns=\"{MAIN}\" xmlns:r=\"{RELATIONS}\"><sheets><sheet name=\"log\" sheetId=\"1\" r:id=\"r1\"/></sheets></workbook>"
        );
        let relations = format!(
            "<Relationships xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\"><Relationship Id=\"r1\" \
             Type=\"{RELATIONS}/worksheet\" Target=\"worksheets/sheet1.xml\"/></Relationships>"
        );
        let package = format!(
            "<Relationships xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\"><Relationship Id=\"r1\" \
             Type=\"{RELATIONS}/officeDocument\" Target=\"xl/workbook.xml\"/></Relationships>"
        );
        let styles = format!(
            "<styleSheet xmlns=\"{MAIN}\"><cellXfs><xf numFmtId=\"0\"/><xf numFmtId=\"22\"/></cellXfs></styleSheet>"
        );
        archive(&[
            ("_rels/.rels", package),
            ("xl/workbook.xml", book),
            ("xl/_rels/workbook.xml.rels", relations),
            ("xl/styles.xml", styles),
            ("xl/worksheets/sheet1.xml", sheet),
        ])
    }

    fn sheet(cells: &str) -> String {
        format!("<worksheet xmlns=\"{MAIN}\"><sheetData>{cells}</sheetData></worksheet>")
    }

    /// A workbook whose first sheet has these rows; a cell that is no number is a text.
    pub fn workbook(rows: &[Vec<String>]) -> Vec<u8> {
        let mut cells = String::new();
        for row in rows {
            cells.push_str("<row>");
            for cell in row {
                let _ = match cell.parse::<f64>() {
                    Ok(_) => write!(cells, "<c><v>{cell}</v></c>"),
                    Err(_) => write!(cells, "<c t=\"inlineStr\"><is><t>{cell}</t></is></c>"),
                };
            }
            cells.push_str("</row>");
        }
        with_sheet(sheet(&cells))
    }

    fn read(bytes: &[u8]) -> Result<String, Problem> {
        text(bytes, &Limits::default())
    }

    #[test]
    fn a_sheet_is_the_text_that_it_would_be_saved_as() {
        let date = "<row r=\"1\"><c r=\"A1\" t=\"inlineStr\"><is><t>t\"\n</t></is></c><c r=\"C1\" t=\"inlineStr\"><is><t>z_f</t></is></c></row>\
             <row r=\"3\"><c r=\"A3\" s=\"1\"><v>46349.5</v></c></row>\
             <row r=\"4\"><c r=\"B4\" t=\"b\"><v>1</v></c><c r=\"C4\"><v>-1.5e-3</v></c></row>";
        let bytes = with_sheet(sheet(date));
        assert!(is_xlsx(&bytes));
        let expected = "t \t\tz_f\n\n1795435200.000000\t\t\n\ttrue\t-0.0015\n";
        assert_eq!(read(&bytes).unwrap(), expected);
    }

    #[test]
    fn bombs_and_damage_are_refused() {
        let kind = |bytes: &[u8]| read(bytes).unwrap_err().kind();
        let blanks = " ".repeat(100 << 20);
        assert_eq!(kind(&with_sheet(sheet(&blanks))), "part-too-long");
        let blanks = "<x>        </x>".repeat(6 << 20);
        assert_eq!(kind(&with_sheet(sheet(&blanks))), "gzip-bomb");
        let strings = [
            ("xl/workbook.xml", String::new()),
            ("xl/sharedStrings.xml", "<si/>".repeat(1 << 20)),
        ];
        assert_eq!(kind(&archive(&strings)), "gzip-bomb");
        let wide = "<row r=\"9\"><c r=\"SS9\"><v>1</v></c></row>".repeat(3);
        assert_eq!(kind(&with_sheet(sheet(&wide))), "too-many");
        let back = "<row r=\"9\"><c r=\"B9\"/></row><row r=\"2\"><c r=\"B2\"/></row>";
        assert_eq!(kind(&with_sheet(sheet(back))), "corrupt-file");
        let low = "<row r=\"1048577\"><c r=\"A1048577\"><v>1</v></c></row>";
        assert!(["too-many", "corrupt-file"].contains(&kind(&with_sheet(sheet(low)))));
        let sound = workbook(&[vec!["t".to_owned()], vec!["1".to_owned()]]);
        assert_eq!(kind(&sound[..sound.len() - 30]), "corrupt-file");
        let many: Vec<String> = (0..=4096).map(|i| i.to_string()).collect();
        let many: Vec<(&str, String)> = many.iter().map(|n| (n.as_str(), String::new())).collect();
        assert_eq!(kind(&archive(&many)), "too-many");
    }

    #[test]
    fn what_takes_memory_out_of_proportion_is_refused_in_its_own_words() {
        let said = |bytes: &[u8]| read(bytes).unwrap_err().to_string();
        let long = "x".repeat(1 << 20);
        let text = "a text in the workbook is longer than 32767 characters";
        let inline = format!("<row><c t=\"inlineStr\"><is><t>{long}</t></is></c></row>");
        assert_eq!(said(&with_sheet(sheet(&inline))), text);
        let shared = |tag: &str, strings: &str| {
            archive(&[
                ("xl/workbook.xml", String::new()),
                (
                    "xl/sharedStrings.xml",
                    format!("<sst {tag}>{strings}</sst>"),
                ),
            ])
        };
        let string = format!("<si><t>{long}</t></si>");
        assert_eq!(said(&shared("", &string)), text);
        let room = said(&shared("uniqueCount = '99999999999999'", "<si/>"));
        assert!(room.contains("99999999999999 shared strings"), "{room}");
        let formats = format!("<styleSheet>{}</styleSheet>", "<xf/>".repeat(65_491));
        let book = |styles: String| {
            archive(&[
                ("xl/workbook.xml", String::new()),
                ("xl/styles.xml", styles),
            ])
        };
        assert_eq!(said(&book(formats)), "more than 65490 cell formats");
        let code = format!("<numFmt formatCode=\"{}\"/>", "0".repeat(2048));
        let long = "a number format in the workbook is longer than 2048 bytes";
        assert_eq!(said(&book(code)), long);
    }

    #[test]
    fn too_many_cells_and_rows_are_refused_before_the_rest_is_read() {
        let said = |cells: String| {
            let bytes = with_sheet(sheet(&(cells + "</not closed in order>")));
            let most = most_numbers(bytes.len());
            (read(&bytes).unwrap_err().to_string(), most)
        };
        let (cells, most) = said(format!("<row>{}</row>", "<c/>".repeat(3 << 20)));
        assert_eq!(cells, format!("more than {most} cells in the workbook"));
        let (rows, _) = said("<row/>".repeat((1 << 20) + 1));
        assert_eq!(rows, "more than 1048576 rows in a sheet");
    }

    #[test]
    fn a_text_of_the_greatest_length_is_read() {
        let longest = "x".repeat(32_767);
        let bytes = workbook(&[vec!["t".to_owned(), longest.clone()]]);
        assert_eq!(read(&bytes).unwrap(), format!("t\t{longest}\n"));
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(128))]

        #[test]
        fn no_sheet_does_harm(
            pieces in prop::collection::vec(prop::sample::select(vec![
                "<row>", "</row>", "<row r=\"4294967296\">", "<row r=\"x\">", "<c>", "</c>", "<c r=\"XFD1\">", "<c r=\"AAAAAAAA9\">",
                "<c r=\"A0\">", "<c t=\"s\">", "<c t=\"e\">", "<c s=\"99\">", "<c s=\"1\">", "<v>1e999</v>", "<v>7</v>", "<v>-1</v>", "<v>",
                "</v>", "<is>", "<t>x</t>", "</is>", "&amp;", "&#0;", "<![CDATA[", "<!--", "\u{feff}", "<f>", "</sheetData>",
            ]), 0..30),
        ) {
            let _ = read(&with_sheet(sheet(&pieces.concat())));
        }

        #[test]
        fn no_bytes_do_harm(at in 0usize..2000, byte in any::<u8>(), cut in 0usize..2000) {
            let mut bytes = workbook(&[vec!["t".to_owned(), "z_f".to_owned()], vec!["1".to_owned(), "2".to_owned()]]);
            let length = bytes.len();
            bytes[at % length] = byte;
            bytes.truncate(length - cut % 40);
            let _ = read(&bytes);
        }
    }
}
