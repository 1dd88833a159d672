//! A record that is sampled far faster than anything in it moves says no more for that: fewer samples, each of many. White noise stays
//! white, with the density that it had: all tests of what a model leaves compare it with such noise.

use std::f64::consts::FRAC_PI_2;

use crate::{AxleRecord, Ride, RoadDoubt};
use veloid_core::bicycle::PerAxle;
use veloid_core::numerics::filter::{Beyond, filter};

/// Samples for each period of the fastest motion that are kept at least: cubic splines follow a sine of eight samples to 0.1 %.
const KEPT: f64 = 8.0;
/// Samples that are kept at least.
const LEAST: usize = 1000;
/// Part of the new rate up to which the record passes whole.
const PASSED: f64 = 0.35;
/// Samples of the new rate after which the filter's answer to an impulse has died away to 2e-5 (RMS of what follows).
const REACH: f64 = 40.0;

/// The ride with as few samples as `fastest_hz` asks for; nothing where these are all that there are.
pub fn decimated(ride: &Ride, fastest_hz: f64) -> Option<Ride> {
    let by_rate = 1.0 / (ride.step_s * KEPT * fastest_hz);
    let factor = by_rate.min((ride.samples / LEAST) as f64) as usize;
    if factor < 2 {
        return None;
    }
    let thin = |x: &Vec<f64>| thinned(x, factor);
    let optional = |x: &Option<Vec<f64>>| x.as_ref().map(thin);
    let axle = |record: &AxleRecord| AxleRecord {
        road: if record.has_road() {
            thin(&record.road)
        } else {
            record.road.iter().copied().step_by(factor).collect()
        },
        force: optional(&record.force),
        displacement: thin(&record.displacement),
        acceleration: optional(&record.acceleration),
        valid: (0..record.valid.len())
            .step_by(factor)
            .map(|i| {
                let around = i.saturating_sub(factor)..(i + factor + 1).min(record.valid.len());
                record.valid[around].iter().all(|v| *v)
            })
            .collect(),
        prescribed: record.prescribed,
        plant: record.plant,
        band: record.band,
    };
    Some(Ride {
        start_s: ride.start_s,
        epoch_s: ride.epoch_s,
        step_s: ride.step_s * factor as f64,
        samples: ride.samples.div_ceil(factor),
        sensors: Vec::new(),
        road_doubts: (ride.road_doubts.iter())
            .map(|doubt| RoadDoubt {
                change: doubt.change.map(|_, change| thin(change)),
                is_noise: doubt.is_noise,
            })
            .collect(),
        axles: PerAxle {
            front: ride.axles.front.as_ref().map(axle),
            rear: ride.axles.rear.as_ref().map(axle),
        },
        speed: optional(&ride.speed),
        cadence: optional(&ride.cadence),
        roll: optional(&ride.roll),
        steer: optional(&ride.steer),
        yaw_rate: optional(&ride.yaw_rate),
        lateral_speed: optional(&ride.lateral_speed),
        summary: ride.summary.clone(),
    })
}

/// One filtered sample in `factor`.
fn thinned(x: &[f64], factor: usize) -> Vec<f64> {
    let rate = factor as f64;
    let kept = filter(x, rate, REACH, Beyond::Points, gain);
    kept.into_iter().step_by(factor).collect()
}

/// Gain at a frequency (cycles for each sample that is kept). The squares of the gains at two frequencies that become one add up to 1
/// (Princen & Bradley 1986, doi:10.1109/TASSP.1986.1164954, with the window of Vorbis), so that white noise stays white.
fn gain(cycles: f64) -> f64 {
    let share = ((cycles - PASSED) / (1.0 - 2.0 * PASSED)).clamp(0.0, 1.0);
    (FRAC_PI_2 * (FRAC_PI_2 * share).sin().powi(2)).cos()
}

#[cfg(test)]
mod tests {
    use super::*;
    use veloid_core::numerics::example::white;
    use veloid_core::numerics::spectrum::{Spectrum, measured_noise};

    #[test]
    fn white_noise_stays_white_and_as_dense() {
        for factor in [2, 3, 6] {
            let noise = thinned(&white(24_000, 5), factor);
            let expected = (factor as f64).sqrt().recip();
            let found = measured_noise(&noise, 1.0).expect("flat up to half the rate");
            assert!(
                (found / expected - 1.0).abs() < 0.1,
                "{factor}: {found} for {expected}"
            );
            let rms = (noise.iter().map(|x| x * x).sum::<f64>() / noise.len() as f64).sqrt();
            assert!((rms / expected - 1.0).abs() < 0.03, "{factor}: {rms}");
            let spectrum = Spectrum::new(&noise, 1.0).expect("long enough");
            let count = spectrum.density.len();
            let top = &spectrum.density[9 * count / 10..count - 1];
            let mean = top.iter().sum::<f64>() / top.len() as f64;
            let density = 2.0 * expected * expected;
            assert!((mean / density - 1.0).abs() < 0.15, "{factor}: {mean}");
        }
    }
}
