//! JSON that people write: what is wrong with it, in words for people.

use serde::de::DeserializeOwned;
use serde_json::{Deserializer, Error, Value};

/// Reads a text.
///
/// # Errors
/// Where and what, as `mass_front_kg: expected a number, found the text "23"`.
pub fn from_text<T: DeserializeOwned>(text: &str) -> Result<T, String> {
    let mut reader = Deserializer::from_str(text);
    let read = serde_path_to_error::deserialize(&mut reader)
        .map_err(|error| said(&error.path().to_string(), error.inner()))?;
    reader.end().map_err(|error| said("", &error))?;
    Ok(read)
}

/// Reads a value.
///
/// # Errors
/// As [`from_text`].
pub fn from_value<T: DeserializeOwned>(value: Value) -> Result<T, String> {
    serde_path_to_error::deserialize(value)
        .map_err(|error| said(&error.path().to_string(), error.inner()))
}

fn said(path: &str, error: &Error) -> String {
    let text = error.to_string();
    if !error.is_data() {
        return format!("invalid JSON: {text}");
    }
    let text = text.split(" at line ").next().unwrap_or_default();
    let text = match text.split_once(", expected ") {
        Some((found, wanted)) => match found.split_once(": ") {
            Some((_, found)) => format!("expected {}, found {}", type_of(wanted), value_of(found)),
            None => text.to_owned(),
        },
        None => text.to_owned(),
    };
    match path {
        "." | "" | "?" => text,
        path => format!("{path}: {text}"),
    }
}

/// What Rust calls a type, as people do.
fn type_of(wanted: &str) -> &str {
    match wanted {
        "f64" | "f32" => "a number",
        "u64" | "usize" | "u32" | "i64" => "a whole number",
        "a string" => "text",
        "a boolean" => "true or false",
        "a sequence" => "a list",
        "a tuple of size 2" => "a list of two",
        _ if wanted.starts_with("struct ") || wanted == "a map" => "an object {...}",
        _ => wanted,
    }
}

/// What serde says of a value, as people do.
fn value_of(found: &str) -> String {
    let bare = |text: &str| text.trim_matches('`').to_owned();
    match found.split_once(' ') {
        Some(("string", text)) => format!("the text {text}"),
        Some(("integer" | "boolean", number)) => bare(number),
        Some(("floating", number)) => bare(number.trim_start_matches("point ")),
        _ => match found {
            "sequence" => "a list".to_owned(),
            "map" => "an object {...}".to_owned(),
            _ => found.to_owned(),
        },
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::collections::BTreeMap;

    use super::*;

    #[derive(Debug, serde::Deserialize)]
    #[serde(deny_unknown_fields)]
    #[expect(dead_code, reason = "only read")]
    struct Tyre {
        name: String,
        #[serde(default)]
        bars: [f64; 2],
        #[serde(default)]
        rim: Option<Rim>,
    }

    #[derive(Debug, serde::Deserialize)]
    #[expect(dead_code, reason = "only read")]
    struct Rim {
        holes: usize,
        tubeless: bool,
    }

    #[test]
    fn faults_are_reported_by_their_place_and_in_plain_words() {
        for (text, expected) in [
            (r#"{"name": 5}"#, "name: expected text, found 5"),
            (
                r#"{"name": "a", "bars": [1, "x"]}"#,
                r#"bars[1]: expected a number, found the text "x""#,
            ),
            (
                r#"{"name": "a", "bars": 2.5}"#,
                "bars: expected an array of length 2, found 2.5",
            ),
            (
                r#"{"name": "a", "rim": {"holes": -1, "tubeless": true}}"#,
                "rim.holes: expected a whole number, found -1",
            ),
            (
                r#"{"name": "a", "rim": {"holes": 1, "tubeless": "yes"}}"#,
                r#"rim.tubeless: expected true or false, found the text "yes""#,
            ),
            (
                r#"{"name": "a", "rim": 7}"#,
                "rim: expected an object {...}, found 7",
            ),
            (
                r#"{"nmae": "a"}"#,
                "nmae: unknown field `nmae`, expected one of `name`, `bars`, `rim`",
            ),
            (r#"{"rim": null}"#, "missing field `name`"),
        ] {
            assert_eq!(from_text::<Tyre>(text).unwrap_err(), expected);
        }
        let cut = from_text::<Tyre>(r#"{"name": "a""#).unwrap_err();
        assert!(cut.starts_with("invalid JSON: EOF"), "{cut}");
        let more = from_text::<Tyre>(r#"{"name": "a"} x"#).unwrap_err();
        assert!(more.starts_with("invalid JSON: trailing"), "{more}");
        let list = from_text::<BTreeMap<String, Value>>("[1]").unwrap_err();
        assert_eq!(list, "expected an object {...}, found a list");
    }
}
