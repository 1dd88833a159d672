//! What the road between its samples does to k and B. Between samples the road is a cubic spline through lifted samples, which passes on less and
//! less of what lies near half the sampling rate. On a fast axle that is missing motion: a ride whose road is raised by what the spline takes off shows by how much k and B move.

use crate::uncertainty::road_variant::errors;
use veloid_core::bicycle::{Bike, PerAxle};
use veloid_core::numerics::filter::{Beyond, filter};
use veloid_core::numerics::spline::passes;
use veloid_core::settings::Settings;
use veloid_report::identifiable::fastest;
use veloid_report::{Estimate, Parameters};
use veloid_ride::{AxleRecord, Ride, RoadDoubt};

/// Motion (radians a sample) of an axle up to which interpolation does nothing: at 1.5, roads up to 0.45 of the rate moved B by 1 %
/// (`veloid-truth make --suite quiet --seed 5`), and it falls with the fourth power.
pub const SLOW: f64 = 0.8;
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
