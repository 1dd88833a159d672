//! What the parts of an upload say of its bicycle.

use std::collections::BTreeMap;

use serde::Deserialize;
use serde_json::Value;
use utoipa::ToSchema;
use veloid_engine::seen;

use super::fields;

/// How a bicycle is given.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Way {
    /// Chosen from the fleet: the part `fleet`.
    Fleet,
    /// Described in single fields.
    Fields,
    /// A bike file, or a name: the part `bike`.
    File,
}

impl Way {
    pub const ALL: [Way; 3] = [Way::Fleet, Way::Fields, Way::File];

    pub fn name(self) -> &'static str {
        match self {
            Way::Fleet => "fleet",
            Way::Fields => "fields",
            Way::File => "file",
        }
    }
}

/// The parts, as they came.
#[derive(Clone, Debug, Default)]
pub struct Given {
    /// The way that a form's sender has chosen; what stands in the fields of another one does not count then.
    pub way: Option<Way>,
    /// The part `bike`: a bike file, or the name of a bike of the fleet.
    pub file: Option<String>,
    pub fleet: Option<String>,
    pub fields: BTreeMap<&'static str, String>,
}

/// What counts of them.
pub enum Chosen<'a> {
    /// A bike file, or the name of a bike of the fleet, and the part that it came in.
    Text(&'static str, &'a str),
    Fields(&'a BTreeMap<&'static str, String>),
    Nothing,
}

/// A bicycle given in two ways, of which none was chosen.
#[derive(Debug, thiserror::Error)]
#[error("the bicycle is given by `{text}` and by `{field}`, expected only one of them")]
pub struct TwoWays {
    text: &'static str,
    field: &'static str,
}

/// The part that names the way.
const WAY: &str = "bicycle";

impl Given {
    /// The parts that it knows.
    pub fn names() -> impl Iterator<Item = &'static str> {
        ["bike", "fleet", WAY].into_iter().chain(fields::names())
    }

    /// Adds a part that is not blank; whether it came for the first time, or what was expected in its place.
    pub fn add(&mut self, part: &str, value: &str) -> Result<bool, String> {
        let value = value.to_owned();
        let before = match part {
            "bike" => self.file.replace(value).is_some(),
            "fleet" => self.fleet.replace(value).is_some(),
            WAY => self.way.replace(way(&value)?).is_some(),
            _ => match fields::names().find(|name| *name == part) {
                Some(name) => self.fields.insert(name, value).is_some(),
                None => return Err(format!("unknown part `{part}`")),
            },
        };
        Ok(!before)
    }

    /// The bicycle's name, if it is given; at most 200 characters.
    pub fn name(&self) -> Option<String> {
        let name = match self.chosen().ok()? {
            Chosen::Text(_, text) if text.starts_with('{') => {
                let bike: Value = serde_json::from_str(text).ok()?;
                bike.get("bike")?.as_str()?.to_owned()
            }
            Chosen::Text(_, text) => text.to_owned(),
            Chosen::Fields(fields) => fields.get("bike_name")?.clone(),
            Chosen::Nothing => return None,
        };
        Some(seen(&name).take(200).collect())
    }

    pub fn chosen(&self) -> Result<Chosen<'_>, TwoWays> {
        let file = self.file.as_deref().map(|text| Chosen::Text("bike", text));
        let fleet = self.fleet.as_deref();
        let fleet = fleet.map(|text| Chosen::Text("fleet", text));
        let first = self.fields.keys().next();
        let fields = first.map(|_| Chosen::Fields(&self.fields));
        let chosen = match self.way {
            Some(Way::File) => file,
            Some(Way::Fleet) => fleet,
            Some(Way::Fields) => fields,
            None => match (file.or(fleet), first) {
                (Some(Chosen::Text(text, _)), Some(field)) => {
                    return Err(TwoWays { text, field });
                }
                (text, _) => text.or(fields),
            },
        };
        Ok(chosen.unwrap_or(Chosen::Nothing))
    }
}

fn way(text: &str) -> Result<Way, String> {
    let found = Way::ALL.into_iter().find(|way| way.name() == text);
    found.ok_or_else(|| {
        let shown = crate::unique::shown(text);
        let known = Way::ALL.map(Way::name).join(", ");
        format!("{WAY}: '{shown}', expected {known}")
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn given(parts: &[(&str, &str)]) -> Given {
        let mut given = Given::default();
        for (part, value) in parts {
            assert!(given.add(part, value).unwrap(), "{part}");
        }
        given
    }

    fn said(given: &Given) -> String {
        match given.chosen() {
            Ok(Chosen::Text(part, text)) => format!("{part} {text}"),
            Ok(Chosen::Fields(fields)) => format!("{} fields", fields.len()),
            Ok(Chosen::Nothing) => String::new(),
            Err(two) => two.to_string(),
        }
    }

    #[test]
    fn one_way_counts() {
        let all = [("bike", "{}"), ("fleet", "lab-7"), ("mass_front_kg", "23")];
        for (way, counts) in [
            ("fleet", "fleet lab-7"),
            ("fields", "1 fields"),
            ("file", "bike {}"),
        ] {
            assert_eq!(said(&given(&[&all[..], &[(WAY, way)]].concat())), counts);
            assert_eq!(said(&given(&[(WAY, way)])), "", "chosen and left blank");
        }
        assert_eq!(
            said(&given(&all[..2])),
            "bike {}",
            "as ever, without a choice"
        );
        assert_eq!(said(&given(&all[2..])), "1 fields");
        let two = said(&given(&all[1..]));
        assert!(two.contains("`fleet` and by `mass_front_kg`"), "{two}");
    }

    #[test]
    fn the_name_is_found_whatever_the_way() {
        let name = |part, value| given(&[(part, value)]).name();
        assert_eq!(name("fleet", "lab-7").as_deref(), Some("lab-7"));
        assert_eq!(name("bike", "lab-7").as_deref(), Some("lab-7"));
        let file = name("bike", "{\"bike\": \"lab-7\", \"mass_front_kg\": 1}");
        assert_eq!(file.as_deref(), Some("lab-7"));
        assert_eq!(name("bike_name", "lab-7").as_deref(), Some("lab-7"));
        assert_eq!(name("bike", "a\0b").as_deref(), Some("ab"));
        assert_eq!(name("bike", "{\"bike\": 7"), None);
        assert_eq!(name("mass_front_kg", "23"), None);
        assert_eq!(Given::default().name(), None);
    }

    #[test]
    fn parts_come_once_and_are_known() {
        let mut twice = given(&[("mass_front_kg", "1")]);
        assert!(!twice.add("mass_front_kg", "2").unwrap());
        assert!(
            twice
                .add("mass_frnt_kg", "2")
                .unwrap_err()
                .contains("mass_frnt_kg")
        );
        let odd = twice.add(WAY, "json").unwrap_err();
        assert_eq!(odd, "bicycle: 'json', expected fleet, fields, file");
        for name in Given::names().filter(|name| *name != WAY) {
            assert!(Given::default().add(name, "x").unwrap(), "{name}");
        }
    }
}
