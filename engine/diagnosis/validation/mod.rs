//! A model on a ride that it was not identified from: how well it predicts it, where it does not, and whether its numbers differ there by
//! more than their intervals allow.

mod axle;
mod carried;
mod error;
mod parameters;
mod simulated;
mod words;

pub use error::Incomparable;
pub use simulated::Start;
pub use words::quantity;

use carried::Carried;
use simulated::{Simulated, predicted};
use veloid_core::bicycle::{Axle, Bike, PerAxle};
use veloid_report::{IdentifiedModel, ModelOnRide};
use veloid_ride::Ride;

/// Compares a model with a ride, `bike` being the bicycle as it was ridden there. Numbers differ where chance would do so less often than
/// `alpha`.
///
/// # Errors
/// The ride and the model have no axle in common that could be simulated, or the model is not one of this version.
pub fn compare(
    model: &IdentifiedModel,
    ride: &Ride,
    bike: &Bike,
    alpha: f64,
) -> Result<ModelOnRide, Incomparable> {
    let carried = Carried::new(model, ride, bike)?;
    let dataset = &carried.dataset;
    let mut failed = Vec::new();
    let mut with_effects = Vec::new();
    for (unit, point) in carried.units(&carried.terms) {
        let axles: Vec<Axle> = unit
            .tracks
            .iter()
            .map(|t| dataset.tracks[*t].axle)
            .collect();
        match Simulated::new(dataset, unit, point) {
            Ok(simulated) => with_effects.push(simulated),
            Err(why) => failed.extend(axles.into_iter().map(|axle| format!("{axle} axle: {why}"))),
        }
    }
    let plain: Vec<Simulated> = match carried.terms.is_empty() {
        true => Vec::new(),
        false => (carried.plain_units(model).into_iter())
            .filter_map(|(unit, point)| Simulated::new(dataset, unit, point).ok())
            .collect(),
    };
    let mut axles = PerAxle::default();
    for simulated in &with_effects {
        let compared = axle::Compared {
            model,
            carried: &carried,
            simulated,
            plain: &plain,
            alpha,
        };
        axles = compared.axles(axles);
    }
    let mut left_out = carried.left_out;
    left_out.extend(failed);
    if axles.iter().next().is_none() {
        return Err(Incomparable::NothingLeft(left_out));
    }
    Ok(ModelOnRide {
        veloid: env!("CARGO_PKG_VERSION").to_owned(),
        sentence: words::all(&axles),
        warnings: Vec::new(),
        axles,
        left_out,
    })
}

/// What the model predicts along a ride: the time of each sample (s), which may be fewer than the ride's, and by axle the displacement (m), or the
/// force (N) where a rig prescribes the motion; no axle on which the model diverges.
///
/// # Errors
/// As of [`compare`].
pub fn predict(
    model: &IdentifiedModel,
    ride: &Ride,
    bike: &Bike,
    start: Start,
) -> Result<(Vec<f64>, PerAxle<Vec<f64>>), Incomparable> {
    let carried = Carried::new(model, ride, bike)?;
    let dataset = &carried.dataset;
    let mut axles = PerAxle::default();
    for (unit, point) in carried.units(&carried.terms) {
        let predicted = predicted(dataset, &unit, point, start);
        for (t, values) in unit.tracks.iter().zip(predicted.into_iter().flatten()) {
            axles.set(dataset.tracks[*t].axle, values);
        }
    }
    let times = (0..dataset.samples).map(|i| ride.start_s + i as f64 * dataset.step);
    Ok((times.collect(), axles))
}
