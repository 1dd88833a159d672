//! Whether strange physics is a library effect in disguise on one ride: then `unnamed` could not be asked for.

use super::sizes::Scale;
use crate::refit::fit::{Free, refit};
use crate::refit::known::{Known, STEP_S};
use crate::refit::replay::Replay;
use crate::simulate::effect::{Axle, Effect, Kind};
use crate::simulate::sensors::Log;
use crate::simulate::vehicle::Bike;

/// The largest share of the explainable held-out variance that a refit of one library effect removes, of those that come near.
pub fn share(log: Log, file: &Bike, axle: usize, known: &Known, scale: &Scale) -> f64 {
    let start = Bike {
        stiffness_n_m: known.plain_k,
        damping_n_s_m: known.plain_b,
        ..file.clone()
    };
    let (k, b, d, w) = (
        known.plain_k[axle],
        known.plain_b[axle],
        scale.deflection_m[axle],
        scale.rate_m_s[axle],
    );
    let near: [(Kind, &[f64]); 6] = [
        (Kind::QuadraticDamping, &[0.3 * b / w]),
        (Kind::CoulombFriction, &[10.0]),
        (Kind::Hysteresis, &[0.2 * k, 0.1 * k * d]),
        (Kind::CubicStiffness, &[0.1 * k / (4.0 * d * d)]),
        (Kind::BumpStop, &[1.5 * d, k, 1.0]),
        (Kind::BumpStop, &[1.2 * d, k, 0.0]),
    ];
    let replay = Replay::new(log, file.clone(), STEP_S);
    let active = [axle == 0, axle == 1];
    let explainable = known.plain_m[axle].powi(2) - known.floor_m[axle].powi(2);
    near.iter()
        .filter_map(|(kind, values)| {
            let effect = Effect::new(*kind, Axle::ONE[axle], values);
            refit(&replay, &start, &[effect], None, active, Free::All)
        })
        .map(|fit| (known.plain_m[axle].powi(2) - fit.held_out_m[axle].powi(2)) / explainable)
        .fold(0.0, f64::max)
}
