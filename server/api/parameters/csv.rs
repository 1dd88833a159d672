//! Parameters as CSV.

use crate::api::parameter_view::ParameterView;

pub const HEAD: &str = "job,bike,identified_at,method,axle,name,value,std_error,unit,verdict,version,made_up,\
    ridden_at,pressure_front_bar,pressure_rear_bar,temperature_c,rider,rider_mass_kg,tyres,road,tags,notes,further\n";

/// A line for each parameter.
pub fn lines(items: &[ParameterView]) -> String {
    let mut csv = String::new();
    let number = |value: Option<f64>| value.map(|value| value.to_string()).unwrap_or_default();
    let text = |value: Option<&str>| value.map(cell).unwrap_or_default();
    for item in items {
        let facts = &item.facts;
        let cells = [
            item.job.to_string(),
            cell(&item.bike),
            item.identified_at.clone(),
            item.method.clone(),
            item.axle.clone(),
            cell(&item.name),
            item.value.to_string(),
            number(item.std_error),
            cell(&item.unit),
            item.verdict.clone().unwrap_or_default(),
            item.version.clone(),
            item.made_up.to_string(),
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
        ];
        csv.push_str(&cells.join(","));
        csv.push('\n');
    }
    csv
}

/// A text cell, quoted where it must be, and never a formula to a spreadsheet.
fn cell(text: &str) -> String {
    let guard = if text.starts_with(['=', '+', '-', '@', '\t', '\r']) {
        "'"
    } else {
        ""
    };
    if guard.is_empty() && !text.contains([',', '"', '\n', '\r']) {
        return text.to_owned();
    }
    format!("\"{guard}{}\"", text.replace('"', "\"\""))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_cells_are_quoted_and_no_formulas() {
        assert_eq!(cell("lab-7"), "lab-7");
        assert_eq!(cell("a,\"b\""), "\"a,\"\"b\"\"\"");
        assert_eq!(cell("=HYPERLINK(1)"), "\"'=HYPERLINK(1)\"");
    }
}
