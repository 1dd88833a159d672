//! The one gate through which the result of every stage passes: JSON would write a number that is none as null, and
//! nothing would read it back. What may be unknown is an `Option`; what is left is a mistake of ours, and is said to
//! be one, with its place, before it is stored.

use serde::Serialize;
use serde::ser::{
    self, SerializeMap, SerializeSeq, SerializeStruct, SerializeStructVariant, SerializeTuple,
    SerializeTupleStruct, SerializeTupleVariant,
};

/// A result holds a number that is none.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{stage}: {place} is not a finite number")]
pub struct NotFinite {
    /// Whose result it is.
    pub stage: &'static str,
    /// Way to the number, with points between the keys.
    pub place: String,
}

/// The result itself, if all its numbers are finite.
///
/// # Errors
/// The place of the first number that is none.
pub fn checked<T: Serialize, E: From<NotFinite>>(stage: &'static str, result: T) -> Result<T, E> {
    match result.serialize(Gate) {
        Ok(()) => Ok(result),
        Err(Found(path)) => Err(E::from(NotFinite {
            stage,
            place: path.into_iter().rev().collect::<Vec<_>>().join("."),
        })),
    }
}

/// Way to the number that is none, innermost first.
#[derive(Debug)]
struct Found(Vec<String>);

impl Found {
    fn at(mut self, step: impl ToString) -> Self {
        self.0.push(step.to_string());
        self
    }
}

impl std::fmt::Display for Found {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:?}", self.0)
    }
}

impl std::error::Error for Found {}

impl ser::Error for Found {
    fn custom<T: std::fmt::Display>(message: T) -> Self {
        Found(vec![message.to_string()])
    }
}

/// Writes nothing; stops at the first number that is not finite.
struct Gate;

/// Inside of a sequence, a map or a structure.
struct Inside {
    index: usize,
    key: String,
}

impl Inside {
    fn new() -> Result<Self, Found> {
        Ok(Self {
            index: 0,
            key: String::new(),
        })
    }

    fn element<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), Found> {
        self.index += 1;
        value
            .serialize(Gate)
            .map_err(|found| found.at(self.index - 1))
    }
}

macro_rules! pass {
    ($($name:ident: $kind:ty),*) => {
        $(fn $name(self, _: $kind) -> Result<(), Found> {
            Ok(())
        })*
    };
}

impl ser::Serializer for Gate {
    type Ok = ();
    type Error = Found;
    type SerializeSeq = Inside;
    type SerializeTuple = Inside;
    type SerializeTupleStruct = Inside;
    type SerializeTupleVariant = Inside;
    type SerializeMap = Inside;
    type SerializeStruct = Inside;
    type SerializeStructVariant = Inside;

    pass!(serialize_bool: bool, serialize_i8: i8, serialize_i16: i16, serialize_i32: i32, serialize_i64: i64,
        serialize_u8: u8, serialize_u16: u16, serialize_u32: u32, serialize_u64: u64, serialize_char: char,
        serialize_str: &str, serialize_bytes: &[u8], serialize_unit_struct: &'static str);

    fn serialize_f32(self, x: f32) -> Result<(), Found> {
        self.serialize_f64(x.into())
    }

    fn serialize_f64(self, x: f64) -> Result<(), Found> {
        match x.is_finite() {
            true => Ok(()),
            false => Err(Found(Vec::new())),
        }
    }

    fn serialize_none(self) -> Result<(), Found> {
        Ok(())
    }

    fn serialize_some<T: Serialize + ?Sized>(self, value: &T) -> Result<(), Found> {
        value.serialize(self)
    }

    fn serialize_unit(self) -> Result<(), Found> {
        Ok(())
    }

    fn serialize_unit_variant(self, _: &'static str, _: u32, _: &'static str) -> Result<(), Found> {
        Ok(())
    }

    fn serialize_newtype_struct<T: Serialize + ?Sized>(
        self,
        _: &'static str,
        value: &T,
    ) -> Result<(), Found> {
        value.serialize(self)
    }

    fn serialize_newtype_variant<T: Serialize + ?Sized>(
        self,
        _: &'static str,
        _: u32,
        variant: &'static str,
        value: &T,
    ) -> Result<(), Found> {
        value.serialize(self).map_err(|found| found.at(variant))
    }

    fn serialize_seq(self, _: Option<usize>) -> Result<Inside, Found> {
        Inside::new()
    }

    fn serialize_tuple(self, _: usize) -> Result<Inside, Found> {
        Inside::new()
    }

    fn serialize_tuple_struct(self, _: &'static str, _: usize) -> Result<Inside, Found> {
        Inside::new()
    }

    fn serialize_tuple_variant(
        self,
        _: &'static str,
        _: u32,
        _: &'static str,
        _: usize,
    ) -> Result<Inside, Found> {
        Inside::new()
    }

    fn serialize_map(self, _: Option<usize>) -> Result<Inside, Found> {
        Inside::new()
    }

    fn serialize_struct(self, _: &'static str, _: usize) -> Result<Inside, Found> {
        Inside::new()
    }

    fn serialize_struct_variant(
        self,
        _: &'static str,
        _: u32,
        _: &'static str,
        _: usize,
    ) -> Result<Inside, Found> {
        Inside::new()
    }
}

macro_rules! elements {
    ($($kind:ident $name:ident),*) => {
        $(impl $kind for Inside {
            type Ok = ();
            type Error = Found;

            fn $name<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), Found> {
                self.element(value)
            }

            fn end(self) -> Result<(), Found> {
                Ok(())
            }
        })*
    };
}

elements!(SerializeSeq serialize_element, SerializeTuple serialize_element,
    SerializeTupleStruct serialize_field, SerializeTupleVariant serialize_field);

macro_rules! fields {
    ($($kind:ident),*) => {
        $(impl $kind for Inside {
            type Ok = ();
            type Error = Found;

            fn serialize_field<T: Serialize + ?Sized>(
                &mut self,
                name: &'static str,
                value: &T,
            ) -> Result<(), Found> {
                value.serialize(Gate).map_err(|found| found.at(name))
            }

            fn end(self) -> Result<(), Found> {
                Ok(())
            }
        })*
    };
}

fields!(SerializeStruct, SerializeStructVariant);

impl SerializeMap for Inside {
    type Ok = ();
    type Error = Found;

    fn serialize_key<T: Serialize + ?Sized>(&mut self, key: &T) -> Result<(), Found> {
        self.key = match serde_json::to_value(key) {
            Ok(serde_json::Value::String(name)) => name,
            other => format!("{other:?}"),
        };
        Ok(())
    }

    fn serialize_value<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), Found> {
        value.serialize(Gate).map_err(|found| found.at(&self.key))
    }

    fn end(self) -> Result<(), Found> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::bicycle::PerAxle;

    fn place<T: Serialize>(result: T) -> Option<String> {
        match checked("observe", result) {
            Err(NotFinite { place, .. }) => Some(place),
            _ => None,
        }
    }

    #[test]
    fn a_number_that_is_none_is_named_by_its_place() {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let axles = PerAxle {
                front: None,
                rear: Some(vec![Some((1, 0.5)), None, Some((2, bad))]),
            };
            assert_eq!(place(axles), Some("rear.2.1".to_owned()));
            let named = BTreeMap::from([("gain".to_owned(), bad)]);
            assert_eq!(place(&[named]), Some("0.gain".to_owned()));
        }
        assert_eq!(place(vec![Some(f64::MAX), None, Some(-0.0)]), None);
        assert_eq!(place(f32::NAN), Some(String::new()));
    }
}
