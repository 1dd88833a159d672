//! Parameters as CSV.

use crate::api::parameter_view::ParameterView;

const HEAD: [&str; 24] = [
    "job",
    "bike",
    "identified_at",
    "method",
    "axle",
    "name",
    "value",
    "std_error",
    "unit",
    "verdict",
    "version",
    "ridden_at",
    "pressure_front_bar",
    "pressure_rear_bar",
    "temperature_c",
    "rider",
    "rider_mass_kg",
    "tyres",
    "road",
    "tags",
    "notes",
    "further",
    "ride",
    "file",
];

/// The names of the columns.
pub fn head() -> csv::Result<Vec<u8>> {
    written([HEAD.map(str::to_owned)])
}

/// A line for each parameter.
pub fn lines(items: &[ParameterView]) -> csv::Result<Vec<u8>> {
    written(items.iter().map(line))
}

fn written(lines: impl IntoIterator<Item = [String; 24]>) -> csv::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let mut writer = csv::Writer::from_writer(&mut bytes);
    for line in lines {
        writer.write_record(line)?;
    }
    writer.flush()?;
    drop(writer);
    Ok(bytes)
}

fn line(item: &ParameterView) -> [String; 24] {
    let facts = &item.facts;
    let number = |value: Option<f64>| value.map(|value| value.to_string()).unwrap_or_default();
    let text = |value: Option<&str>| value.map(guarded).unwrap_or_default();
    [
        item.job.to_string(),
        guarded(&item.bike),
        item.identified_at.clone(),
        item.method.clone(),
        item.axle.clone(),
        guarded(&item.name),
        item.value.to_string(),
        number(item.std_error),
        guarded(&item.unit),
        item.verdict.clone().unwrap_or_default(),
        item.version.clone(),
        text(facts.ridden_at.as_deref()),
        number(facts.pressure_front_bar),
        number(facts.pressure_rear_bar),
        number(facts.temperature_c),
        text(facts.rider.as_deref()),
        number(facts.rider_mass_kg),
        text(facts.tyres.as_deref()),
        text(facts.road.as_deref()),
        text(item.tags().as_deref()),
        text(facts.notes.as_deref()),
        text(item.further().as_deref()),
        item.ride.to_string(),
        guarded(&item.file),
    ]
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
        let mut line: [String; 24] = Default::default();
        line[..4].clone_from_slice(&cells);
        let text = String::from_utf8(written([line]).unwrap()).unwrap();
        let expected = "lab-7,\"a,\"\"b\"\"\",'=HYPERLINK(1),\"'=A1,B1\",";
        assert!(text.starts_with(expected), "{text}");
        assert!(text.ends_with(",\n") && head().unwrap().ends_with(b",further,ride,file\n"));
    }
}
