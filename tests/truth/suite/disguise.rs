//! Whether strange physics is a library effect in disguise on one ride: then `unnamed` could not be asked for.

use super::sizes::Scale;
use crate::refit::fit::{Free, refit};
use crate::refit::known::{Known, STEP_S};
use crate::refit::replay::Replay;
use crate::simulate::effect::{Axle, Effect, Kind};
use crate::simulate::outside::Strange;
use crate::simulate::sensors::Log;
use crate::simulate::vehicle::Bike;

/// The largest share of the explainable held-out variance that a refit of one library effect removes, of those that come near.
pub fn share(
    log: Log,
    file: &Bike,
    (kind, axle): (Strange, usize),
    known: &Known,
    scale: &Scale,
) -> f64 {
    let start = Bike {
        stiffness_n_m: known.plain_k,
        damping_n_s_m: known.plain_b,
        ..file.clone()
    };
    let replay = Replay::new(log, file.clone(), STEP_S);
    let active = [axle == 0, axle == 1];
    let explainable = known.plain_m[axle].powi(2) - known.floor_m[axle].powi(2);
    near(kind, axle, known, scale)
        .into_iter()
        .filter_map(|(kind, values)| {
            let effect = Effect::new(kind, Axle::ONE[axle], &values);
            refit(&replay, &start, &[effect], None, active, Free::All)
        })
        .map(|fit| (known.plain_m[axle].powi(2) - fit.held_out_m[axle].powi(2)) / explainable)
        .fold(0.0, f64::max)
}

/// The effects that are refitted, from what they would be on this axle: six for the twelve kinds that were chosen with them,
/// and six more for the others.
fn near(kind: Strange, axle: usize, known: &Known, scale: &Scale) -> Vec<(Kind, Vec<f64>)> {
    let (k, b, d, w) = (
        known.plain_k[axle],
        known.plain_b[axle],
        scale.deflection_m[axle],
        scale.rate_m_s[axle],
    );
    let mut near = vec![
        (Kind::QuadraticDamping, vec![0.3 * b / w]),
        (Kind::CoulombFriction, vec![10.0]),
        (Kind::Hysteresis, vec![0.2 * k, 0.1 * k * d]),
        (Kind::CubicStiffness, vec![0.1 * k / (4.0 * d * d)]),
        (Kind::BumpStop, vec![1.5 * d, k, 1.0]),
        (Kind::BumpStop, vec![1.2 * d, k, 0.0]),
    ];
    if !Strange::KNOWN.contains(&kind) {
        near.extend([
            (Kind::ViscoelasticTyre, vec![0.3 * k, 0.03]),
            (Kind::ProgressiveStiffness, vec![0.3 * k / (2.0 * d)]),
            (Kind::AsymmetricDamping, vec![0.3]),
            (Kind::FreePlay, vec![0.5 * d]),
            (Kind::SprungMass, vec![0.2, 5.0, 0.3]),
            (Kind::GroundDamping, vec![0.3 * b]),
        ]);
    }
    near
}
