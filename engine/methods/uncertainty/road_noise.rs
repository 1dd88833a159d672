//! What noise of the road channel does to k and B by output error. The fit bears noise of the displacement; but it takes the road
//! for what moved the axle, and noise there biases it, the more the less the axle is deflected (errors in variables). As much noise
//! again as the channel holds shows by how much (simulation and extrapolation: Cook & Stefanski 1994, J. Am. Stat. Assoc. 89:1314).

use crate::uncertainty::laser::widened;
use crate::uncertainty::road_variant::errors;
use veloid_core::bicycle::{Axle, Bike, PerAxle};
use veloid_core::document::format_number::significant;
use veloid_core::numerics::random::Normal;
use veloid_core::numerics::spectrum::measured_noise;
use veloid_core::settings::Settings;
use veloid_report::{Estimate, Parameters};
use veloid_ride::{AxleRecord, Ride, RoadDoubt};

/// Part of the deflection (RMS) below which noise of the road biases k by less than a ten-thousandth.
const NEGLIGIBLE: f64 = 0.01;
/// Whichever number: the noise that is laid over the road.
const SEED: u64 = 0x726f_6164;

/// Share of k or B by which they must move to be spoken of.
const TOLD: f64 = 0.01;
/// Largest shares of k and B by which noise may move them in a ride that carries intervals and a verdict. Beyond, twice the noise
/// shows too little of what there would be without: on simulated rides of the paper's bicycle with 0.05 mm in road and displacement, k that moved
/// by 0.1 % was off by 0.2 %, by 1 % up to 4 %, by 10 % some 20 %, by 20 % some 60 % (5, 1, 1 and 0.5 m/s).
const MOST: [f64; 2] = [0.05, 0.15];
/// Why such an estimate has no interval.
const DECIDES: &str = "dominated by noise in the road channel";

/// What there is to say of it, by axle.
pub fn worth_reporting(found: &PerAxle<Estimate>, by: &PerAxle<Parameters>) -> PerAxle<Parameters> {
    by.filter_map(|axle, by| {
        let shares = by.shares_of(found.get(axle)?);
        (shares.iter().any(|share| *share > TOLD)).then(|| by.clone())
    })
}

fn is_too_much(found: &Estimate, by: &Parameters) -> bool {
    let mut shares = by.shares_of(found).into_iter().zip(MOST);
    shares.any(|(share, most)| share > most)
}

/// The estimates, without intervals where noise decides.
pub fn borne(found: &PerAxle<Estimate>, by: &PerAxle<Parameters>) -> PerAxle<Estimate> {
    let wide = widened(found, by);
    wide.map(|axle, e| match by.get(axle) {
        Some(by) if is_too_much(e, by) => e.clone().withheld(DECIDES),
        _ => e.clone(),
    })
}

/// Why a ride's road channel lets nobody say what is missing.
pub fn decides(found: &PerAxle<Estimate>, by: &PerAxle<Parameters>) -> Option<String> {
    let too_much = |(axle, e): (Axle, &Estimate)| {
        let by = by.get(axle).filter(|by| is_too_much(e, by))?;
        Some((axle, by.shares_of(e)))
    };
    let (axle, shares) = found.iter().find_map(too_much)?;
    let [k, b] = shares.map(|share| significant(100.0 * share, 2));
    Some(format!(
        "No verdict: noise in the road channel moves k of the {axle} axle by {k} % and B by {b} %, because the tyre deflection is \
         small compared with it. Ride faster or on a rougher road, or record the road with a finer sensor."
    ))
}

/// By how much the noise of its road channel moves k and B of each axle; nothing where the road was made from other sensors, where
/// its noise is not known, or where it is negligible.
pub fn road_noise_error(
    ride: &Ride,
    bike: &Bike,
    settings: &Settings,
    found: &PerAxle<Estimate>,
) -> PerAxle<Parameters> {
    let change = match ride.road_doubts.is_empty() {
        true => ride
            .axles
            .filter_map(|_, record| noise(record, bike, ride.step_s)),
        false => PerAxle::default(),
    };
    let doubt = RoadDoubt {
        change,
        is_noise: true,
    };
    errors(ride, bike, settings, found, &doubt)
}

fn noise(record: &AxleRecord, bike: &Bike, step_s: f64) -> Option<Vec<f64>> {
    if !record.has_road() || record.prescribed {
        return None;
    }
    let size = (bike.noise_road_m).or_else(|| measured_noise(&record.road, step_s))?;
    let deflection = record.road.iter().zip(&record.displacement);
    let squares: f64 = deflection.map(|(u, z)| (u - z).powi(2)).sum();
    let rms = (squares / record.road.len() as f64).sqrt();
    let mut random = Normal::new(SEED);
    (size > NEGLIGIBLE * rms).then(|| record.road.iter().map(|_| size * random.draw()).collect())
}
