//! What is known of a ride besides its file: when, where, by whom and on what it was ridden. Named facts have
//! units and bounds; any further number is kept under the name that it is given.

mod document;
mod error;
mod known;
mod lines;
mod of_file;

pub use document::bounded;
pub use error::FactsError;
pub use known::{MOMENT, NUMBERS, TEXTS, is_name};
pub use lines::{from_form, from_json, names};
pub use of_file::of_file;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use utoipa::ToSchema;

/// What is known of a ride besides its file; null where nothing is. Any further number may stand beside these.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(default)]
pub struct Facts {
    /// Day (2026-05-01) or time (RFC 3339) of the ride.
    pub ridden_at: Option<String>,
    pub pressure_front_bar: Option<f64>,
    pub pressure_rear_bar: Option<f64>,
    /// Of the air (degC).
    pub temperature_c: Option<f64>,
    pub rider: Option<String>,
    pub rider_mass_kg: Option<f64>,
    pub tyres: Option<String>,
    pub road: Option<String>,
    /// A patch may take them away by null.
    #[schema(value_type = Option<Vec<String>>)]
    pub tags: Vec<String>,
    pub notes: Option<String>,
    #[serde(flatten)]
    pub more: BTreeMap<String, f64>,
}

impl TryFrom<Map<String, Value>> for Facts {
    type Error = FactsError;

    /// Reads a document; what is null is not known.
    fn try_from(document: Map<String, Value>) -> Result<Self, FactsError> {
        let mut facts = Self::default();
        for (key, value) in document {
            facts.set(&key, value)?;
        }
        known::few("further numbers", facts.more.len())?;
        Ok(facts)
    }
}

impl Facts {
    /// As a document without what is not known.
    pub fn document(&self) -> Map<String, Value> {
        let Ok(Value::Object(mut document)) = serde_json::to_value(self) else {
            return Map::new();
        };
        document
            .retain(|_, value| !value.is_null() && value.as_array().is_none_or(|a| !a.is_empty()));
        document
    }

    /// Changes what a merge patch (RFC 7396) names: null takes a fact away.
    pub fn patched(&self, patch: Map<String, Value>) -> Result<Self, FactsError> {
        let mut document = self.document();
        document.extend(patch);
        Self::try_from(document)
    }

    /// Time of the ride (epoch ms), the beginning of its day (UTC) where only that is known.
    pub fn ridden_ms(&self) -> Option<i64> {
        self.ridden_at.as_deref().and_then(known::moment)
    }

    /// A number that has a name here.
    pub fn value(&self, key: &str) -> Option<f64> {
        match key {
            "pressure_front_bar" => self.pressure_front_bar,
            "pressure_rear_bar" => self.pressure_rear_bar,
            "temperature_c" => self.temperature_c,
            "rider_mass_kg" => self.rider_mass_kg,
            _ => None,
        }
    }

    pub fn number(&mut self, key: &str) -> Option<&mut Option<f64>> {
        Some(match key {
            "pressure_front_bar" => &mut self.pressure_front_bar,
            "pressure_rear_bar" => &mut self.pressure_rear_bar,
            "temperature_c" => &mut self.temperature_c,
            "rider_mass_kg" => &mut self.rider_mass_kg,
            _ => return None,
        })
    }

    pub fn text(&mut self, key: &str) -> Option<&mut Option<String>> {
        Some(match key {
            "ridden_at" => &mut self.ridden_at,
            "rider" => &mut self.rider,
            "tyres" => &mut self.tyres,
            "road" => &mut self.road,
            "notes" => &mut self.notes,
            _ => return None,
        })
    }

    /// Facts in words that rides can be grouped by.
    pub fn groups(&self) -> impl Iterator<Item = (&'static str, &str)> {
        let known = [
            ("rider", &self.rider),
            ("tyres", &self.tyres),
            ("road", &self.road),
        ];
        let named = known.into_iter();
        named.filter_map(|(name, text)| Some((name, text.as_deref()?)))
    }

    fn set(&mut self, key: &str, value: Value) -> Result<(), FactsError> {
        if key == "tags" {
            self.tags = known::tags(value)?;
        } else if let Some(place) = self.number(key) {
            *place = known::number(key, value)?;
        } else if let Some(place) = self.text(key) {
            *place = known::text(key, value)?;
        } else if let Some(number) = known::further(key, value)? {
            self.more.insert(key.to_owned(), number);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
