//! What a mass that is not known exactly does to k and B.

use crate::EngineError;
use crate::bicycle::{Axle, Bike, PerAxle};
use crate::output_error;
use crate::output_error::start::starts_from;
use crate::report::{Estimate, Parameters};
use crate::ride::Ride;
use crate::settings::Settings;

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
            k_n_m: (moved.k_n_m - e.k_n_m).abs(),
            b_n_s_m: (moved.b_n_s_m - e.b_n_s_m).abs(),
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::Silent;
    use crate::simulate::simulated_ride::SimulatedRide;

    /// On a road k and B are as uncertain as the mass, in parts of themselves.
    #[test]
    fn a_masss_deviation_is_borne_in_proportion() {
        let bike = |std: Option<f64>| Bike {
            mass_front_kg: Some(23.0),
            mass_rear_kg: Some(63.0),
            mass_front_std_kg: std,
            ..Bike::default()
        };
        let settings = Settings {
            trials: 1,
            iterations: 2,
            diagnosis: false,
            ..Settings::default()
        };
        let ride = SimulatedRide::default().ride();
        let reported = |std| crate::identify(&ride, &bike(std), &settings, &Silent).unwrap();
        let (exact, unsure) = (reported(None), reported(Some(0.46)));
        let [before, after] = [&exact, &unsure].map(|r| r.output_error.front.clone().unwrap());
        assert_eq!((before.k_n_m, before.b_n_s_m), (after.k_n_m, after.b_n_s_m));
        let ratio = |std: Option<f64>, before: Option<f64>, value: f64| {
            (std.unwrap().powi(2) - before.unwrap().powi(2)).sqrt() / value
        };
        let k = ratio(after.k_std_n_m, before.k_std_n_m, after.k_n_m);
        let b = ratio(after.b_std_n_s_m, before.b_std_n_s_m, after.b_n_s_m);
        assert!(
            (k / 0.02 - 1.0).abs() < 0.02 && (b / 0.02 - 1.0).abs() < 0.02,
            "{k} {b}"
        );
        let rear = |r: &crate::report::Report| r.output_error.rear.clone().unwrap().k_std_n_m;
        assert_eq!(rear(&exact), rear(&unsure));
        let said = unsure.comparison.notes.concat();
        assert!(
            said.contains("front axle: the mass's standard deviation moves k by 2"),
            "{said}"
        );
    }
}
