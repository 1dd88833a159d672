//! What the key tells about a ride once it is open: the plain model's error, the noise floor, and the oracle.

use std::path::Path;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::fit::{Fit, Free, plain, refit, touched};
use super::replay::{self, Replay};
use crate::files;
use crate::simulate::effect::{Effect, Kind};
use crate::simulate::outside::Outside;
use crate::simulate::vehicle::{Bike, Vehicle};

/// Step of the refits, s, unless dry friction needs a shorter one.
pub const STEP_S: f64 = 1e-3;
/// Step of plain refits, s; divides the sampling intervals of 5 and 10 ms.
pub const PLAIN_STEP_S: f64 = 2.5e-3;

/// Held-out errors (m) of one ride, front then rear; `None` where a fit broke down or does not apply.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Known {
    pub plain_m: [f64; 2],
    pub plain_k: [f64; 2],
    pub plain_b: [f64; 2],
    /// The true vehicle driven by the logged inputs.
    pub floor_m: [f64; 2],
    /// The true structure refitted.
    pub oracle_m: Option<[f64; 2]>,
    /// Its parameters, per effect in the order of the key.
    pub oracle_values: Vec<Vec<f64>>,
    pub touched: [bool; 2],
}

impl Known {
    /// Plain over floor, the larger of the axles that the truth touches (of both when it touches none). The floor is the better
    /// of the truth as it is and refitted: channels that are integrated (speed, cadence) put their noise into its phase.
    pub fn visibility(&self) -> f64 {
        let none = self.touched == [false; 2];
        let floor = |a: usize| {
            self.oracle_m
                .map_or(self.floor_m[a], |oracle| self.floor_m[a].min(oracle[a]))
        };
        (0..2)
            .filter(|&a| none || self.touched[a])
            .map(|a| self.plain_m[a] / floor(a))
            .fold(0.0, f64::max)
    }
}

/// The truth of one ride as the key holds it.
pub struct Truth {
    pub effects: Vec<Effect>,
    pub outside: Option<Outside>,
    pub stiffness_n_m: [f64; 2],
    pub damping_n_s_m: [f64; 2],
    /// Where the bike file has others, kg.
    pub mass_kg: Option<[f64; 2]>,
}

impl Truth {
    pub fn read(entry: &Value) -> Option<Self> {
        let pair = |name| pair(entry, name);
        Some(Self {
            effects: entry["effects"]
                .as_array()?
                .iter()
                .map(Effect::from_json)
                .collect::<Option<_>>()?,
            outside: if entry["outside"].is_null() {
                None
            } else {
                Some(Outside::from_json(&entry["outside"])?)
            },
            stiffness_n_m: pair("stiffness_n_m")?,
            damping_n_s_m: pair("damping_n_s_m")?,
            mass_kg: pair("mass_kg"),
        })
    }

    fn bike(&self, file: &Bike) -> Bike {
        Bike {
            stiffness_n_m: self.stiffness_n_m,
            damping_n_s_m: self.damping_n_s_m,
            mass_kg: self.mass_kg.unwrap_or(file.mass_kg),
            ..file.clone()
        }
    }

    /// A step at which explicit integration of this truth is stable.
    fn step_s(&self, file: &Bike) -> f64 {
        let vehicle = Vehicle {
            effects: self.effects.clone(),
            ..Vehicle::plain(self.bike(file))
        };
        let rate = vehicle.friction_rate(0).max(vehicle.friction_rate(1));
        let stiff = |e: &Effect| {
            matches!(
                e.kind,
                Kind::Hysteresis | Kind::QuadraticDamping | Kind::UnsprungMass
            )
        };
        let yields = self.effects.iter().any(stiff);
        if rate * STEP_S > 1.5 || yields || self.outside.is_some() {
            STEP_S / 4.0
        } else {
            STEP_S
        }
    }
}

fn pair(entry: &Value, name: &str) -> Option<[f64; 2]> {
    Some([entry[name][0].as_f64()?, entry[name][1].as_f64()?])
}

/// Plain refit, floor and, if asked, oracle of one ride.
pub fn assess(
    log: crate::simulate::sensors::Log,
    file: &Bike,
    truth: &Truth,
    with_oracle: bool,
) -> Option<Known> {
    let start = truth.bike(file);
    let replay = Replay::new(log, file.clone(), PLAIN_STEP_S);
    let plain = plain(&replay, &start)?;
    let replay = Replay::new(replay.log, file.clone(), truth.step_s(file));
    let run = |active, free| {
        refit(
            &replay,
            &start,
            &truth.effects,
            truth.outside.as_ref(),
            active,
            free,
        )
    };
    let floor = run(replay.log.has(), Free::Nothing)?;
    let touched = touched(&truth.effects, truth.outside.as_ref());
    let oracle = (with_oracle && truth.outside.is_none() && !truth.effects.is_empty())
        .then(|| run(touched, Free::All))
        .flatten();
    Some(known(plain, floor, oracle, touched))
}

fn known(plain: Fit, floor: Fit, oracle: Option<Fit>, touched: [bool; 2]) -> Known {
    Known {
        plain_m: plain.held_out_m,
        plain_k: plain.vehicle.bike.stiffness_n_m,
        plain_b: plain.vehicle.bike.damping_n_s_m,
        floor_m: floor.held_out_m,
        oracle_m: oracle.as_ref().map(|f| f.held_out_m),
        oracle_values: oracle
            .map(|f| f.vehicle.effects.into_iter().map(|e| e.values).collect())
            .unwrap_or_default(),
        touched,
    }
}

#[derive(Debug, thiserror::Error)]
pub enum KnownError {
    #[error(transparent)]
    Files(#[from] files::FilesError),
    #[error("ride {ride}: {source}")]
    Replay {
        ride: String,
        source: replay::ReplayError,
    },
    #[error("ride {0}: the key does not describe it")]
    Key(String),
}

/// Reads one ride back from its files.
pub fn open(
    folder: &Path,
    name: &str,
) -> Result<(crate::simulate::sensors::Log, Bike), KnownError> {
    let fail = |source| KnownError::Replay {
        ride: name.to_owned(),
        source,
    };
    let log = replay::log(&files::read(&folder.join(format!("ride_{name}.csv")))?).map_err(fail)?;
    let bike = replay::bike(&files::read_json(
        &folder.join(format!("bike_{name}.json")),
    )?)
    .map_err(fail)?;
    Ok((log, bike))
}

/// Every ride of a key, in its order.
pub fn all(folder: &Path, key: &Value) -> Result<Vec<Option<Known>>, KnownError> {
    let entries = key["rides"].as_array().cloned().unwrap_or_default();
    entries
        .par_iter()
        .map(|entry| {
            let name = entry["ride"].as_str().unwrap_or_default();
            let truth = Truth::read(entry).ok_or_else(|| KnownError::Key(name.to_owned()))?;
            let (mut log, bike) = open(folder, name)?;
            log.limit_m = pair(entry, "limit_m");
            Ok(assess(log, &bike, &truth, true))
        })
        .collect()
}
