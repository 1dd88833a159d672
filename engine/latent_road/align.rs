//! The rear wheel's samples, brought to the time at which the front wheel stood on the same road.

use std::f64::consts::PI;

use veloid_ride::distance;

/// For every sample of the front wheel, the place (in samples, fractional) at which the rear wheel stood on the same
/// road; nothing after the last that did.
pub fn places(speed: &[f64], step_s: f64, wheelbase_m: f64) -> Vec<Option<f64>> {
    let ridden = distance(speed, step_s);
    let mut j = 0;
    (ridden.iter())
        .map(|x| {
            let ahead = x + wheelbase_m;
            while j + 1 < ridden.len() && ridden[j + 1] < ahead {
                j += 1;
            }
            let next = ridden.get(j + 1)?;
            let width = next - ridden[j];
            Some(
                j as f64
                    + if width > 0.0 {
                        ((ahead - ridden[j]) / width).clamp(0.0, 1.0)
                    } else {
                        0.0
                    },
            )
        })
        .collect()
}

/// Samples on either side that an interpolated value is made from.
const REACH: isize = 12;

/// The record at a fractional sample: sinc under a Hann window of [`REACH`] samples to either side, exact to 0.2 % up to
/// 0.38 of the rate. Beyond its ends the record holds its last value.
pub fn interpolate(values: &[f64], place: f64) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let base = place.floor();
    let part = place - base;
    let last = values.len() as isize - 1;
    let base = (base as isize).clamp(-REACH, last + REACH);
    let sin = (PI * part).sin();
    let (mut sum, mut weights) = (0.0, 0.0);
    for k in 1 - REACH..=REACH {
        let x = part - k as f64;
        let window = (0.5 * PI * x / (REACH as f64 + 1.0)).cos().powi(2);
        // sin(pi (part - k)) = (-1)^k sin(pi part).
        let sinc = match x.abs() < 1e-9 {
            true => 1.0,
            false => sin * if k % 2 == 0 { 1.0 } else { -1.0 } / (PI * x),
        };
        let at = (base + k).clamp(0, last) as usize;
        sum += window * sinc * values[at];
        weights += window * sinc;
    }
    sum / weights
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn the_rear_wheel_comes_to_the_same_place_one_wheelbase_later() {
        let (step, wheelbase) = (0.01, 1.1);
        let ridden = |t: f64| 4.0 * t + 1.0 - t.cos();
        let speed: Vec<f64> = (0..2000).map(|i| 4.0 + (i as f64 * step).sin()).collect();
        let places = places(&speed, step, wheelbase);
        for (i, place) in places.iter().enumerate().take(1900) {
            let t = place.unwrap() * step;
            let behind = ridden(t) - wheelbase - ridden(i as f64 * step);
            assert!(behind.abs() < 1e-3, "{i}: {behind} m");
        }
        assert!(places.last().unwrap().is_none());
        assert!(super::places(&[0.0; 10], step, wheelbase)[0].is_none());
    }

    #[test]
    fn sines_are_met_between_the_samples() {
        for share in [0.05, 0.2, 0.38] {
            let at = |x: f64| (std::f64::consts::TAU * share * x + 0.3).sin();
            let values: Vec<f64> = (0..200).map(|i| at(f64::from(i))).collect();
            for place in [50.0, 60.25, 77.5, 90.9] {
                let off = interpolate(&values, place) - at(place);
                assert!(off.abs() < 2e-3, "{share} at {place}: {off}");
            }
        }
    }

    #[test]
    fn no_place_is_out_of_reach() {
        for place in [-1e300, -3.0, 0.0, 3.9, 1e300, f64::MAX] {
            assert!(interpolate(&[1.0, 2.0, 3.0], place).is_finite(), "{place}");
        }
        assert_eq!(interpolate(&[], 1.0), 0.0);
    }
}
