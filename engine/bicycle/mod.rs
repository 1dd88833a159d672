//! The bicycle: masses, geometry and the parameters that the models need.

pub mod load;
pub mod roll;

use std::collections::BTreeMap;
use std::fmt;

use serde::{Deserialize, Serialize};

use crate::EngineError;

/// Standard gravity (m/s^2).
pub const GRAVITY: f64 = 9.80665;

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum Axle {
    Front,
    Rear,
}

impl Axle {
    pub const BOTH: [Axle; 2] = [Axle::Front, Axle::Rear];

    pub fn name(self) -> &'static str {
        match self {
            Axle::Front => "front",
            Axle::Rear => "rear",
        }
    }
}

impl fmt::Display for Axle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// One value for each axle that the ride recorded.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct PerAxle<T> {
    #[cfg_attr(feature = "openapi", schema(schema_with = nullable::<T>))]
    pub front: Option<T>,
    #[cfg_attr(feature = "openapi", schema(schema_with = nullable::<T>))]
    pub rear: Option<T>,
}

/// The derived schema of a generic `Option` forgets that it may be null.
#[cfg(feature = "openapi")]
fn nullable<T: utoipa::ToSchema>() -> utoipa::openapi::Schema {
    use utoipa::openapi::schema::{ObjectBuilder, OneOfBuilder, Type};
    let null = ObjectBuilder::new().schema_type(Type::Null);
    OneOfBuilder::new().item(T::schema()).item(null).into()
}

impl<T> Default for PerAxle<T> {
    fn default() -> Self {
        Self {
            front: None,
            rear: None,
        }
    }
}

impl<T> PerAxle<T> {
    pub fn get(&self, axle: Axle) -> Option<&T> {
        match axle {
            Axle::Front => self.front.as_ref(),
            Axle::Rear => self.rear.as_ref(),
        }
    }

    pub fn get_mut(&mut self, axle: Axle) -> Option<&mut T> {
        match axle {
            Axle::Front => self.front.as_mut(),
            Axle::Rear => self.rear.as_mut(),
        }
    }

    pub fn set(&mut self, axle: Axle, value: T) {
        match axle {
            Axle::Front => self.front = Some(value),
            Axle::Rear => self.rear = Some(value),
        }
    }

    /// The axles present, front first.
    pub fn iter(&self) -> impl Iterator<Item = (Axle, &T)> {
        Axle::BOTH
            .into_iter()
            .filter_map(|a| self.get(a).map(|v| (a, v)))
    }

    pub fn map<'a, U>(&'a self, mut f: impl FnMut(Axle, &'a T) -> U) -> PerAxle<U> {
        PerAxle {
            front: self.front.as_ref().map(|v| f(Axle::Front, v)),
            rear: self.rear.as_ref().map(|v| f(Axle::Rear, v)),
        }
    }

    pub fn try_map<'a, U, E>(
        &'a self,
        mut f: impl FnMut(Axle, &'a T) -> Result<U, E>,
    ) -> Result<PerAxle<U>, E> {
        Ok(PerAxle {
            front: self.front.as_ref().map(|v| f(Axle::Front, v)).transpose()?,
            rear: self.rear.as_ref().map(|v| f(Axle::Rear, v)).transpose()?,
        })
    }
}

/// Largest bike file (bytes).
const LARGEST_FILE: usize = 64 << 10;

/// The bike file. Masses are those carried by each wheel; lengths are horizontal distances from the
/// centre of gravity. Keys that are absent or null are only missed where something needs them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
#[serde(default)]
pub struct Bike {
    /// Name of the bicycle in the fleet.
    pub bike: String,
    /// Mass carried by the front wheel (kg); null: estimated where a force channel allows.
    pub mass_front_kg: Option<f64>,
    pub mass_rear_kg: Option<f64>,
    /// Distance from the centre of gravity to the wheel centre (m).
    pub l_front_m: Option<f64>,
    pub l_rear_m: Option<f64>,
    pub wheel_radius_front_m: Option<f64>,
    pub wheel_radius_rear_m: Option<f64>,
    /// Static wheel load (N); from the mass when absent.
    pub static_load_front_n: Option<f64>,
    pub static_load_rear_n: Option<f64>,
    /// Standard deviation of the displacement channels' noise (m), where known.
    pub noise_displacement_m: Option<f64>,
    /// Standard deviation of the road channels' noise (m), where known.
    pub noise_road_m: Option<f64>,
    /// One k and one B for both axles, as in the paper's figure 6.
    pub equal_axles: bool,
    /// What the roll equations, paper eqs. (3) to (9), need.
    pub roll: Option<RollParameters>,
    /// Keys that veloid does not know; reported as ignored.
    #[serde(flatten)]
    #[cfg_attr(feature = "openapi", schema(ignore))]
    pub unknown: BTreeMap<String, serde_json::Value>,
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
    /// j, h: heights of the front and rear part's centre of gravity (m).
    pub front_part_height_m: f64,
    pub rear_part_height_m: f64,
    /// e: distance from the front part's centre of gravity to the steering axis (m).
    pub steering_axis_offset_m: f64,
    /// eta: trail (m).
    pub trail_m: f64,
    /// eps: caster angle (rad).
    pub caster_angle_rad: f64,
    /// k_x: longitudinal distance between the two parts' centres of gravity (m).
    pub longitudinal_distance_m: f64,
    /// I_yRF, I_yRR: spin inertias of the wheels (kg m^2).
    pub wheel_inertia_front_kg_m2: f64,
    pub wheel_inertia_rear_kg_m2: f64,
    /// I_xF, I_zF: roll and yaw inertia of the front part (kg m^2).
    pub front_roll_inertia_kg_m2: f64,
    pub front_yaw_inertia_kg_m2: f64,
    /// I_xR: roll inertia of the rear part (kg m^2).
    pub rear_roll_inertia_kg_m2: f64,
    /// C_xz: product of inertia of the rear part (kg m^2).
    pub rear_product_inertia_kg_m2: f64,
}

impl Bike {
    /// Reads the bike file; the message names line and column of a fault.
    pub fn from_json(text: &str) -> Result<Self, EngineError> {
        if text.len() > LARGEST_FILE {
            return Err(EngineError::Bike(format!(
                "{} bytes, expected at most {LARGEST_FILE}",
                text.len()
            )));
        }
        let bike: Bike =
            serde_json::from_str(text).map_err(|e| EngineError::Bike(e.to_string()))?;
        bike.validate()?;
        Ok(bike)
    }

    pub fn validate(&self) -> Result<(), EngineError> {
        let positive = [
            ("mass_front_kg", self.mass_front_kg, 1e6),
            ("mass_rear_kg", self.mass_rear_kg, 1e6),
            ("l_front_m", self.l_front_m, 100.0),
            ("l_rear_m", self.l_rear_m, 100.0),
            ("wheel_radius_front_m", self.wheel_radius_front_m, 10.0),
            ("wheel_radius_rear_m", self.wheel_radius_rear_m, 10.0),
            ("static_load_front_n", self.static_load_front_n, 1e7),
            ("static_load_rear_n", self.static_load_rear_n, 1e7),
        ];
        for (name, value, most) in positive {
            if let Some(v) = value
                && !(v > 0.0 && v <= most)
            {
                return Err(EngineError::Bike(format!(
                    "{name} is {v}, expected more than 0 and at most {most}"
                )));
            }
        }
        for (name, value) in [
            ("noise_displacement_m", self.noise_displacement_m),
            ("noise_road_m", self.noise_road_m),
        ] {
            if let Some(v) = value
                && !(0.0..1e6).contains(&v)
            {
                return Err(EngineError::Bike(format!(
                    "{name} is {v} m, expected 0 or more"
                )));
            }
        }
        Ok(())
    }

    pub fn mass(&self, axle: Axle) -> Option<f64> {
        match axle {
            Axle::Front => self.mass_front_kg,
            Axle::Rear => self.mass_rear_kg,
        }
    }

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
