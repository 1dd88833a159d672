//! JSON whose objects hold each key once. serde_json keeps the last of several and says nothing.

use std::fmt;

use serde::de::{Deserialize, Deserializer, Error, MapAccess, SeqAccess, Visitor};
use serde_json::{Map, Value};

/// Most of a name that an error repeats (characters).
const SHOWN: usize = 40;

/// A value in which no object has a key twice.
pub struct Unique(pub Value);

/// A name that users gave, short and without what a terminal would obey.
pub fn shown(name: &str) -> String {
    name.chars()
        .take(SHOWN)
        .flat_map(char::escape_debug)
        .collect()
}

impl<'de> Deserialize<'de> for Unique {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Values).map(Unique)
    }
}

struct Values;

impl<'de> Visitor<'de> for Values {
    type Value = Value;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("JSON")
    }

    fn visit_unit<E>(self) -> Result<Value, E> {
        Ok(Value::Null)
    }

    fn visit_bool<E>(self, value: bool) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_i64<E>(self, value: i64) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_u64<E>(self, value: u64) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_f64<E>(self, value: f64) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_str<E>(self, value: &str) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Value, A::Error> {
        let mut array = Vec::new();
        while let Some(Unique(item)) = items.next_element()? {
            array.push(item);
        }
        Ok(array.into())
    }

    fn visit_map<A: MapAccess<'de>>(self, mut entries: A) -> Result<Value, A::Error> {
        let mut object = Map::new();
        while let Some((key, Unique(value))) = entries.next_entry::<String, _>()? {
            if object.contains_key(&key) {
                return Err(Error::custom(format!("`{}` is given twice", shown(&key))));
            }
            object.insert(key, value);
        }
        Ok(object.into())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn any_text_reads_as_it_does_without(text in r#"[\[\]{}:,"a-c0-9.eE\-]{0,40}|\PC{0,40}"#) {
            let plain: Option<Value> = serde_json::from_str(&text).ok();
            let unique: Option<Value> = serde_json::from_str::<Unique>(&text).ok().map(|u| u.0);
            prop_assert!(unique.is_none() || unique == plain);
        }
    }

    #[test]
    fn a_key_comes_once_at_every_depth() {
        let text = r#"{"a": [1, -2, 0.5, "x", null, true, {"b": {"c": 1}, "d": {"c": 2}}]}"#;
        let value: Unique = serde_json::from_str(text).unwrap();
        assert_eq!(value.0, serde_json::from_str::<Value>(text).unwrap());
        for twice in [
            r#"{"c": 1, "c": 1}"#,
            r#"{"a": {"c": 1, "b": 2, "c": 3}}"#,
            r#"[{"c": 1, "\u0063": 2}]"#,
        ] {
            let error = serde_json::from_str::<Unique>(twice).err().unwrap();
            assert!(error.to_string().contains("`c` is given twice"), "{error}");
        }
    }
}
