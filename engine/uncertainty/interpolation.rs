//! What the road between its samples does to k and B. Between samples the road is a cubic spline through lifted samples, which passes on less and
//! less of what lies near half the sampling rate. On a fast axle that is missing motion: a ride whose road is raised by what the spline takes off shows by how much k and B move.

use crate::bicycle::{Bike, PerAxle};
use crate::numerics::filter::{Beyond, filter};
use crate::numerics::spline::passes;
use crate::report::{Estimate, Parameters};
use crate::ride::{AxleRecord, Ride, RoadDoubt};
use crate::settings::Settings;
use crate::uncertainty::identifiable::fastest;
use crate::uncertainty::road_variant::errors;

/// Motion (radians a sample) of an axle up to which interpolation does nothing: at 1.5, roads up to 0.45 of the rate moved B by 1 %
/// (`veloid-truth make --suite quiet --seed 5`), and it falls with the fourth power.
const SLOW: f64 = 0.8;
/// Least part that a spline passes on, and so the most by which it is made up for: noise is there too.
const LEAST: f64 = 0.5;
/// Samples after which the answer of the filter to one sample has died away.
const REACH: f64 = 24.0;

/// By how much interpolation moves k and B of each axle; nothing on axles that are slow beside the samples.
pub fn interpolation_error(
    ride: &Ride,
    bike: &Bike,
    settings: &Settings,
    found: &PerAxle<Estimate>,
) -> PerAxle<Parameters> {
    faster_than(SLOW, ride, bike, settings, found)
}

/// The same of one ride among several: what interpolation does to all of them alike is not small beside what they say together.
pub fn interpolation_error_of_many(
    ride: &Ride,
    bike: &Bike,
    settings: &Settings,
    found: &PerAxle<Estimate>,
) -> PerAxle<Parameters> {
    faster_than(0.0, ride, bike, settings, found)
}

/// Of axles whose motion is faster than so many radians a sample.
fn faster_than(
    slow: f64,
    ride: &Ride,
    bike: &Bike,
    settings: &Settings,
    found: &PerAxle<Estimate>,
) -> PerAxle<Parameters> {
    let is_fast = |e: &Estimate| {
        e.mass_kg > 0.0 && fastest(e.k_n_m / e.mass_kg, e.b_n_s_m / e.mass_kg) * ride.step_s > slow
    };
    let change = ride.axles.filter_map(|axle, record| {
        let counts = found.get(axle).is_some_and(is_fast);
        (counts && record.has_road() && !record.prescribed).then(|| taken_off(record, ride.step_s))
    });
    let doubt = RoadDoubt {
        change,
        is_noise: false,
    };
    errors(ride, bike, settings, found, &doubt)
}

/// What the spline takes off the road, at its samples.
fn taken_off(record: &AxleRecord, step_s: f64) -> Vec<f64> {
    let rate = 1.0 / step_s;
    let gain = |hz: f64| 1.0 / passes(hz * step_s).max(LEAST) - 1.0;
    filter(&record.road, rate, REACH * step_s, Beyond::Points, gain)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::pipeline::{conclude, observe};
    use crate::report::stages::Conclusion;
    use crate::simulate::simulated_ride::{SimulatedRide, Spring};

    fn concluded(rate_hz: f64, spring: Spring) -> Conclusion {
        let simulated = SimulatedRide {
            rate_hz,
            duration_s: 60.0,
            front: Some(spring),
            rear: None,
            noise_displacement_m: 5e-5,
            ..SimulatedRide::default()
        };
        let bike = Bike {
            mass_front_kg: Some(spring.mass_kg),
            ..Bike::default()
        };
        let settings = Settings::default();
        let ride = simulated.ride();
        let observed = observe(&ride, &bike, &settings).unwrap();
        conclude(&ride, &bike, &settings, &observed, Vec::new()).unwrap()
    }

    /// At 20 Hz an axle of 8 Hz is off by more than the fit knows of, and the interval bears it; at 100 Hz nothing is off.
    #[test]
    fn intervals_bear_what_slow_samples_hide() {
        let spring = Spring {
            mass_kg: 23.0,
            k_n_m: 60e3,
            b_n_s_m: 600.0,
        };
        let slow = concluded(20.0, spring);
        let e = slow.output_error.front.unwrap();
        let by = slow.interpolation_error.front.unwrap();
        assert!(by.b_n_s_m.abs() > 0.01 * spring.b_n_s_m, "{by:?}");
        assert!(
            (e.b_n_s_m - spring.b_n_s_m).abs() < 3.0 * e.b_std_n_s_m.unwrap(),
            "{e:?}"
        );
        assert!(
            (e.k_n_m - spring.k_n_m).abs() < 3.0 * e.k_std_n_m.unwrap(),
            "{e:?}"
        );
        assert!(concluded(100.0, spring).interpolation_error.front.is_none());
    }

    /// The axle's motion per sample decides whether there is anything to refit.
    #[test]
    fn an_axle_is_fast_from_its_motion_per_sample_on() {
        let at = |share: f64| {
            let k_n_m = 23.0 * (share * SLOW * 50.0_f64).powi(2);
            let spring = Spring {
                mass_kg: 23.0,
                k_n_m,
                b_n_s_m: 400.0,
            };
            concluded(50.0, spring).interpolation_error.front.is_some()
        };
        assert!(!at(0.9) && at(1.1));
    }
}
