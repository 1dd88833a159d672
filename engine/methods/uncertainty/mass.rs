//! What a mass that is not known exactly does to k and B.

use crate::output_error;
use crate::output_error::start::starts_from;
use veloid_core::EngineError;
use veloid_core::bicycle::{Axle, Bike, PerAxle};
use veloid_core::settings::Settings;
use veloid_report::{Estimate, Parameters};
use veloid_ride::Ride;

/// By how much k and B move when each mass is one standard deviation larger, by output error once more: on a road in proportion
/// to it, where a force drives the axle by less. Only on axles whose mass has a deviation in the bike file.
///
/// # Errors
/// No finite fit.
pub fn mass_error(
    ride: &Ride,
    bike: &Bike,
    settings: &Settings,
    found: &PerAxle<Estimate>,
) -> Result<PerAxle<Parameters>, EngineError> {
    let mut out = PerAxle::default();
    let Some(heavier) = heavier(bike) else {
        return Ok(out);
    };
    let fits = output_error::fit(ride, &heavier, settings, &[starts_from(found)])?;
    for (axle, e) in found.iter() {
        let (Some(_), Some(fit)) = (bike.mass_std(axle), fits.get(axle)) else {
            continue;
        };
        let moved = fit.estimate(true);
        let by = Parameters {
            k_n_m: moved.k_n_m - e.k_n_m,
            b_n_s_m: moved.b_n_s_m - e.b_n_s_m,
        };
        out.set(axle, by);
    }
    Ok(out)
}

/// The bicycle with every mass one standard deviation larger; nothing where none has one.
fn heavier(bike: &Bike) -> Option<Bike> {
    let more = |axle| Some(bike.mass(axle)? + bike.mass_std(axle).unwrap_or(0.0));
    Axle::BOTH
        .iter()
        .any(|axle| bike.mass_std(*axle).is_some())
        .then(|| Bike {
            mass_front_kg: more(Axle::Front),
            mass_rear_kg: more(Axle::Rear),
            ..bike.clone()
        })
}
