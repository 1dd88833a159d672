//! The facts that have a name, and their bounds.

use jiff::Timestamp;
use jiff::civil::Date;
use jiff::tz::TimeZone;
use serde_json::Value;
use veloid_engine::unseen;

use super::error::FactsError;
use crate::unique::shown;

/// A number: name, unit, bounds, and what a form calls it.
pub const NUMBERS: [(&str, &str, f64, f64, &str); 4] = [
    (
        "pressure_front_bar",
        "bar",
        0.1,
        20.0,
        "Front tyre's pressure (bar)",
    ),
    (
        "pressure_rear_bar",
        "bar",
        0.1,
        20.0,
        "Rear tyre's pressure (bar)",
    ),
    ("temperature_c", "degC", -60.0, 80.0, "Temperature (°C)"),
    ("rider_mass_kg", "kg", 5.0, 300.0, "Rider's mass (kg)"),
];
/// A text: name, longest (characters), and what a form calls it.
pub const TEXTS: [(&str, usize, &str); 4] = [
    ("rider", 200, "Rider"),
    ("tyres", 200, "Tyres"),
    ("road", 200, "Road"),
    ("notes", 4000, "Notes"),
];
/// When it was ridden.
pub const MOMENT: &str = "ridden_at";
const TAGS: usize = 20;
const TAG: usize = 40;
/// Further numbers, and the longest name of one.
const FURTHER: usize = 50;
pub const NAME: usize = 60;
/// Clocks and time zones differ by so much (ms).
const DAY_MS: i64 = 86_400_000;

/// Reads a day (its beginning, UTC) or a time (RFC 3339) as epoch milliseconds.
pub fn moment(text: &str) -> Option<i64> {
    let time = match text.len() {
        10 => text
            .parse::<Date>()
            .ok()?
            .to_zoned(TimeZone::UTC)
            .ok()?
            .timestamp(),
        _ => text.parse::<Timestamp>().ok()?,
    };
    Some(time.as_millisecond())
}

pub fn number(name: &str, value: Value) -> Result<Option<f64>, FactsError> {
    let Some(value) = finite(name, value)? else {
        return Ok(None);
    };
    let bounds = NUMBERS.iter().find(|known| known.0 == name);
    match bounds {
        Some((_, unit, least, most, _)) if !(*least..=*most).contains(&value) => {
            Err(FactsError::Range {
                name: name.to_owned(),
                value,
                unit,
                least: *least,
                most: *most,
            })
        }
        _ => Ok(Some(value)),
    }
}

fn finite(name: &str, value: Value) -> Result<Option<f64>, FactsError> {
    match value {
        Value::Null => Ok(None),
        value => match value.as_f64().filter(|number| number.is_finite()) {
            Some(number) => Ok(Some(number)),
            None => Err(FactsError::kind(name, &value.to_string(), "a number")),
        },
    }
}

/// A text without blanks at its ends; none where nothing is left.
pub fn text(name: &str, value: Value) -> Result<Option<String>, FactsError> {
    let text = match value {
        Value::Null => return Ok(None),
        Value::String(text) => text.trim().to_owned(),
        value => return Err(FactsError::kind(name, &value.to_string(), "a text")),
    };
    if name == MOMENT {
        return date(text);
    }
    let most = TEXTS.iter().find(|known| known.0 == name);
    bounded(name, &text, most.map_or(0, |known| known.1))?;
    Ok((!text.is_empty()).then_some(text))
}

fn bounded(name: &str, text: &str, most: usize) -> Result<(), FactsError> {
    let length = text.chars().count();
    if length > most {
        let name = name.to_owned();
        return Err(FactsError::Long { name, length, most });
    }
    let breaks: &[char] = if name == "notes" { &['\n', '\r'] } else { &[] };
    match unseen(text).find(|c| !breaks.contains(c)) {
        Some(found) => Err(FactsError::Unseen {
            name: name.to_owned(),
            code: found.into(),
        }),
        None => Ok(()),
    }
}

fn date(text: String) -> Result<Option<String>, FactsError> {
    if text.is_empty() {
        return Ok(None);
    }
    const EXPECTED: &str = "a day such as 2026-05-01 or a time such as 2026-05-01T10:30:00Z";
    let ms = moment(&text).ok_or_else(|| FactsError::kind(MOMENT, &text, EXPECTED))?;
    if ms > Timestamp::now().as_millisecond() + DAY_MS {
        return Err(FactsError::Ahead(text));
    }
    Ok(Some(text))
}

/// Tags in order, each once.
pub fn tags(value: Value) -> Result<Vec<String>, FactsError> {
    let expected = "an array of texts";
    let items = match value {
        Value::Null => Vec::new(),
        Value::Array(items) => items,
        value => return Err(FactsError::kind("tags", &value.to_string(), expected)),
    };
    few_of("tags", items.len(), TAGS)?;
    let mut tags = Vec::new();
    for item in items {
        let Value::String(tag) = item else {
            return Err(FactsError::kind("tags", &item.to_string(), expected));
        };
        let tag = tag.trim();
        bounded("tags", tag, TAG)?;
        if !tag.is_empty() && !tags.iter().any(|known| known == tag) {
            tags.push(tag.to_owned());
        }
    }
    Ok(tags)
}

/// A number under a name that is not known here.
pub fn further(name: &str, value: Value) -> Result<Option<f64>, FactsError> {
    if is_name(name) && (value.is_null() || value.is_number()) {
        return finite(name, value);
    }
    let names = NUMBERS.iter().map(|known| known.0);
    let names = names.chain(TEXTS.iter().map(|known| known.0));
    let known: Vec<&str> = [MOMENT, "tags"].into_iter().chain(names).collect();
    Err(FactsError::Unknown {
        name: shown(name),
        known: known.join(", "),
    })
}

/// Whether a further number may have this name.
pub fn is_name(name: &str) -> bool {
    let tail = |byte: u8| byte.is_ascii_lowercase() || byte.is_ascii_digit() || byte == b'_';
    name.len() <= NAME
        && name.starts_with(|first: char| first.is_ascii_lowercase())
        && name.bytes().all(tail)
}

pub fn few(what: &'static str, count: usize) -> Result<(), FactsError> {
    few_of(what, count, FURTHER)
}

fn few_of(what: &'static str, count: usize, most: usize) -> Result<(), FactsError> {
    match count > most {
        true => Err(FactsError::Many { what, count, most }),
        false => Ok(()),
    }
}
