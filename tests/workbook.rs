//! Spreadsheets as an attacker makes them.

use std::io::Write as _;

/// The start of an entry, in its two places, up to its sizes.
const LOCAL: &[u8] = b"PK\x03\x04";
const CENTRAL: &[u8] = b"PK\x01\x02\x14\x00";
const NO_STYLES: &str = "<styleSheet/>";
const FORMAT: &[u8] = b"\x14\x00\x00\x00\x08\x00\x00\x00\x00\x00";

/// A zip archive of these parts.
fn archive(parts: &[(&str, &[u8])]) -> Vec<u8> {
    let (mut file, mut directory) = (Vec::new(), Vec::new());
    for (name, bytes) in parts {
        let mut packer =
            flate2::write::DeflateEncoder::new(Vec::new(), flate2::Compression::best());
        packer.write_all(bytes).unwrap();
        let packed = packer.finish().unwrap();
        let mut sum = flate2::Crc::new();
        sum.update(bytes);
        let sizes = [sum.sum(), packed.len() as u32, bytes.len() as u32];
        let sizes = sizes.map(u32::to_le_bytes).concat();
        let length = (name.len() as u16).to_le_bytes();
        let at = (file.len() as u32).to_le_bytes();
        directory.extend([CENTRAL, FORMAT, &sizes, &length, &[0; 12], &at].concat());
        directory.extend(name.as_bytes());
        file.extend([LOCAL, FORMAT, &sizes, &length, &[0; 2], name.as_bytes()].concat());
        file.extend(packed);
    }
    let count = (parts.len() as u16).to_le_bytes();
    let places = [directory.len() as u32, file.len() as u32];
    let places = places.map(u32::to_le_bytes).concat();
    file.extend(directory);
    file.extend([b"PK\x05\x06\0\0\0\0", &count[..], &count, &places, &[0; 2]].concat());
    file
}

/// A workbook with these cells, shared strings and styles.
fn workbook(cells: &str, strings: &str, styles: &str) -> Vec<u8> {
    const MAIN: &str = "http://schemas.openxmlformats.org/spreadsheetml/2006/main";
    const OFFICE: &str = "http://schemas.openxmlformats.org/officeDocument/2006/relationships";
    const PACKAGE: &str = "http://schemas.openxmlformats.org/package/2006/relationships";
    let leads = |kind: &str, to: &str| {
        format!(
            "<Relationships xmlns=\"{PACKAGE}\"><Relationship Id=\"r1\" Type=\"{OFFICE}/{kind}\" Target=\"{to}\"/></Relationships>"
        )
    };
    let book = format!(
        "<workbook xmlns=\"{MAIN}\" xmlns:r=\"{OFFICE}\"><sheets><sheet name=\"log\" sheetId=\"1\" r:id=\"r1\"/></sheets></workbook>"
    );
    let sheet = format!("<worksheet xmlns=\"{MAIN}\"><sheetData>{cells}</sheetData></worksheet>");
    archive(&[
        (
            "_rels/.rels",
            leads("officeDocument", "xl/workbook.xml").as_bytes(),
        ),
        ("xl/workbook.xml", book.as_bytes()),
        (
            "xl/_rels/workbook.xml.rels",
            leads("worksheet", "worksheets/sheet1.xml").as_bytes(),
        ),
        ("xl/sharedStrings.xml", strings.as_bytes()),
        ("xl/styles.xml", styles.as_bytes()),
        ("xl/worksheets/sheet1.xml", sheet.as_bytes()),
    ])
}

/// A sheet with one text of so many characters.
pub fn one_text(characters: usize) -> Vec<u8> {
    let text = "x".repeat(characters);
    let cells = format!("<row><c t=\"inlineStr\"><is><t>{text}</t></is></c></row>");
    workbook(&cells, "<sst/>", NO_STYLES)
}

/// A workbook that says it has so many shared strings.
pub fn promised_strings(count: u64) -> Vec<u8> {
    let cells = "<row><c t=\"s\"><v>0</v></c></row>";
    let strings = format!("<sst uniqueCount=\"{count}\"><si><t>t</t></si></sst>");
    workbook(cells, &strings, NO_STYLES)
}

/// A workbook of so many formats, each of which has a font whose name has 60 000 characters.
pub fn long_fonts(formats: usize) -> Vec<u8> {
    let (name, formats) = ("n".repeat(60_000), "<xf fontId=\"0\"/>".repeat(formats));
    let styles = format!(
        "<styleSheet><fonts><font><name val=\"{name}\"/></font></fonts><cellXfs>{formats}</cellXfs></styleSheet>"
    );
    let cells = "<row><c t=\"inlineStr\"><is><t>t</t></is></c></row>";
    workbook(cells, "<sst/>", &styles)
}

/// A workbook of so many cells, whose XML is malformed after them.
pub fn malformed_after(cells: usize) -> Vec<u8> {
    let cells = "<c><v>1</v></c>".repeat(cells);
    workbook(&format!("<row>{cells}</c>"), "<sst/>", NO_STYLES)
}

/// A ride as a spreadsheet.
pub fn of_table(csv: &str) -> Vec<u8> {
    let cell = |text: &str| match text.parse::<f64>() {
        Ok(_) => format!("<c><v>{text}</v></c>"),
        Err(_) => format!("<c t=\"inlineStr\"><is><t>{text}</t></is></c>"),
    };
    let row = |line: &str| {
        format!(
            "<row>{}</row>",
            line.split(',').map(cell).collect::<String>()
        )
    };
    workbook(
        &csv.lines().map(row).collect::<String>(),
        "<sst/>",
        NO_STYLES,
    )
}
