//! From single fields to a bicycle, with what is wrong with each of them.

use std::collections::BTreeMap;

use serde::Serialize;
use serde_json::{Map, Value};
use utoipa::ToSchema;
use veloid_engine::bicycle::Bike;

use super::fields::{self, EQUAL, Field, NAME, WHEELBASE};
use super::lengths::{Known, split};
use crate::decimal::with_point;
use crate::unique::shown;

/// A fault of one part.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[schema(as = BikeFault)]
pub struct Fault {
    /// Name of the part.
    #[schema(value_type = String)]
    pub part: &'static str,
    /// What is wrong with it, and what was expected.
    pub detail: String,
}

/// The bicycle that these fields describe.
pub fn of_fields(fields: &BTreeMap<&'static str, String>) -> Result<Bike, Vec<Fault>> {
    let mut document = Map::new();
    let mut faults = Vec::new();
    for (part, text) in fields {
        match value(part, text) {
            Ok(value) => {
                document.insert(key(part).to_owned(), value);
            }
            Err(detail) => faults.push(Fault { part, detail }),
        }
    }
    let wheelbase = document.remove(WHEELBASE);
    for part in fields
        .keys()
        .filter(|part| document.contains_key(key(part)))
    {
        if let Err(detail) = bike(alone(part, &document)) {
            faults.push(Fault { part, detail });
        }
    }
    if let Some(wheelbase) = wheelbase.as_ref().and_then(Value::as_f64) {
        match lengths(wheelbase, &document) {
            Ok(lengths) => document.extend(lengths),
            Err(detail) => faults.push(Fault {
                part: WHEELBASE,
                detail,
            }),
        }
    }
    if faults.is_empty() {
        return bike(document).map_err(|detail| vec![Fault { part: NAME, detail }]);
    }
    Err(faults)
}

/// The bike file's key for a part.
fn key(part: &'static str) -> &'static str {
    match part {
        NAME => "bike",
        part => part,
    }
}

fn value(part: &str, text: &str) -> Result<Value, String> {
    if let Some(field) = fields::number(part) {
        return number(field, text);
    }
    match part {
        EQUAL => crate::options::boolean(part, text)
            .map(Value::Bool)
            .map_err(|fault| fault.to_string()),
        _ => Ok(Value::from(text)),
    }
}

/// A number, perhaps with the field's own unit behind it. No other unit is converted.
fn number(field: &Field, text: &str) -> Result<Value, String> {
    let bare = text.trim();
    let bare = bare.strip_suffix(field.unit).unwrap_or(bare).trim_end();
    let read = with_point(bare).parse().ok();
    let read = read.filter(|number: &f64| number.is_finite());
    read.map(Value::from).ok_or_else(|| {
        format!(
            "{}: '{}', expected a number of {} such as {}",
            field.name,
            shown(text),
            field.unit,
            field.example
        )
    })
}

/// The key of this part by itself; a standard deviation with the mass that it belongs to.
fn alone(part: &'static str, document: &Map<String, Value>) -> Map<String, Value> {
    let mass = part
        .strip_suffix("_std_kg")
        .map(|axle| format!("{axle}_kg"));
    let keys = [Some(key(part).to_owned()), mass];
    let known = keys.into_iter().flatten();
    known
        .filter_map(|key| Some((key.clone(), document.get(&key)?.clone())))
        .collect()
}

fn bike(document: Map<String, Value>) -> Result<Bike, String> {
    let text = Value::Object(document).to_string();
    Bike::from_json(&text).map_err(|error| error.to_string())
}

/// The two lengths of a bike file on this wheelbase.
fn lengths(wheelbase: f64, document: &Map<String, Value>) -> Result<Map<String, Value>, String> {
    let number = |name: String| document.get(&name).and_then(Value::as_f64);
    let known = |axle: &str| Known {
        length_m: number(format!("l_{axle}_m")),
        load_n: number(format!("static_load_{axle}_n")),
        mass_kg: number(format!("mass_{axle}_kg")),
    };
    let [front, rear] = split(wheelbase, known("front"), known("rear"))?;
    let lengths = Map::from_iter([
        ("l_front_m".to_owned(), Value::from(front)),
        ("l_rear_m".to_owned(), Value::from(rear)),
    ]);
    bike(lengths.clone())
        .map(|_| lengths)
        .map_err(|detail| format!("{WHEELBASE}: {detail}"))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn read(fields: &[(&'static str, &str)]) -> Result<Bike, Vec<Fault>> {
        let fields = fields
            .iter()
            .map(|(part, text)| (*part, (*text).to_owned()));
        of_fields(&fields.collect())
    }

    #[test]
    fn every_field_becomes_its_key() {
        let masses = [("mass_front_kg", "23"), ("mass_rear_kg", "63 kg")];
        let bike = read(&[&masses[..], &[("wheelbase_m", "1.101")]].concat()).unwrap();
        assert_eq!(
            (bike.mass_front_kg, bike.mass_rear_kg),
            (Some(23.0), Some(63.0))
        );
        assert!((bike.wheelbase().unwrap() - 1.101).abs() < 1e-12);
        assert!((bike.l_front_m.unwrap() - 0.8065).abs() < 1e-4);
        for name in fields::names().filter(|name| *name != WHEELBASE) {
            let text = match (name, fields::number(name)) {
                (_, Some(field)) => field.example,
                (EQUAL, _) => "true",
                _ => "lab 7",
            };
            let bike = read(&[&masses[..], &[(name, text)]].concat()).unwrap();
            let document = serde_json::to_value(&bike).unwrap();
            let given = &document[key(name)];
            let expected = match name {
                NAME => Value::from("lab 7"),
                EQUAL => Value::Bool(true),
                _ => Value::from(text.parse::<f64>().unwrap()),
            };
            assert_eq!(*given, expected, "{name}");
        }
    }

    #[test]
    fn a_decimal_comma_is_a_point() {
        let bike = read(&[("mass_front_kg", "23,5 kg"), ("mass_rear_kg", "63,25")]).unwrap();
        assert_eq!(
            (bike.mass_front_kg, bike.mass_rear_kg),
            (Some(23.5), Some(63.25))
        );
    }

    #[test]
    fn each_fault_stands_with_its_field() {
        for (part, text, said) in [
            (
                "mass_front_kg",
                "23000",
                "mass_front_kg is 23000.0, expected 0.1 to 1000",
            ),
            (
                "mass_front_kg",
                "51 lb",
                "'51 lb', expected a number of kg such as 23.0",
            ),
            ("mass_front_kg", "2,3,5", "'2,3,5', expected a number of kg"),
            ("mass_front_kg", "inf", "'inf', expected a number"),
            ("mass_front_kg", "1e999", "expected a number"),
            ("l_front_m", "808 mm", "'808 mm', expected a number of m"),
            ("l_front_m", "808", "l_front_m is 808.0, expected 0.01 to 5"),
            (
                "wheelbase_m",
                "1101",
                "wheelbase_m is 1101.0, expected 0.02 to 10: in millimetres or centimetres?",
            ),
            ("wheelbase_m", "9.9", "wheelbase_m: l_front_m is 7.25"),
            ("wheelbase_m", "110 cm", "'110 cm', expected a number of m"),
            (
                "mass_rear_std_kg",
                "40",
                "mass_rear_std_kg is 40.0, expected 0 to 31.5",
            ),
            ("equal_axles", "yes", "expected true or false"),
            ("bike_name", "..", "a step in a path"),
        ] {
            let mut fields = BTreeMap::from([
                ("mass_front_kg", "23".to_owned()),
                ("mass_rear_kg", "63".to_owned()),
            ]);
            fields.insert(part, text.to_owned());
            let faults = of_fields(&fields).unwrap_err();
            assert_eq!(faults.len(), 1, "{faults:?}");
            assert!(
                faults[0].part == part && faults[0].detail.contains(said),
                "{faults:?}"
            );
        }
        let several = read(&[
            ("mass_front_kg", "x"),
            ("l_rear_m", "9"),
            ("wheelbase_m", "1"),
        ]);
        let parts: Vec<&str> = several
            .unwrap_err()
            .iter()
            .map(|fault| fault.part)
            .collect();
        assert_eq!(parts, ["mass_front_kg", "l_rear_m", "wheelbase_m"]);
    }

    #[test]
    fn a_standard_deviation_needs_its_mass() {
        let faults = read(&[("mass_rear_std_kg", "0.5")]).unwrap_err();
        assert_eq!(faults[0].part, "mass_rear_std_kg");
        assert!(
            faults[0].detail.contains("mass_rear_kg is null"),
            "{faults:?}"
        );
    }
}
