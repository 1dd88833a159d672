//! What the API's document says of facts beyond what their type shows: the bounds of those that have a name, and what names
//! further numbers may have.

use utoipa::Number;
use utoipa::openapi::schema::{Object, ObjectBuilder, Schema, SchemaType, Type};
use utoipa::openapi::{OpenApi, RefOr};

use super::known::{NAME, NUMBERS, TEXTS};

pub fn bounded(document: &mut OpenApi) {
    let components = document.components.get_or_insert_default();
    let Some(RefOr::T(Schema::Object(facts))) = components.schemas.get_mut("Facts") else {
        return;
    };
    for (name, _, least, most, _) in NUMBERS {
        of_fact(facts, name, |fact| {
            fact.minimum = Some(Number::Float(least));
            fact.maximum = Some(Number::Float(most));
        });
    }
    for (name, most, _) in TEXTS {
        of_fact(facts, name, |fact| fact.max_length = Some(most));
    }
    let name = ObjectBuilder::new()
        .schema_type(Type::String)
        .pattern(Some(format!("^[a-z][a-z0-9_]{{0,{}}}$", NAME - 1)))
        .build();
    facts.property_names = Some(Box::new(name.into()));
    // A patch takes a number away by null.
    let number = SchemaType::from_iter([Type::Number, Type::Null]);
    let number = Schema::from(ObjectBuilder::new().schema_type(number).build());
    facts.additional_properties = Some(Box::new(RefOr::T(number).into()));
}

fn of_fact(facts: &mut Object, name: &str, describe: impl FnOnce(&mut Object)) {
    if let Some(RefOr::T(Schema::Object(fact))) = facts.properties.get_mut(name) {
        describe(fact);
    }
}
