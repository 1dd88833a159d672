//! Facts as text: fields of a form, and lines `name: value`.

use serde_json::{Map, Value};

use super::Facts;
use super::error::FactsError;
use super::known::{MOMENT, NUMBERS, TEXTS, few, is_name};
use crate::unique::Unique;

/// Names of the facts that a form has a field for; `more` holds lines.
const FIELDS: [&str; 3] = [MOMENT, "tags", "more"];

/// The fields of a form.
pub fn names() -> impl Iterator<Item = &'static str> {
    let numbers = NUMBERS.iter().map(|known| known.0);
    let texts = TEXTS.iter().map(|known| known.0);
    FIELDS.into_iter().chain(numbers).chain(texts)
}

/// Adds a field of a form: `more` holds further numbers, a line each.
pub fn from_form(
    document: &mut Map<String, Value>,
    name: &str,
    text: &str,
) -> Result<(), FactsError> {
    add(
        document,
        match name {
            "more" => of_further((1..).zip(text.lines()))?,
            name => Map::from_iter([(name.to_owned(), value(name, text)?)]),
        },
    )
}

/// Adds the facts of a JSON object.
pub fn from_json(document: &mut Map<String, Value>, text: &str) -> Result<(), FactsError> {
    let Unique(value) = serde_json::from_str(text)?;
    add(document, serde_json::from_value(value)?)
}

fn add(document: &mut Map<String, Value>, added: Map<String, Value>) -> Result<(), FactsError> {
    for (name, value) in added {
        if document.insert(name.clone(), value).is_some() {
            return Err(FactsError::Twice(name));
        }
    }
    Ok(())
}

/// The facts among numbered lines of prose: `name: value` where the name is known, or may be one and the value is a
/// number, as far as there is room for further ones. What comes twice counts as it comes first.
pub fn of_lines(
    lines: impl IntoIterator<Item = (usize, String)>,
) -> Result<Map<String, Value>, FactsError> {
    let (mut found, mut further) = (Map::new(), 0);
    for (line, text) in lines {
        let Some((name, text)) = text.split_once(':') else {
            continue;
        };
        let (name, text) = (name.trim(), text.trim());
        let named = name != "more" && names().any(|known| known == name);
        let is_further = is_name(name) && text.parse::<f64>().is_ok_and(f64::is_finite);
        if text.is_empty() || found.contains_key(name) || !(named || is_further) {
            continue;
        }
        if !named {
            further += 1;
            if few("further numbers", further).is_err() {
                continue;
            }
        }
        let value = sound(name, text).map_err(|error| FactsError::Line {
            line,
            error: Box::new(error),
        })?;
        found.insert(name.to_owned(), value);
    }
    Ok(found)
}

/// The value of a line, if it may be the fact's.
fn sound(name: &str, text: &str) -> Result<Value, FactsError> {
    let value = value(name, text)?;
    Facts::try_from(Map::from_iter([(name.to_owned(), value.clone())]))?;
    Ok(value)
}

/// Lines that all hold a number.
fn of_further<'a>(
    lines: impl Iterator<Item = (usize, &'a str)>,
) -> Result<Map<String, Value>, FactsError> {
    let mut found = Map::new();
    for (line, text) in lines.filter(|(_, text)| !text.trim().is_empty()) {
        let (name, text) = text.split_once(':').unwrap_or((text, ""));
        let value = number(name.trim(), text.trim()).map_err(|error| FactsError::Line {
            line,
            error: Box::new(error),
        })?;
        found.insert(name.trim().to_owned(), value);
    }
    Ok(found)
}

fn value(name: &str, text: &str) -> Result<Value, FactsError> {
    let is_text = name == MOMENT || TEXTS.iter().any(|known| known.0 == name);
    match name {
        "tags" => Ok(text
            .split(',')
            .map(str::trim)
            .filter(|tag| !tag.is_empty())
            .collect()),
        _ if is_text => Ok(Value::from(text)),
        _ => number(name, text),
    }
}

fn number(name: &str, text: &str) -> Result<Value, FactsError> {
    let number = text.replace(',', ".").parse::<f64>().ok();
    let number = number.filter(|number| number.is_finite());
    number
        .map(Value::from)
        .ok_or_else(|| FactsError::kind(name, text, "a number"))
}
