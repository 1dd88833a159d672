//! The bicycle: masses, geometry and the parameters that the models need.

mod axle;
mod error;
mod limit_error;
pub mod limits;
pub mod load;

use std::collections::BTreeMap;

use serde::de::IgnoredAny;
use serde::{Deserialize, Serialize};

use crate::document::{json, unseen};

pub use axle::{Axle, PerAxle};
pub use error::BikeError;
use error::{LARGEST_FILE, LONGEST_NAME};
pub use limit_error::LimitError;

/// Standard gravity (m/s^2).
pub const GRAVITY: f64 = 9.80665;

/// The bike file. Masses are those carried by each wheel; lengths are horizontal distances from the centre of gravity. Keys may
/// be absent or null unless something needs them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
#[serde(default)]
pub struct Bike {
    /// Name of the bicycle in the fleet.
    pub bike: String,
    /// What it is, where that matters: a bench may have numbers that no bicycle has.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kind: Option<Kind>,
    /// Mass carried by the front wheel (kg); null: estimated where a force channel allows.
    pub mass_front_kg: Option<f64>,
    /// Mass carried by the rear wheel (kg).
    pub mass_rear_kg: Option<f64>,
    /// Standard deviation of the front mass (kg), where known; included in the intervals of k and B.
    pub mass_front_std_kg: Option<f64>,
    /// Standard deviation of the rear mass (kg), where known.
    pub mass_rear_std_kg: Option<f64>,
    /// Distance from the centre of gravity to the front wheel centre (m).
    pub l_front_m: Option<f64>,
    /// Distance from the centre of gravity to the rear wheel centre (m).
    pub l_rear_m: Option<f64>,
    /// Radius of the front wheel (m).
    pub wheel_radius_front_m: Option<f64>,
    /// Radius of the rear wheel (m).
    pub wheel_radius_rear_m: Option<f64>,
    /// Static load of the front wheel (N); from the mass when absent.
    pub static_load_front_n: Option<f64>,
    /// Static load of the rear wheel (N).
    pub static_load_rear_n: Option<f64>,
    /// Standard deviation of the displacement channels' noise (m), where known.
    pub noise_displacement_m: Option<f64>,
    /// Standard deviation of the road channels' noise (m), where known.
    pub noise_road_m: Option<f64>,
    /// One k and one B for both axles, as in the paper's figure 6.
    pub equal_axles: bool,
    /// Stiffness k (N/m) and damping B (N s/m) that no fit moves, by axle and quantity: `{"f.k": 60000}`.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub fix: BTreeMap<String, f64>,
    /// Lower and upper bounds of k (N/m) and B (N s/m): `{"r.B": [0, 2000]}`.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub bound: BTreeMap<String, [f64; 2]>,
    /// Parameters for the roll equations, paper eqs. (3) to (9).
    pub roll: Option<RollParameters>,
}

/// What a bike file describes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema), schema(as = BikeKind))]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Somebody rides it.
    Bicycle,
    /// A test bench.
    Bench,
}

/// Parameters of the roll equations, paper eqs. (4) to (9).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct RollParameters {
    /// m_F: mass of the front part (fork, handlebar, front wheel) (kg).
    pub front_part_mass_kg: f64,
    /// m_R: mass of the rear part (frame, rider, rear wheel) (kg).
    pub rear_part_mass_kg: f64,
    /// j: height of the front part's centre of gravity (m).
    pub front_part_height_m: f64,
    /// h: height of the rear part's centre of gravity (m).
    pub rear_part_height_m: f64,
    /// e: distance from the front part's centre of gravity to the steering axis (m).
    pub steering_axis_offset_m: f64,
    /// eta: trail (m).
    pub trail_m: f64,
    /// eps: caster angle (rad).
    pub caster_angle_rad: f64,
    /// k_x: longitudinal distance between the two parts' centres of gravity (m).
    pub longitudinal_distance_m: f64,
    /// I_yRF: spin inertia of the front wheel (kg m^2).
    pub wheel_inertia_front_kg_m2: f64,
    /// I_yRR: spin inertia of the rear wheel (kg m^2).
    pub wheel_inertia_rear_kg_m2: f64,
    /// I_xF: roll inertia of the front part (kg m^2).
    pub front_roll_inertia_kg_m2: f64,
    /// I_zF: yaw inertia of the front part (kg m^2).
    pub front_yaw_inertia_kg_m2: f64,
    /// I_xR: roll inertia of the rear part (kg m^2).
    pub rear_roll_inertia_kg_m2: f64,
    /// C_xz: product of inertia of the rear part (kg m^2).
    pub rear_product_inertia_kg_m2: f64,
}

/// What may stand in a bike file: a hundredth of the lightest wheel's share to a loaded cargo trike, with room for
/// test rigs; grams and millimetres are beyond.
const MASS_KG: [f64; 2] = [0.1, 1000.0];
/// Part of a mass that its standard deviation may be: beyond it nothing is known.
const MOST_UNSURE: f64 = 0.5;
const LENGTH_M: [f64; 2] = [0.01, 5.0];
const RADIUS_M: [f64; 2] = [0.02, 2.0];
const LOAD_N: [f64; 2] = [1.0, 10_000.0];
const NOISE_M: [f64; 2] = [0.0, 1.0];
/// Signed lengths, inertias and products of inertia of the roll equations.
const OFFSET_M: [f64; 2] = [-5.0, 5.0];
const INERTIA_KG_M2: [f64; 2] = [0.0, 1000.0];
const PRODUCT_KG_M2: [f64; 2] = [-1000.0, 1000.0];
const CASTER_RAD: [f64; 2] = [-1.5, 1.5];

fn within(key: &str, value: f64, [low, high]: [f64; 2]) -> Result<(), BikeError> {
    if (low..=high).contains(&value) {
        return Ok(());
    }
    Err(BikeError::OutOfRange {
        key: key.to_owned(),
        value,
        low,
        high,
    })
}

/// Unknown keys that a message names at most.
const MOST_NAMED: usize = 5;

/// A name that can stand in an address and on a page as what it is: no step in a path, nothing unseen, and nothing
/// that turns the direction of the text around it.
fn check_name(name: &str) -> Result<(), BikeError> {
    if name.len() > LONGEST_NAME {
        let bytes = name.len();
        return Err(BikeError::NameTooLong { bytes });
    }
    if matches!(name.trim(), "." | "..") {
        let name = name.trim().to_owned();
        return Err(BikeError::NameIsStep { name });
    }
    match unseen(name).next() {
        Some(character) => Err(BikeError::NameUnseen { character }),
        None => Ok(()),
    }
}

/// At most 40 characters of a text from a file, for messages.
fn shown(text: &str) -> String {
    text.chars().take(40).flat_map(char::escape_debug).collect()
}

fn keys_of(document: &serde_json::Value) -> Vec<String> {
    let keys = document.as_object().into_iter().flat_map(|map| map.keys());
    keys.cloned().collect()
}

impl RollParameters {
    fn validate(&self) -> Result<(), BikeError> {
        let values = [
            ("front_part_mass_kg", self.front_part_mass_kg, MASS_KG),
            ("rear_part_mass_kg", self.rear_part_mass_kg, MASS_KG),
            ("front_part_height_m", self.front_part_height_m, LENGTH_M),
            ("rear_part_height_m", self.rear_part_height_m, LENGTH_M),
            (
                "steering_axis_offset_m",
                self.steering_axis_offset_m,
                OFFSET_M,
            ),
            ("trail_m", self.trail_m, OFFSET_M),
            ("caster_angle_rad", self.caster_angle_rad, CASTER_RAD),
            (
                "longitudinal_distance_m",
                self.longitudinal_distance_m,
                OFFSET_M,
            ),
            (
                "wheel_inertia_front_kg_m2",
                self.wheel_inertia_front_kg_m2,
                INERTIA_KG_M2,
            ),
            (
                "wheel_inertia_rear_kg_m2",
                self.wheel_inertia_rear_kg_m2,
                INERTIA_KG_M2,
            ),
            (
                "front_roll_inertia_kg_m2",
                self.front_roll_inertia_kg_m2,
                INERTIA_KG_M2,
            ),
            (
                "front_yaw_inertia_kg_m2",
                self.front_yaw_inertia_kg_m2,
                INERTIA_KG_M2,
            ),
            (
                "rear_roll_inertia_kg_m2",
                self.rear_roll_inertia_kg_m2,
                INERTIA_KG_M2,
            ),
            (
                "rear_product_inertia_kg_m2",
                self.rear_product_inertia_kg_m2,
                PRODUCT_KG_M2,
            ),
        ];
        for (key, value, range) in values {
            within(&format!("roll.{key}"), value, range)?;
        }
        Ok(())
    }
}

impl Bike {
    /// Reads the bike file; the message names the key that is wrong, or those that are not known.
    /// Deserialising by itself is for what was stored, perhaps by another version: it passes over such keys.
    ///
    /// # Errors
    /// No JSON, an unknown key, a value out of its range.
    ///
    /// ```
    /// use veloid_core::Bike;
    /// use veloid_core::bicycle::{Axle, BikeError};
    ///
    /// let bike = Bike::from_json(r#"{"bike": "city", "mass_front_kg": 23, "l_front_m": 0.8, "l_rear_m": 0.3}"#)?;
    /// assert_eq!((bike.mass(Axle::Front), bike.mass(Axle::Rear)), (Some(23.0), None));
    /// assert_eq!(bike.wheelbase(), Some(1.1));
    ///
    /// let light = Bike::from_json(r#"{"mass_front_kg": -23}"#);
    /// assert!(matches!(light, Err(BikeError::OutOfRange { value: -23.0, .. })));
    /// let misspelt = Bike::from_json(r#"{"front_mass_kg": 23}"#);
    /// assert!(matches!(misspelt, Err(BikeError::UnknownKeys { .. })));
    /// # Ok::<(), BikeError>(())
    /// ```
    pub fn from_json(text: &str) -> Result<Self, BikeError> {
        if text.len() > LARGEST_FILE {
            return Err(BikeError::TooLarge { bytes: text.len() });
        }
        let keys: BTreeMap<String, IgnoredAny> = json::from_text(text).map_err(BikeError::Json)?;
        let bike: Bike = json::from_text(text).map_err(BikeError::Json)?;
        let every_key = Self {
            kind: Some(Kind::Bicycle),
            fix: BTreeMap::from([(String::new(), 0.0)]),
            bound: BTreeMap::from([(String::new(), [0.0; 2])]),
            ..Self::default()
        };
        let own = serde_json::to_value(every_key);
        let known = keys_of(&own.map_err(|e| BikeError::Json(e.to_string()))?);
        let unknown: Vec<String> = (keys.keys().filter(|key| !known.contains(key)))
            .map(|key| format!("'{}'", shown(key)))
            .take(MOST_NAMED)
            .collect();
        if !unknown.is_empty() {
            return Err(BikeError::UnknownKeys { unknown, known });
        }
        bike.validate()?;
        Ok(bike)
    }

    /// Refuses what no bicycle, nor any test rig of a part of one, can be.
    pub fn validate(&self) -> Result<(), BikeError> {
        check_name(&self.bike)?;
        let values = [
            ("mass_front_kg", self.mass_front_kg, MASS_KG),
            ("mass_rear_kg", self.mass_rear_kg, MASS_KG),
            ("l_front_m", self.l_front_m, LENGTH_M),
            ("l_rear_m", self.l_rear_m, LENGTH_M),
            ("wheel_radius_front_m", self.wheel_radius_front_m, RADIUS_M),
            ("wheel_radius_rear_m", self.wheel_radius_rear_m, RADIUS_M),
            ("static_load_front_n", self.static_load_front_n, LOAD_N),
            ("static_load_rear_n", self.static_load_rear_n, LOAD_N),
            ("noise_displacement_m", self.noise_displacement_m, NOISE_M),
            ("noise_road_m", self.noise_road_m, NOISE_M),
        ];
        for (key, value, range) in values {
            value.map_or(Ok(()), |v| within(key, v, range))?;
        }
        for axle in Axle::BOTH {
            if let Some(std) = self.mass_std(axle) {
                let key = format!("mass_{axle}_std_kg");
                let mass = self
                    .mass(axle)
                    .ok_or_else(|| BikeError::DeviationOfNoMass {
                        key: key.clone(),
                        std,
                        axle,
                    })?;
                within(&key, std, [0.0, MOST_UNSURE * mass])?;
            }
        }
        self.check_limits()?;
        self.roll.as_ref().map_or(Ok(()), RollParameters::validate)
    }

    /// The mass on an axle (kg).
    pub fn mass(&self, axle: Axle) -> Option<f64> {
        match axle {
            Axle::Front => self.mass_front_kg,
            Axle::Rear => self.mass_rear_kg,
        }
    }

    /// The standard deviation of the mass on an axle (kg).
    pub fn mass_std(&self, axle: Axle) -> Option<f64> {
        match axle {
            Axle::Front => self.mass_front_std_kg,
            Axle::Rear => self.mass_rear_std_kg,
        }
    }

    /// The mass on an axle; unknown only where a measured force determines it.
    pub fn mass_or_force(&self, axle: Axle, has_force: bool) -> Result<Option<f64>, BikeError> {
        let mass = self.mass(axle);
        if mass.is_none() && !has_force {
            return Err(BikeError::NoMass { axle });
        }
        Ok(mass)
    }

    /// Radius of the wheel on an axle (m).
    pub fn wheel_radius(&self, axle: Axle) -> Option<f64> {
        match axle {
            Axle::Front => self.wheel_radius_front_m,
            Axle::Rear => self.wheel_radius_rear_m,
        }
    }

    /// Static wheel load F_cF, F_cR of paper eq. (2) (N): as weighed, else from the mass.
    pub fn static_load(&self, axle: Axle) -> Option<f64> {
        let weighed = match axle {
            Axle::Front => self.static_load_front_n,
            Axle::Rear => self.static_load_rear_n,
        };
        weighed.or(self.mass(axle).map(|m| m * GRAVITY))
    }

    /// Whether one k and one B stand for both axles: asked for, and both masses known.
    pub fn shares_axles(&self) -> bool {
        self.equal_axles && self.mass_front_kg.is_some() && self.mass_rear_kg.is_some()
    }

    /// l_F + l_R (m).
    pub fn wheelbase(&self) -> Option<f64> {
        Some(self.l_front_m? + self.l_rear_m?)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn a_file_without_end_is_refused() {
        let list = format!("{{\"a\": [0{}]}}", ",0".repeat(LARGEST_FILE));
        let refused = Bike::from_json(&list).unwrap_err().to_string();
        assert!(refused.contains("expected at most 65536"), "{refused}");
    }

    fn refused(file: &str) -> String {
        Bike::from_json(file).unwrap_err().to_string()
    }

    #[test]
    fn unknown_keys_are_refused_by_name_and_the_known_ones_listed() {
        let said =
            refused(r#"{"bike": "b", "mass_front_kg": 23, "wheelbase_m": 1.1, "Owner": {}}"#);
        assert!(
            said.contains("unknown key 'Owner', 'wheelbase_m', expected bike"),
            "{said}"
        );
        for known in ["l_front_m", "roll", "equal_axles", "noise_road_m"] {
            assert!(said.contains(known), "{said}");
        }
        let said = refused(r#"{"roll": {"front_part_mass": 5}}"#);
        assert!(
            said.contains("`front_part_mass`") && said.contains("`front_part_mass_kg`"),
            "{said}"
        );
        let many: Vec<String> = (0..500)
            .map(|i| format!("\"{}{i}\": 1", "\u{202e}x".repeat(50)))
            .collect();
        let said = refused(&format!("{{{}}}", many.join(",")));
        assert!(said.len() < 2000 && !said.contains('\u{202e}'), "{said}");
    }

    /// What another version stored has to be read, whatever keys it knew.
    #[test]
    fn stored_bikes_may_have_other_keys() {
        let stored: Bike = serde_json::from_str(r#"{"bike": "b", "owner": "x"}"#).unwrap();
        assert_eq!(stored.bike, "b");
    }

    #[test]
    fn what_no_bicycle_can_be_is_refused() {
        for (key, inside, outside) in [
            ("mass_front_kg", [0.1, 1000.0], [1e-300, 1000.1]),
            ("mass_rear_kg", [0.1, 1000.0], [0.0, 23_000.0]),
            ("l_front_m", [0.01, 5.0], [0.0, 808.0]),
            ("l_rear_m", [0.01, 5.0], [-0.3, 5.1]),
            ("wheel_radius_front_m", [0.02, 2.0], [1e-9, 340.0]),
            ("wheel_radius_rear_m", [0.02, 2.0], [0.0, 1e300]),
            ("static_load_front_n", [1.0, 1e4], [0.0, 1e5]),
            ("static_load_rear_n", [1.0, 1e4], [-1.0, 1e300]),
            ("noise_displacement_m", [0.0, 1.0], [-1e-9, 50.0]),
            ("noise_road_m", [0.0, 1.0], [-1.0, 1e300]),
        ] {
            for value in inside {
                assert!(
                    Bike::from_json(&format!("{{\"{key}\": {value}}}")).is_ok(),
                    "{key}: {value}"
                );
            }
            for value in outside {
                let said = refused(&format!("{{\"{key}\": {value}}}"));
                assert!(
                    said.contains(&format!("{key} is {value:?}, expected ")),
                    "{said}"
                );
            }
        }
    }

    #[test]
    fn names_that_are_not_what_they_look_like_are_refused() {
        for name in [
            "",
            "lab-7",
            "\u{421}\u{43b}\u{430}\u{432}\u{430} 3",
            "\u{645}\u{6cc}\u{200c}\u{62e}",
            "...",
            "a/b",
            "x.y",
        ] {
            assert!(check_name(name).is_ok(), "{name:?}");
        }
        for name in [
            ".",
            "..",
            " .. ",
            "a\u{202e}b",
            "a\nb",
            "\u{7f}",
            "\u{2066}a",
            "a\u{200b}",
            "\u{feff}a",
            "\u{2028}",
            "a\u{3164}",
            "a\u{fe0f}",
        ] {
            let file = serde_json::json!({ "bike": name }).to_string();
            let said = refused(&file);
            assert!(
                said.contains("bike: ") && crate::document::unseen(&said).next().is_none(),
                "{said:?}"
            );
        }
        let said = refused(&format!(
            "{{\"bike\": \"{}\"}}",
            "x".repeat(LONGEST_NAME + 1)
        ));
        assert!(said.contains("201 bytes"), "{said}");
    }

    /// What is taken is written, and read again, as the same.
    fn comes_back(text: &str) {
        if let Ok(bike) = Bike::from_json(text) {
            let written = serde_json::to_string(&bike).unwrap();
            assert_eq!(Bike::from_json(&written).unwrap(), bike, "{text}");
        }
    }

    proptest! {
        #[test]
        fn any_text_is_a_bike_or_a_fault(text in "\\PC{0,200}", json in "[\\[\\]{}:,\"a-z_0-9.eE+ -]{0,200}") {
            comes_back(&text);
            comes_back(&json);
        }

        #[test]
        fn any_numbers_make_a_bike_or_a_fault(
            keys in prop::collection::vec(prop::sample::select(vec![
                "mass_front_kg", "mass_rear_kg", "l_front_m", "wheel_radius_rear_m", "static_load_front_n",
                "noise_road_m", "equal_axles", "bike", "roll", "owner",
            ]), 0..6),
            values in prop::collection::vec(prop::sample::select(vec![
                "0", "-0.0", "23.5", "1e308", "1e-320", "1e999", "null", "true", "\"x\"", "[1, [2]]", "{\"a\": 1.5}",
            ]), 6),
        ) {
            let pairs: Vec<String> =
                keys.iter().zip(values).map(|(key, value)| format!("\"{key}\": {value}")).collect();
            comes_back(&format!("{{{}}}", pairs.join(", ")));
        }
    }
}
