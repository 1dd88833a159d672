//! A base model as rides hold it: by name in documents.

use std::ops::Deref;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::{Axle, Plant, by_id};

/// A base model; an axle unless something else is said.
#[derive(Clone, Copy, Debug)]
pub struct PlantRef(pub &'static dyn Plant);

impl Default for PlantRef {
    fn default() -> Self {
        Self(&Axle::MOVING)
    }
}

impl PartialEq for PlantRef {
    fn eq(&self, other: &Self) -> bool {
        self.id() == other.id()
    }
}

impl Deref for PlantRef {
    type Target = dyn Plant;

    fn deref(&self) -> &Self::Target {
        self.0
    }
}

impl Serialize for PlantRef {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.id())
    }
}

impl<'de> Deserialize<'de> for PlantRef {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let id = String::deserialize(deserializer)?;
        let unknown = || serde::de::Error::custom(format!("'{id}' is not a base model"));
        by_id(&id).map(Self).ok_or_else(unknown)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::plant::Damper;

    #[test]
    fn a_document_holds_the_name() {
        let damper = PlantRef(&Damper::MOVING);
        let text = serde_json::to_string(&damper).unwrap();
        assert_eq!(text, "\"damper\"");
        assert_eq!(serde_json::from_str::<PlantRef>(&text).unwrap(), damper);
        let error = serde_json::from_str::<PlantRef>("\"unicycle\"").unwrap_err();
        assert!(error.to_string().contains("'unicycle' is not a base model"));
    }
}
