//! The example rides of `serve --demo`.

use std::collections::BTreeMap;

use jiff::ToSpan;
use jiff::civil::{Date, date};
use serde_json::{Value, json};
use veloid_engine::bicycle::Bike;
use veloid_engine::report::diagnosis::Place;
use veloid_engine::simulate::road::Roughness;
use veloid_engine::simulate::simulated_ride::{Excitation, SimulatedRide, Spring};
use veloid_engine::{EngineError, Imposed, Ride, sensed, simulate};

use crate::cli::ride_csv;

/// Noise of the displacement sensors (m) and of the accelerometers (m/s^2).
const NOISE_M: f64 = 5e-5;
const NOISE_M_S2: f64 = 0.05;
/// Dry friction of the second ride's fork (N).
const FRICTION_N: f64 = 40.0;
/// How the front spring of the season's bicycle stiffens (N/m^2): no ride shows it, all of them together do.
const STIFFENING: f64 = 1.5e5;
/// Rides of the season, the first one after the service, days between two rides.
const RIDES: u32 = 12;
const SERVICED: u32 = 7;
const APART: u32 = 14;
/// Stiffness of the front axle (N/m) before and after the service, and the scatter from ride to ride as a share of it.
const BEFORE: f64 = 104e3;
const AFTER: f64 = 112e3;
const SCATTER: f64 = 0.006;
/// The bicycle of the season, and the day of its service.
pub const SEASON: &str = "demo-season";
pub const SERVICE_DAY: &str = "2026-05-01";
/// The last day of the season.
const LAST_DAY: Date = date(2026, 6, 30);

/// A ride to upload.
pub struct Example {
    pub file: String,
    pub csv: String,
    pub bike: Value,
    pub options: Value,
    pub ridden_at: Option<String>,
    /// What it is an example of.
    pub about: &'static str,
}

/// One ride that the plain model explains, one that hides friction, one of accelerometers alone that hides it too.
pub fn singles() -> Result<Vec<Example>, EngineError> {
    let ride = SimulatedRide {
        noise_displacement_m: NOISE_M,
        ..SimulatedRide::default()
    };
    let friction = at_the_front("coulomb_friction", "friction", FRICTION_N);
    let single = |name: &str, ride: &Ride, about| Example {
        file: format!("{name}.csv"),
        csv: ride_csv::text(ride, &[]),
        bike: bicycle(&format!("demo-{name}")),
        options: json!({}),
        ridden_at: None,
        about,
    };
    let clean = simulate(&ride, &Bike::default(), &[])?;
    let rubbing = simulate(&ride, &Bike::default(), std::slice::from_ref(&friction))?;
    let longer = SimulatedRide {
        duration_s: 120.0,
        noise_displacement_m: 0.0,
        ..ride
    };
    let sensed = sensed(&longer, &Bike::default(), &[friction], NOISE_M_S2)?;
    Ok(vec![
        single("clean", &clean, "the plain model explains it"),
        single(
            "friction",
            &rubbing,
            "the fork rubs, which the model leaves out",
        ),
        single(
            "accelerometers",
            &sensed,
            "no road sensor, and the fork rubs",
        ),
    ])
}

fn at_the_front(effect: &str, parameter: &str, value: f64) -> Imposed {
    Imposed {
        id: effect.to_owned(),
        axle: Place::Front,
        parameters: BTreeMap::from([(parameter.to_owned(), value)]),
    }
}

/// Short rides of one bicycle over half a year, with a service after which the front axle is stiffer.
pub fn season() -> Result<Vec<Example>, EngineError> {
    let stiffening = at_the_front("progressive_stiffness", "k2", STIFFENING);
    let acting = std::slice::from_ref(&stiffening);
    let ride = |index: u32| {
        let stiffness = if index < SERVICED { BEFORE } else { AFTER };
        // A fixed pattern in place of random numbers: the same rides at every start.
        let scatter = SCATTER * f64::from(index * 7 % 5) / 2.0 - SCATTER;
        let simulated = SimulatedRide {
            duration_s: 20.0,
            noise_displacement_m: NOISE_M,
            front: Some(Spring {
                mass_kg: 23.0,
                k_n_m: stiffness * (1.0 + scatter),
                b_n_s_m: 1150.0,
            }),
            excitation: Excitation::Road {
                roughness: Some(Roughness::C),
                bumps: Vec::new(),
            },
            seed: u64::from(index) + 10,
            ..SimulatedRide::default()
        };
        let day = LAST_DAY.saturating_sub(i64::from((RIDES - 1 - index) * APART).days());
        Ok(Example {
            file: format!("season-{:02}.csv", index + 1),
            csv: ride_csv::text(&simulate(&simulated, &Bike::default(), acting)?, &[]),
            bike: bicycle(SEASON),
            options: json!({"trials": 2}),
            ridden_at: Some(day.to_string()),
            about: "a season with a service",
        })
    };
    (0..RIDES).map(ride).collect()
}

fn bicycle(name: &str) -> Value {
    json!({"bike": name, "mass_front_kg": 23.0, "mass_rear_kg": 63.0, "l_front_m": 0.808, "l_rear_m": 0.293})
}
