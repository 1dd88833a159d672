#![allow(clippy::unwrap_used)]
use std::io::Write as _;

use proptest::prelude::*;
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

use super::*;
use crate::formats::spreadsheet::is_xlsx;

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
    with_sheets(sheet, None)
}

fn with_sheets(sheet: String, second: Option<String>) -> Vec<u8> {
    let more = match second {
        Some(_) => "<sheet name=\"Data\" sheetId=\"2\" r:id=\"r2\"/>",
        None => "",
    };
    let book = format!(
        "<workbook xmlns=\"{MAIN}\" xmlns:r=\"{RELATIONS}\"><sheets><sheet name=\"log\" sheetId=\"1\" r:id=\"r1\"/>{more}</sheets></workbook>"
    );
    let relations = format!(
        "<Relationships xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\"><Relationship Id=\"r1\" \
         Type=\"{RELATIONS}/worksheet\" Target=\"worksheets/sheet1.xml\"/><Relationship Id=\"r2\" Type=\"{RELATIONS}/worksheet\" Target=\"worksheets/sheet2.xml\"/></Relationships>"
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
        ("xl/worksheets/sheet2.xml", second.unwrap_or_default()),
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
fn the_first_sheet_with_a_table_of_numbers_is_read() {
    let info = "<row><c t=\"inlineStr\"><is><t>Ride</t></is></c><c><v>7</v></c></row>";
    let row = "<row><c><v>1</v></c><c><v>2</v></c></row>".repeat(2);
    let bytes = with_sheets(sheet(info), Some(sheet(&row)));
    let read = super::sheet(&bytes, &Limits::default()).unwrap();
    assert_eq!(read.text, "1.0\t2.0\n1.0\t2.0\n");
    let warning = "the first sheet, \"log\", has no table of numbers: the sheet \"Data\" is read";
    assert_eq!(read.warning.as_deref(), Some(warning));
    let bytes = with_sheets(sheet(info), Some(sheet(info)));
    assert!(
        super::sheet(&bytes, &Limits::default())
            .unwrap()
            .warning
            .is_none()
    );
}

#[test]
fn formulas_without_stored_values_are_refused() {
    let row = "<row><c><v>1</v></c><c><v>3</v></c><c><f>A1+1</f></c></row>".repeat(3);
    let error = read(&with_sheet(sheet(&row))).unwrap_err();
    assert_eq!(error.kind(), "no-formula-values");
    assert!(
        error
            .to_string()
            .starts_with("the 3 formulas of sheet \"log\""),
        "{error}"
    );
    let stored = row.replace("</f>", "</f><v>2</v>");
    assert!(read(&with_sheet(sheet(&stored))).is_ok());
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
        let most = Limits::default().most_numbers(bytes.len());
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
