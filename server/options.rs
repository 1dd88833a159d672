//! What the user may ask of one identification besides the ride and the bike: the engine's settings
//! and how to read the file, in one flat set of keys that the CLI, the API's `options` document, its
//! query parameters and the web form share.

use std::sync::LazyLock;

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use utoipa::openapi::schema::AdditionalProperties;
use utoipa::openapi::{Object, RefOr, Schema};
use utoipa::{PartialSchema, ToSchema};
use veloid_engine::document::json;
use veloid_engine::ride::ReadOptions;
use veloid_engine::{EngineError, Settings};

use crate::decimal::with_point;
use crate::unique::{Unique, shown};

/// Settings of the identification and of reading the file, side by side.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Map<String, Value>")]
pub struct Options {
    #[serde(flatten)]
    pub settings: Settings,
    #[serde(flatten)]
    pub reading: ReadOptions,
}

impl PartialSchema for Options {
    /// One object with the keys of both: as `allOf` each part would forbid the other's keys.
    fn schema() -> RefOr<Schema> {
        let mut merged = Object::new();
        merged.description = Some("Settings and how to read the file; all optional.".to_owned());
        for part in [Settings::schema(), ReadOptions::schema()] {
            if let RefOr::T(Schema::Object(part)) = part {
                merged.properties.extend(part.properties);
            }
        }
        merged.additional_properties = Some(Box::new(AdditionalProperties::FreeForm(false)));
        merged.into()
    }
}

impl ToSchema for Options {
    fn schemas(schemas: &mut Vec<(String, RefOr<Schema>)>) {
        Settings::schemas(schemas);
        ReadOptions::schemas(schemas);
    }
}

#[derive(Debug, thiserror::Error)]
pub enum OptionsError {
    #[error("options: {0}")]
    Shape(#[from] serde_json::Error),
    #[error("options: {0}")]
    Type(String),
    #[error("options: unknown key `{name}`, expected {known}")]
    Unknown { name: String, known: String },
    #[error("{0}: given twice, expected once")]
    Twice(String),
    #[error("{name}: '{text}', expected true or false")]
    Boolean { name: String, text: String },
    #[error("map: {channel} is given as '{first}' and as '{second}', expected one column")]
    MappedTwice {
        channel: String,
        first: String,
        second: String,
    },
    #[error("rows: '{0}', expected FROM:TO with two whole numbers")]
    Rows(String),
    #[error("band_hz: '{0}', expected LOW:HIGH with two numbers (Hz)")]
    Band(String),
    #[error("map: '{0}', expected CHANNEL=COLUMN such as z_f=V2")]
    Map(String),
    #[error("layout: '{0}', expected KEY=VALUE such as header_row=3 or separator=;")]
    Layout(String),
    #[error("fix: '{0}', expected AXLE.QUANTITY=VALUE such as f.k=60000 (N/m, N s/m)")]
    Fix(String),
    #[error("bound: '{0}', expected AXLE.QUANTITY=LOW:HIGH such as r.B=0:2000 (N/m, N s/m)")]
    Bound(String),
    #[error("offset_s: '{0}', expected FILE:SECONDS, the time by which the file begins later")]
    Offset(String),
    #[error(transparent)]
    Range(#[from] EngineError),
}

/// Keys of [`ReadOptions`]; every other key is a setting.
const READING: [&str; 8] = [
    "map",
    "rate_hz",
    "rows",
    "deflection_sign",
    "band_hz",
    "missing",
    "layout",
    "files",
];

/// Keys of [`Settings`].
static SETTINGS: LazyLock<Vec<String>> = LazyLock::new(|| match Settings::schema() {
    RefOr::T(Schema::Object(object)) => object.properties.into_keys().collect(),
    _ => Vec::new(),
});

/// Keys that are true or false.
static BOOLEAN: LazyLock<Vec<String>> = LazyLock::new(|| {
    let defaults = serde_json::to_value(Options::default()).unwrap_or_default();
    let keys = defaults.as_object().into_iter().flatten();
    keys.filter(|(_, value)| value.is_boolean())
        .map(|(key, _)| key.clone())
        .collect()
});

impl TryFrom<Map<String, Value>> for Options {
    type Error = OptionsError;

    /// Reads a flat document; an unknown key or a wrong type is an error that names it.
    fn try_from(document: Map<String, Value>) -> Result<Self, OptionsError> {
        let keys = || SETTINGS.iter().map(String::as_str).chain(READING);
        if let Some(key) = document
            .keys()
            .find(|key| !keys().any(|known| known == *key))
        {
            let mut known: Vec<&str> = keys().collect();
            known.sort_unstable();
            return Err(OptionsError::Unknown {
                name: shown(key),
                known: known.join(", "),
            });
        }
        let (reading, settings): (Map<_, _>, Map<_, _>) = document
            .into_iter()
            .partition(|(key, _)| READING.contains(&key.as_str()));
        Ok(Self {
            settings: json::from_value(Value::Object(settings)).map_err(OptionsError::Type)?,
            reading: json::from_value(Value::Object(reading)).map_err(OptionsError::Type)?,
        })
    }
}

impl Options {
    /// Adds the `options` document of the API.
    pub fn add_document(document: &mut Map<String, Value>, text: &str) -> Result<(), OptionsError> {
        let Unique(value) = serde_json::from_str(text)?;
        for (key, value) in serde_json::from_value::<Map<String, Value>>(value)? {
            add(document, &key, value)?;
        }
        Ok(())
    }

    /// Adds `key=value` as it stands in a query or a form field: `seed=3`, `rows=0:500`, `missing=NA` once per word,
    /// `layout=header_row=3` once per key and `map=z_f=V2` once per channel. What holds for one file of several has the file's name in front: `rate_hz=laser.csv:30`.
    pub fn add_pair(
        document: &mut Map<String, Value>,
        key: &str,
        value: &str,
    ) -> Result<(), OptionsError> {
        let (file, text) = of_one_file(key, value);
        let value = parsed(key, text)?;
        match file {
            Some(file) => {
                let own = Map::from_iter([(key.to_owned(), value)]);
                let files = Map::from_iter([(file.to_owned(), Value::Object(own))]);
                add(document, "files", Value::Object(files))
            }
            None if key == OFFSET => Err(OptionsError::Offset(text.to_owned())),
            None => add(document, key, value),
        }
    }

    /// What a query or a form may hold as pairs: all keys, and what only a file has.
    pub fn names() -> impl Iterator<Item = &'static str> {
        let keys = SETTINGS.iter().map(String::as_str).chain(READING);
        keys.chain([OFFSET])
    }

    pub fn is_known(key: &str) -> bool {
        Self::names().any(|name| name == key)
    }

    /// Checks every range.
    pub fn validate(&self) -> Result<(), OptionsError> {
        Ok(veloid_engine::validate(&self.settings)?)
    }
}

/// The value of a pair.
fn parsed(key: &str, text: &str) -> Result<Value, OptionsError> {
    Ok(match key {
        "map" => {
            let (channel, column) = channel_and_column(text)?;
            Value::Object(Map::from_iter([(channel, Value::String(column))]))
        }
        "layout" => {
            let pair = text.split_once('=');
            let (key, value) = pair.ok_or_else(|| OptionsError::Layout(text.to_owned()))?;
            let value = match value.trim().parse::<u64>() {
                Ok(row) => Value::from(row),
                Err(_) => Value::String(value.to_owned()),
            };
            Value::Object(Map::from_iter([(key.trim().to_owned(), value)]))
        }
        "fix" if !text.starts_with('{') => {
            fixed(text).ok_or_else(|| OptionsError::Fix(text.to_owned()))?
        }
        "bound" if !text.starts_with('{') => {
            bounded(text).ok_or_else(|| OptionsError::Bound(text.to_owned()))?
        }
        "rows" => {
            let (from, to) = rows(text)?;
            Value::from(vec![from, to])
        }
        "band_hz" if !text.starts_with('[') => {
            let (low, high) = band(text)?;
            Value::from(vec![low, high])
        }
        "missing" => Value::from(vec![text.to_owned()]),
        _ if BOOLEAN.iter().any(|name| name == key) => Value::Bool(boolean(key, text)?),
        _ => serde_json::from_str(text)
            .or_else(|_| serde_json::from_str(&with_point(text)))
            .unwrap_or_else(|_| Value::String(text.to_owned())),
    })
}

/// Adds one key, which comes once; of `map` each channel does, of `layout` each key, of `files` each key of each file.
fn add(document: &mut Map<String, Value>, key: &str, value: Value) -> Result<(), OptionsError> {
    match (document.get_mut(key), value) {
        (None, value) => {
            document.insert(key.to_owned(), value);
        }
        (Some(Value::Array(words)), Value::Array(more)) if key == "missing" => words.extend(more),
        (Some(Value::Object(files)), Value::Object(more)) if key == "files" => {
            for (file, own) in more {
                let before = files
                    .entry(file)
                    .or_insert_with(|| Value::Object(Map::new()));
                if let (Value::Object(before), Value::Object(own)) = (before, own) {
                    for (key, value) in own {
                        add(before, &key, value)?;
                    }
                }
            }
        }
        (Some(Value::Object(layout)), Value::Object(more))
            if ["layout", "fix", "bound"].contains(&key) =>
        {
            for (key, value) in more {
                add(layout, &key, value)?;
            }
        }
        (Some(Value::Object(map)), Value::Object(more)) if key == "map" => {
            for (channel, column) in more {
                let before = map.insert(channel.clone(), column.clone());
                let column = column.as_str().unwrap_or_default().to_owned();
                once(channel, before.as_ref().and_then(Value::as_str), column)?;
            }
        }
        _ => return Err(OptionsError::Twice(shown(key))),
    }
    Ok(())
}

/// `f.k=60000`: what is fixed, with its value.
fn fixed(text: &str) -> Option<Value> {
    let (key, value) = text.split_once('=')?;
    let value = Value::from(number(value)?);
    Some(Value::Object(Map::from_iter([(
        key.trim().to_owned(),
        value,
    )])))
}

/// `r.B=0:2000`: what is bounded, with its ends.
fn bounded(text: &str) -> Option<Value> {
    let (key, ends) = text.split_once('=')?;
    let (low, high) = ends.split_once(':')?;
    let ends = Value::from(vec![number(low)?, number(high)?]);
    Some(Value::Object(Map::from_iter([(
        key.trim().to_owned(),
        ends,
    )])))
}

/// A number; none of `60,000`, which may be sixty or sixty thousand.
fn number(text: &str) -> Option<f64> {
    let three_behind = |(whole, rest): &(&str, &str)| {
        rest.len() == 3 && !matches!(whole.trim_matches(['+', '-']), "" | "0")
    };
    if text.trim().split_once(',').filter(three_behind).is_some() {
        return None;
    }
    let number: f64 = with_point(text.trim()).parse().ok()?;
    number.is_finite().then_some(number)
}

/// What only a file has.
const OFFSET: &str = "offset_s";

/// The file that a pair is about, where it says so: a channel, a rate, rows and an offset hold no colon before their own.
fn of_one_file<'a>(key: &str, value: &'a str) -> (Option<&'a str>, &'a str) {
    let split = match key {
        "map" | "layout" => value
            .find('=')
            .and_then(|equals| value[..equals].rfind(':')),
        "rate_hz" | OFFSET => value.rfind(':'),
        "rows" => value.rfind(':').and_then(|last| value[..last].rfind(':')),
        _ => None,
    };
    match split {
        Some(at) => (Some(value[..at].trim()), value[at + 1..].trim()),
        None => (None, value),
    }
}

/// True or false, also as Python writes them.
pub fn boolean(name: &str, text: &str) -> Result<bool, OptionsError> {
    match text {
        "true" | "True" | "on" => Ok(true),
        "false" | "False" | "off" => Ok(false),
        _ => Err(OptionsError::Boolean {
            name: name.to_owned(),
            text: shown(text),
        }),
    }
}

/// `z_f=V2` as channel and column.
pub fn channel_and_column(text: &str) -> Result<(String, String), OptionsError> {
    text.split_once('=')
        .map(|(channel, column)| (channel.trim().to_owned(), column.trim().to_owned()))
        .ok_or_else(|| OptionsError::Map(text.to_owned()))
}

/// Refuses a second column for a channel.
pub fn once(channel: String, first: Option<&str>, second: String) -> Result<(), OptionsError> {
    match first {
        Some(first) if first != second => Err(OptionsError::MappedTwice {
            channel,
            first: first.to_owned(),
            second,
        }),
        _ => Ok(()),
    }
}

/// `FROM:TO` as two row numbers.
pub fn rows(text: &str) -> Result<(usize, usize), OptionsError> {
    text.split_once(':')
        .and_then(|(from, to)| Some((from.trim().parse().ok()?, to.trim().parse().ok()?)))
        .ok_or_else(|| OptionsError::Rows(text.to_owned()))
}

/// `LOW:HIGH` as two frequencies.
fn band(text: &str) -> Result<(f64, f64), OptionsError> {
    let number = |text: &str| {
        let number = with_point(text.trim()).parse().ok();
        number.filter(|number: &f64| number.is_finite())
    };
    text.split_once(':')
        .and_then(|(low, high)| Some((number(low)?, number(high)?)))
        .ok_or_else(|| OptionsError::Band(text.to_owned()))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn parse(pairs: &[(&str, &str)]) -> Result<Options, OptionsError> {
        let mut document = Map::new();
        for (key, value) in pairs {
            Options::add_pair(&mut document, key, value)?;
        }
        Options::try_from(document)
    }

    #[test]
    fn pairs_and_document_mean_the_same() {
        let pairs = parse(&[
            ("seed", "7"),
            ("objective", "paper"),
            ("map", "z_f=V2"),
            ("map", "force_f=V1"),
            ("rows", "40650:127400"),
            ("rate_hz", "610.35"),
        ])
        .unwrap();
        let document: Options = serde_json::from_str(
            r#"{"seed": 7, "objective": "paper", "map": {"z_f": "V2", "force_f": "V1"},
                "rows": [40650, 127400], "rate_hz": 610.35}"#,
        )
        .unwrap();
        assert_eq!(pairs, document);
        let again: Options =
            serde_json::from_str(&serde_json::to_string(&document).unwrap()).unwrap();
        assert_eq!(again, document);
    }

    #[test]
    fn every_key_is_known() {
        let document = serde_json::to_value(Options::default()).unwrap();
        for key in document.as_object().unwrap().keys() {
            assert!(Options::is_known(key), "{key}");
        }
        for key in Options::names() {
            let odd = Map::from_iter([(key.to_owned(), Value::Object(Map::new()))]);
            let fault = Options::try_from(odd).map_err(|fault| fault.to_string());
            assert!(
                fault
                    .as_ref()
                    .is_ok_and(|_| ["map", "files", "layout", "fix", "bound"].contains(&key))
                    || fault.is_err_and(|fault| !fault.contains("unknown field")),
                "{key}"
            );
        }
        assert!(!Options::is_known("sead"));
    }

    #[test]
    fn what_holds_for_one_file_has_its_name_in_front() {
        let pairs = parse(&[
            ("map", "t=time"),
            ("map", "my:laser.csv:d_r=dist: raw"),
            ("rate_hz", "laser.csv:30"),
            ("layout", "laser.csv:header_row=3"),
            ("layout", "laser.csv:separator=;"),
            ("layout", "time_format=%H:%M"),
            ("rows", "laser.csv:0:500"),
            ("offset_s", "laser.csv:-1.5"),
            ("missing", "NA"),
            ("missing", "-999"),
        ])
        .unwrap();
        let document: Options = serde_json::from_str(
            r#"{"map": {"t": "time"}, "missing": ["NA", "-999"], "files": {
                "my:laser.csv": {"map": {"d_r": "dist: raw"}},
                "laser.csv": {"rate_hz": 30, "rows": [0, 500], "offset_s": -1.5,
                "layout": {"header_row": 3, "separator": ";"}}}, "layout": {"time_format": "%H:%M"}}"#,
        )
        .unwrap();
        assert_eq!(pairs, document);
        let message = |pairs: &[(&str, &str)]| parse(pairs).unwrap_err().to_string();
        assert!(message(&[("offset_s", "1.5")]).contains("FILE:SECONDS"));
        let twice = message(&[("rate_hz", "a.csv:1"), ("rate_hz", "a.csv:1")]);
        assert_eq!(twice, "rate_hz: given twice, expected once");
        assert!(message(&[("offset_s", "a.csv:x")]).contains("offset_s"));
        let plain = serde_json::to_string(&Options::default()).unwrap();
        assert!(!plain.contains("files") && !plain.contains("missing"));
    }

    #[test]
    fn a_decimal_comma_is_a_point() {
        let options = parse(&[
            ("alpha", "0,02"),
            ("rate_hz", "610,35"),
            ("rate_hz", "laser.csv:30,5"),
            ("offset_s", "laser.csv:-1,5"),
        ]);
        let options = options.unwrap();
        assert_eq!(options.settings.alpha, 0.02);
        assert_eq!(options.reading.rate_hz, Some(610.35));
        let laser = &options.reading.files["laser.csv"];
        assert_eq!((laser.rate_hz, laser.offset_s), (Some(30.5), Some(-1.5)));
        assert!(parse(&[("trials", "1,5")]).is_err());
    }

    #[test]
    fn booleans_are_true_or_false() {
        assert_eq!(*BOOLEAN, ["diagnosis"]);
        for (text, meant) in [
            ("true", Some(true)),
            ("True", Some(true)),
            ("false", Some(false)),
            ("False", Some(false)),
            ("on", Some(true)),
            ("off", Some(false)),
            ("TRUE", None),
            ("no", None),
            ("0", None),
            ("1", None),
            ("null", None),
            ("banana", None),
        ] {
            for name in BOOLEAN.iter() {
                let options = parse(&[(name, text)]);
                match meant {
                    Some(meant) => assert_eq!(options.unwrap().settings.diagnosis, meant),
                    None => assert_eq!(
                        options.unwrap_err().to_string(),
                        format!("{name}: '{text}', expected true or false")
                    ),
                }
            }
        }
    }

    /// Pairs and documents, in any order.
    #[test]
    fn a_key_comes_once_wherever_it_stands() {
        let twice = |pair: (&str, &str), text: &str| {
            let (mut first, mut last) = (Map::new(), Map::new());
            let one = Options::add_pair(&mut first, pair.0, pair.1)
                .and_then(|()| Options::add_document(&mut first, text));
            let other = Options::add_document(&mut last, text)
                .and_then(|()| Options::add_pair(&mut last, pair.0, pair.1));
            [one, other].map(|outcome| outcome.is_err())
        };
        assert_eq!(twice(("seed", "1"), r#"{"seed": 1}"#), [true; 2]);
        assert_eq!(twice(("seed", "1"), r#"{"trials": 1}"#), [false; 2]);
        assert_eq!(
            twice(("map", "z_f=a"), r#"{"map": {"z_r": "a"}}"#),
            [false; 2]
        );
        assert_eq!(
            twice(("map", "z_f=a"), r#"{"map": {"z_f": "b"}}"#),
            [true; 2]
        );
        let mut document = Map::new();
        for text in [
            r#"{"seed": 1, "seed": 1}"#,
            r#"{"map": {"z_f": "a", "z_f": "a"}}"#,
        ] {
            let fault = Options::add_document(&mut document, text).unwrap_err();
            assert!(fault.to_string().contains("is given twice"), "{fault}");
        }
        assert!(document.is_empty());
    }

    #[test]
    fn faults_are_named() {
        let message = |pairs: &[(&str, &str)]| parse(pairs).unwrap_err().to_string();
        let unknown = message(&[("sead", "7")]);
        for word in ["`sead`", "seed", "rate_hz", "map", "held_out"] {
            assert!(unknown.contains(word), "{unknown}");
        }
        let twice = message(&[("map", "z_f=V1"), ("map", "z_f=V2")]);
        assert!(twice.contains("'V1' and as 'V2'"), "{twice}");
        assert!(parse(&[("map", "z_f=V1"), ("map", "z_f=V1")]).is_ok());
        assert!(message(&[("seed", "x")]).contains("\"x\""));
        let said = message(&[("seed", "1"), ("trials", "2"), ("seed", "1")]);
        assert_eq!(said, "seed: given twice, expected once");
        assert!(message(&[("rows", "7")]).contains("FROM:TO"));
        assert!(message(&[("map", "z_f")]).contains("CHANNEL=COLUMN"));
        for text in ["7", "low:high", "1:inf", ":"] {
            assert!(message(&[("band_hz", text)]).contains("LOW:HIGH"), "{text}");
        }
        for text in ["0.5:40", " 0.5 : 40", "[0.5, 40]", "0,5:40,0"] {
            let band = parse(&[("band_hz", text.trim())]).unwrap().reading.band_hz;
            assert_eq!(band, Some((0.5, 40.0)));
        }
        let huge = parse(&[("particles", "1000000000")]).unwrap();
        assert!(
            huge.validate()
                .unwrap_err()
                .to_string()
                .contains("1000000000")
        );
    }
}
