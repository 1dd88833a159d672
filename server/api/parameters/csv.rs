//! Parameters as CSV.

use super::columns::{COLUMNS, Values};
use crate::api::parameter_view::ParameterView;

/// The names of the columns.
pub fn head() -> csv::Result<Vec<u8>> {
    written([COLUMNS.iter().map(|column| column.name.to_owned())])
}

/// A line for each parameter.
pub fn lines(items: &[ParameterView]) -> csv::Result<Vec<u8>> {
    written(items.iter().map(line))
}

fn written<L: Iterator<Item = String>>(lines: impl IntoIterator<Item = L>) -> csv::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let mut writer = csv::Writer::from_writer(&mut bytes);
    for line in lines {
        writer.write_record(line.map(String::into_bytes))?;
    }
    writer.flush()?;
    drop(writer);
    Ok(bytes)
}

fn line(item: &ParameterView) -> impl Iterator<Item = String> {
    COLUMNS.iter().map(|column| match column.values {
        Values::Text(of) => of(item).map(|text| guarded(&text)).unwrap_or_default(),
        Values::Json(of) => of(item).unwrap_or_default(),
        Values::Number(of) => of(item).map(|x| x.to_string()).unwrap_or_default(),
        Values::Identified => item.identified_at.clone(),
    })
}

/// A text that is never a formula to a spreadsheet.
fn guarded(text: &str) -> String {
    let formula = text.starts_with(['=', '+', '-', '@', '\t', '\r']);
    format!("{}{text}", if formula { "'" } else { "" })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn text_cells_are_quoted_and_no_formulas() {
        let cells = ["lab-7", "a,\"b\"", "=HYPERLINK(1)", "=A1,B1"].map(guarded);
        let text = String::from_utf8(written([cells.into_iter()]).unwrap()).unwrap();
        let expected = "lab-7,\"a,\"\"b\"\"\",'=HYPERLINK(1),\"'=A1,B1\"\n";
        assert_eq!(text, expected);
        let head = head().unwrap();
        assert!(head.ends_with(b",further,ride,file,low,high,page\n"));
    }
}
