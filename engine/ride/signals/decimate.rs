//! A record that is sampled far faster than anything in it moves says no more for that: fewer samples, each of many.

use crate::bicycle::PerAxle;
use crate::ride::band::Band;
use crate::ride::{AxleRecord, Ride, RoadDoubt};

/// Samples for each period of the fastest motion that are kept at least: cubic splines follow a sine of eight samples to 0.1 %.
const KEPT: f64 = 8.0;
/// Samples that are kept at least.
const LEAST: usize = 1000;
/// Part of the new rate up to which the record passes.
const PASSED: f64 = 0.4;

/// The ride with as few samples as `fastest_hz` asks for; nothing where these are all that there are.
pub fn decimated(ride: &Ride, fastest_hz: f64) -> Option<Ride> {
    let by_rate = 1.0 / (ride.step_s * KEPT * fastest_hz);
    let factor = by_rate.min((ride.samples / LEAST) as f64) as usize;
    if factor < 2 {
        return None;
    }
    let rate = 1.0 / ride.step_s;
    let band = Band {
        low_hz: None,
        high_hz: Some(PASSED * rate / factor as f64),
    };
    let thin = |x: &Vec<f64>| -> Vec<f64> {
        let kept = band.keep(x, rate);
        kept.into_iter().step_by(factor).collect()
    };
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulate::simulated_ride::SimulatedRide;

    #[test]
    fn what_is_slow_keeps_its_shape_on_fewer_samples() {
        let mut ride = SimulatedRide::default().ride();
        let step = ride.step_s;
        let swing = |t: f64| 1e-3 * (2.0 * t).sin();
        for record in [&mut ride.axles.front, &mut ride.axles.rear]
            .into_iter()
            .flatten()
        {
            record.displacement = (0..ride.samples).map(|i| swing(i as f64 * step)).collect();
            record.valid[1234] = false;
        }
        let fewer = decimated(&ride, 0.5).unwrap_or_else(|| unreachable!("0.5 Hz at 100 Hz"));
        let factor = (fewer.step_s / step).round() as usize;
        assert!(factor > 1 && fewer.samples >= LEAST, "{factor}");
        for (_, record) in fewer.axles.iter() {
            assert_eq!(record.displacement.len(), fewer.samples);
            for i in 20..fewer.samples - 20 {
                let error = record.displacement[i] - swing(i as f64 * fewer.step_s);
                assert!(error.abs() < 1e-6, "{i}: {error}");
            }
            assert!(!record.valid[1234 / factor]);
        }
        assert!(decimated(&ride, 20.0).is_none());
    }
}
