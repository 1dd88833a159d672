//! Columns of lists of parameters as CSV and Parquet.

use crate::api::parameter_view::ParameterView;

/// The values of a column, by row.
#[derive(Clone, Copy)]
pub enum Values {
    Text(fn(&ParameterView) -> Option<String>),
    /// A JSON document.
    Json(fn(&ParameterView) -> Option<String>),
    Number(fn(&ParameterView) -> Option<f64>),
    /// Time of the identification.
    Identified,
}

pub struct Column {
    pub name: &'static str,
    /// Whether each row has a value.
    #[cfg_attr(
        not(feature = "parquet"),
        expect(dead_code, reason = "CSV has no schema")
    )]
    pub required: bool,
    pub values: Values,
}

const fn each(name: &'static str, of: fn(&ParameterView) -> Option<String>) -> Column {
    Column {
        name,
        required: true,
        values: Values::Text(of),
    }
}

const fn text(name: &'static str, of: fn(&ParameterView) -> Option<String>) -> Column {
    Column {
        name,
        required: false,
        values: Values::Text(of),
    }
}

const fn number(name: &'static str, of: fn(&ParameterView) -> Option<f64>) -> Column {
    Column {
        name,
        required: false,
        values: Values::Number(of),
    }
}

pub const COLUMNS: [Column; 27] = [
    each("job", |row| Some(row.job.to_string())),
    each("bike", |row| Some(row.bike.clone())),
    Column {
        name: "identified_at",
        required: true,
        values: Values::Identified,
    },
    each("method", |row| Some(row.method.clone())),
    each("axle", |row| Some(row.axle.clone())),
    each("name", |row| Some(row.name.clone())),
    Column {
        name: "value",
        required: true,
        values: Values::Number(|row| Some(row.value)),
    },
    number("std_error", |row| row.std_error),
    each("unit", |row| Some(row.unit.clone())),
    text("verdict", |row| row.verdict.clone()),
    each("version", |row| Some(row.version.clone())),
    text("ridden_at", |row| row.facts.ridden_at.clone()),
    number("pressure_front_bar", |row| row.facts.pressure_front_bar),
    number("pressure_rear_bar", |row| row.facts.pressure_rear_bar),
    number("temperature_c", |row| row.facts.temperature_c),
    text("rider", |row| row.facts.rider.clone()),
    number("rider_mass_kg", |row| row.facts.rider_mass_kg),
    text("tyres", |row| row.facts.tyres.clone()),
    text("road", |row| row.facts.road.clone()),
    text("tags", ParameterView::tags),
    text("notes", |row| row.facts.notes.clone()),
    Column {
        name: "further",
        required: false,
        values: Values::Json(ParameterView::further),
    },
    each("ride", |row| Some(row.ride.to_string())),
    each("file", |row| Some(row.file.clone())),
    number("low", |row| row.low),
    number("high", |row| row.high),
    each("page", |row| Some(row.page.clone())),
];
