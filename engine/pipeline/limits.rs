//! Stiffness and damping that the user fixes or bounds, on a ride.

use veloid_core::EngineError;
use veloid_core::bicycle::{Bike, LimitError};
use veloid_core::settings::{Settings, limit};
use veloid_ride::Ride;

/// That methods beside output error and the search know no limits.
pub const NOTE: &str = "what is fixed or bounded holds in output error and in the search for missing physics; least squares, instrumental \
    variables and the swarm are estimated freely";

/// The bicycle with what its file and the settings fix and bound on a ride.
///
/// # Errors
/// What cannot be fixed or bounded, and axles without a mass or without a road or force.
pub fn limited(ride: &Ride, bike: &Bike, settings: &Settings) -> Result<Bike, EngineError> {
    let limited = settings.limited(bike)?;
    for (key, axle) in limited.limited() {
        let key = key.to_owned();
        match ride.axles.get(axle).filter(|_| !ride.has_no_road()) {
            None => return Err(limit(LimitError::NotRecorded { key, axle })),
            Some(record) if !record.prescribed && bike.mass(axle).is_none() => {
                return Err(limit(LimitError::NoMass { key, axle }));
            }
            Some(_) => {}
        }
    }
    Ok(limited)
}

/// Refuses limits where several rides are fitted as one.
///
/// # Errors
/// Anything that is fixed or bounded.
pub fn none(bike: &Bike, settings: &Settings) -> Result<(), EngineError> {
    let limited = settings.limited(bike)?;
    let key = limited.limited().next().map(|(key, _)| key.to_owned());
    key.map_or(Ok(()), |key| Err(limit(LimitError::Study { key })))
}
