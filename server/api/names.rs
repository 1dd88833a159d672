//! The names that lists can be filtered by. One that no list knows would give an empty answer, which
//! reads as if there were nothing.

use std::sync::LazyLock;

use utoipa::openapi::RefOr;
use utoipa::openapi::schema::{ArrayBuilder, ObjectBuilder, Schema, Type};
use veloid_engine::diagnosis::effects::Kind;
use veloid_engine::report::diagnosis::Verdict;

use super::problem::{self, Problem};
use crate::store::parameter::{AXLES, METHODS};
use crate::unique::shown;
use crate::webhooks::Event;

/// Effects that may be named.
pub static EFFECTS: LazyLock<Vec<&'static str>> =
    LazyLock::new(|| Kind::named().map(Kind::id).collect());

/// Parameters of bicycles and of effects.
pub static PARAMETERS: LazyLock<Vec<String>> = LazyLock::new(|| {
    let plain = ["k_n_m", "b_n_s_m", "mass_kg"].map(str::to_owned);
    let of_effects = Kind::named().flat_map(|kind| {
        let names = kind.reported().into_iter();
        names.map(move |name| format!("{}.{name}", kind.id()))
    });
    plain.into_iter().chain(of_effects).collect()
});

/// Refuses what is not known, naming what is.
pub fn one_of(name: &str, asked: Option<&str>, known: &[impl AsRef<str>]) -> Result<(), Problem> {
    match asked {
        Some(text) if known.iter().all(|known| known.as_ref() != text) => {
            let known: Vec<&str> = known.iter().map(AsRef::as_ref).collect();
            let detail = format!(
                "{name}: '{}', expected one of {}",
                shown(text),
                known.join(", ")
            );
            Err(Problem::new(problem::Kind::BadRequest, detail))
        }
        _ => Ok(()),
    }
}

fn any_of<T: AsRef<str>>(known: &[T]) -> Schema {
    let object = ObjectBuilder::new().schema_type(Type::String);
    let known = known.iter().map(|name| name.as_ref().to_owned());
    object.enum_values(Some(known)).build().into()
}

pub fn methods() -> Schema {
    any_of(&METHODS)
}

pub fn axles() -> Schema {
    any_of(&AXLES)
}

pub fn events() -> Schema {
    let events = any_of(&Event::names());
    ArrayBuilder::new().items(RefOr::T(events)).build().into()
}

pub fn verdicts() -> Schema {
    any_of(&Verdict::NAMES)
}

pub fn effects() -> Schema {
    any_of(&EFFECTS)
}

pub fn parameters() -> Schema {
    any_of(&PARAMETERS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_that_is_stored_is_known() {
        for verdict in Verdict::NAMES {
            let name = serde_json::Value::from(verdict);
            assert!(serde_json::from_value::<Verdict>(name).is_ok(), "{verdict}");
        }
        for name in ["k_n_m", "coulomb_friction.friction", "sensor_delay.delay"] {
            assert!(one_of("name", Some(name), &PARAMETERS).is_ok(), "{name}");
        }
        assert!(EFFECTS.len() > 20 && PARAMETERS.len() > EFFECTS.len());
    }

    #[test]
    fn strangers_are_refused_with_what_is_known() {
        let fault = one_of("axle", Some("left\u{202e}"), &AXLES).err();
        assert_eq!(
            fault.map(|problem| problem.detail).as_deref(),
            Some("axle: 'left\\u{202e}', expected one of front, rear, both")
        );
        assert!(one_of("axle", None, &AXLES).is_ok());
    }
}
