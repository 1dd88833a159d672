//! Jobs by what is known of their rides, and by their results.

use serde::Deserialize;
use utoipa::IntoParams;
use utoipa::openapi::schema::{ObjectBuilder, Schema, Type};

use crate::api::problem::{Kind, Problem};
use crate::facts::is_name;
use crate::store::search::{Range, Search};
use crate::unique::shown;

/// Largest size of a bound.
const LARGEST: f64 = 1e15;
/// Most further facts.
const FACTS: usize = 10;
const EXPECTED: &str = "a number such as 2.2, or a range such as 2:2.5, 2: or :2.5";

#[derive(Default, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub struct SearchParams {
    /// Only jobs of rides whose rider's name contains this, capitals or not.
    pub rider: Option<String>,
    /// Only jobs of rides whose tyres' description contains this, capitals or not.
    pub tyres: Option<String>,
    /// Only jobs of rides whose road's description contains this, capitals or not.
    pub road: Option<String>,
    /// Front tyre pressure (bar): a number, or a range with both ends included: `2:2.5`, `2:`, `:2.5`. So are the following.
    #[param(schema_with = range)]
    pub pressure_front_bar: Option<String>,
    /// Rear tyre pressure (bar).
    #[param(schema_with = range)]
    pub pressure_rear_bar: Option<String>,
    /// Air temperature (degC).
    #[param(schema_with = range)]
    pub temperature_c: Option<String>,
    /// Rider's mass (kg).
    #[param(schema_with = range)]
    pub rider_mass_kg: Option<String>,
    /// Further facts that are numbers, separated by commas, each with a number or a range: `stem_mm:80:100,fork_clicks:7`.
    #[param(max_length = 500)]
    pub fact: Option<String>,
    /// Stiffness of the front axle in the result (N/m), such as `50000:60000`.
    #[param(schema_with = range)]
    pub k_front: Option<String>,
    /// Damping of the front axle in the result (N s/m).
    #[param(schema_with = range)]
    pub b_front: Option<String>,
    /// Mass on the front axle in the result (kg).
    #[param(schema_with = range)]
    pub mass_front: Option<String>,
    /// Stiffness of the rear axle in the result (N/m).
    #[param(schema_with = range)]
    pub k_rear: Option<String>,
    /// Damping of the rear axle in the result (N s/m).
    #[param(schema_with = range)]
    pub b_rear: Option<String>,
    /// Mass on the rear axle in the result (kg).
    #[param(schema_with = range)]
    pub mass_rear: Option<String>,
}

fn range() -> Schema {
    const NUMBER: &str = r"-?[0-9]{1,12}(\.[0-9]{1,9})?";
    let pattern = format!("^({NUMBER}|{NUMBER}:|:{NUMBER})?$");
    let object = ObjectBuilder::new().schema_type(Type::String);
    object
        .pattern(Some(pattern))
        .examples(["2.2", "2:", ":2.5"])
        .build()
        .into()
}

/// A field of a search: its name and what stands in it, if anything does.
pub type Field<'a> = (&'static str, Option<&'a str>);

impl SearchParams {
    pub fn texts(&self) -> [Field<'_>; 3] {
        [
            ("rider", text(&self.rider)),
            ("tyres", text(&self.tyres)),
            ("road", text(&self.road)),
        ]
    }

    pub fn numbers(&self) -> [Field<'_>; 4] {
        [
            ("pressure_front_bar", text(&self.pressure_front_bar)),
            ("pressure_rear_bar", text(&self.pressure_rear_bar)),
            ("temperature_c", text(&self.temperature_c)),
            ("rider_mass_kg", text(&self.rider_mass_kg)),
        ]
    }

    pub fn results(&self) -> [Field<'_>; 6] {
        [
            ("k_front", text(&self.k_front)),
            ("b_front", text(&self.b_front)),
            ("mass_front", text(&self.mass_front)),
            ("k_rear", text(&self.k_rear)),
            ("b_rear", text(&self.b_rear)),
            ("mass_rear", text(&self.mass_rear)),
        ]
    }

    pub fn fact(&self) -> Field<'_> {
        ("fact", text(&self.fact))
    }

    pub fn search(&self) -> Result<Search, Problem> {
        let texts = self.texts().into_iter();
        let texts = texts.filter_map(|(name, part)| Some((name, part?.to_owned())));
        let mut numbers = Vec::new();
        for (name, asked) in self.numbers() {
            if let Some(asked) = asked {
                numbers.push((name.to_owned(), read(name, asked)?));
            }
        }
        numbers.extend(further(self.fact().1.unwrap_or_default())?);
        let mut results = Vec::new();
        for (field, asked) in self.results() {
            if let (Some(asked), Some((axle, name))) = (asked, of_result(field)) {
                results.push((axle, name, read(field, asked)?));
            }
        }
        Ok(Search {
            texts: texts.collect(),
            numbers,
            results,
        })
    }
}

fn text(field: &Option<String>) -> Option<&str> {
    let text = field.as_deref()?.trim();
    (!text.is_empty()).then_some(text)
}

/// Axle and name of a result.
fn of_result(field: &str) -> Option<(&'static str, &'static str)> {
    let (letter, axle) = field.split_once('_')?;
    let axle = if axle == "front" { "front" } else { "rear" };
    let names = [("k", "k_n_m"), ("b", "b_n_s_m"), ("mass", "mass_kg")];
    let (_, name) = names.into_iter().find(|(known, _)| *known == letter)?;
    Some((axle, name))
}

/// `name:from:to` with commas between.
fn further(text: &str) -> Result<Vec<(String, Range)>, Problem> {
    let parts = text
        .split(',')
        .map(str::trim)
        .filter(|part| !part.is_empty());
    let found = parts.map(|part| {
        let wrong = || {
            bad(format!(
                "fact: '{}', expected a name and {EXPECTED}, as in stem_mm:80:100",
                shown(part)
            ))
        };
        let (name, asked) = part.split_once(':').ok_or_else(wrong)?;
        match is_name(name) {
            true => Ok((name.to_owned(), read("fact", asked)?)),
            false => Err(wrong()),
        }
    });
    let found = found.collect::<Result<Vec<_>, _>>()?;
    match found.len() {
        0..=FACTS => Ok(found),
        n => Err(bad(format!("fact: {n} of them, expected at most {FACTS}"))),
    }
}

/// A number, or two with a colon between of which one may be missing.
fn read(name: &str, text: &str) -> Result<Range, Problem> {
    let wrong = || bad(format!("{name}: '{}', expected {EXPECTED}", shown(text)));
    let number = |text: &str, missing: f64| match text.trim() {
        "" => Some(missing),
        text => text.parse().ok().filter(|x: &f64| x.abs() <= LARGEST),
    };
    let (from, to) = match text.split_once(':') {
        Some((from, to)) if from.trim().is_empty() && to.trim().is_empty() => return Err(wrong()),
        Some(ends) => ends,
        None if text.trim().is_empty() => return Err(wrong()),
        None => (text, text),
    };
    let from = number(from, -LARGEST).ok_or_else(wrong)?;
    let to = number(to, LARGEST).ok_or_else(wrong)?;
    match from <= to {
        true => Ok(Range { from, to }),
        false => Err(bad(format!(
            "{name}: from {from} to {to}, expected the smaller number first"
        ))),
    }
}

fn bad(detail: String) -> Problem {
    Problem::new(Kind::BadRequest, detail)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn ranges_are_read_or_refused() {
        for (text, from, to) in [
            ("2.2", 2.2, 2.2),
            ("2:2.5", 2.0, 2.5),
            (" -3 : 4 ", -3.0, 4.0),
            ("2:", 2.0, LARGEST),
            (":2.5", -LARGEST, 2.5),
        ] {
            assert_eq!(read("k", text).unwrap(), Range { from, to }, "{text}");
        }
        for wrong in [
            "", ":", "a", "1:b", "1:2:3", "2:1", "inf", "nan", "1e99", "2-3",
        ] {
            let detail = read("k_front", wrong).unwrap_err().detail;
            assert!(detail.starts_with("k_front: "), "{wrong}: {detail}");
        }
    }

    #[test]
    fn every_field_becomes_a_condition() {
        let some = |text: &str| Some(text.to_owned());
        let params = SearchParams {
            rider: some(" Ada "),
            road: some(""),
            temperature_c: some("10:20"),
            fact: some("stem_mm:80:100, fork_clicks:7"),
            k_front: some("50000:"),
            mass_rear: some("63"),
            ..SearchParams::default()
        };
        let search = params.search().unwrap();
        assert_eq!(search.texts, [("rider", "Ada".to_owned())]);
        let numbers: Vec<&str> = search
            .numbers
            .iter()
            .map(|(name, _)| name.as_str())
            .collect();
        assert_eq!(numbers, ["temperature_c", "stem_mm", "fork_clicks"]);
        let results: Vec<_> = search
            .results
            .iter()
            .map(|(axle, name, _)| (*axle, *name))
            .collect();
        assert_eq!(results, [("front", "k_n_m"), ("rear", "mass_kg")]);
        for wrong in ["stem_mm", "Stem:1", "a'b:1", "rider:Ada", "stem_mm:much"] {
            let params = SearchParams {
                fact: some(wrong),
                ..SearchParams::default()
            };
            assert!(params.search().is_err(), "{wrong}");
        }
    }
}
