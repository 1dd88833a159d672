//! What a road that may as well have been another one does to k and B by output error.

use crate::output_error;
use crate::output_error::start::starts_from;
use veloid_core::EngineError;
use veloid_core::bicycle::{Bike, PerAxle};
use veloid_core::settings::Settings;
use veloid_report::{Estimate, Parameters};
use veloid_ride::{Ride, RoadDoubt};

/// By how much k and B move on the other road, of the axles whose road changes; nothing where none does, or nothing is found there.
pub fn errors(
    ride: &Ride,
    bike: &Bike,
    settings: &Settings,
    found: &PerAxle<Estimate>,
    doubt: &RoadDoubt,
) -> PerAxle<Parameters> {
    if doubt.change.iter().next().is_none() {
        return PerAxle::default();
    }
    match moved(ride, bike, settings, found, doubt) {
        Ok(by) => by.filter_map(|axle, by| doubt.change.get(axle).map(|_| by.clone())),
        Err(_) => PerAxle::default(),
    }
}

/// By how much k and B move on the other road. Noise is added once as it is and once turned over: what does not average out is left.
pub fn moved(
    ride: &Ride,
    bike: &Bike,
    settings: &Settings,
    found: &PerAxle<Estimate>,
    doubt: &RoadDoubt,
) -> Result<PerAxle<Parameters>, EngineError> {
    let signs: &[f64] = if doubt.is_noise { &[1.0, -1.0] } else { &[1.0] };
    let share = 1.0 / signs.len() as f64;
    let mut sum = found.map(|_, _| Parameters::default());
    for sign in signs {
        let other = changed(ride, &doubt.change, *sign);
        let fits = output_error::fit(&other, bike, settings, &[starts_from(found)])?;
        let refitted = fits.map(|axle, fit| fit.estimate(bike.mass(axle).is_some()));
        sum = found.map(|axle, e| {
            let before: Parameters = sum.get(axle).cloned().unwrap_or_default();
            let by = refitted
                .get(axle)
                .map(|r| [r.k_n_m - e.k_n_m, r.b_n_s_m - e.b_n_s_m]);
            let [k, b] = by.unwrap_or([e.k_n_m, e.b_n_s_m]);
            Parameters {
                k_n_m: before.k_n_m + share * k,
                b_n_s_m: before.b_n_s_m + share * b,
            }
        });
    }
    Ok(sum)
}

/// The ride on a road that is higher by so many times `change`.
fn changed(ride: &Ride, change: &PerAxle<Vec<f64>>, times: f64) -> Ride {
    let mut other = ride.clone();
    other.axles = ride.axles.map(|axle, record| {
        let mut record = record.clone();
        let by = change.get(axle).into_iter().flatten();
        for (u, by) in record.road.iter_mut().zip(by) {
            *u += times * by;
        }
        record
    });
    other
}
