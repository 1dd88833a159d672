//! The rear wheel meets the front wheel's road one wheelbase later.

use crate::channels::channel::Channel;
use crate::error::{Problem, ReadError};
use crate::signals::common::Common;
use veloid_core::bicycle::Bike;
use veloid_core::numerics::spline;

pub struct Delayed {
    pub road: Vec<f64>,
    /// First sample at which the rear wheel stands on road that the front wheel has met.
    pub known_from: usize,
}

/// u_r(t) = u_f(t') where x(t') = x(t) - L, x the distance ridden (trapezoids of v) and L the
/// wheelbase. Before that the first height is held.
pub fn delayed(front: &[f64], common: &mut Common<'_>, bike: &Bike) -> Result<Delayed, ReadError> {
    let needed = |missing| ReadError::from(Problem::RearRoadMissing { missing });
    let wheelbase = bike.wheelbase();
    let speed = common.take(Channel::Speed);
    let (wheelbase, speed) = match (wheelbase, speed) {
        (Some(wheelbase), Some(speed)) => (wheelbase, speed),
        (None, Some(_)) => {
            return Err(needed("the wheelbase (l_front_m and l_rear_m of the bike)"));
        }
        (Some(_), None) => return Err(needed("the speed (a column v)")),
        (None, None) => {
            return Err(needed(
                "the speed (a column v) and the wheelbase of the bike",
            ));
        }
    };
    let step = common.grid.step_s;
    let delayed = by_distance(front, &speed, step, wheelbase);
    common.put(Channel::Speed, speed);
    let delayed = delayed.ok_or_else(|| {
        common.blame(
            Channel::Speed,
            Problem::RearRoadMissing {
                missing: "a ride longer than the wheelbase (by the column v)",
            },
        )
    })?;
    common.warn(format!(
        "u_r was computed from u_f, delayed by {wheelbase:.3} m at the speed v; unknown for the first {:.3} s",
        delayed.known_from as f64 * step
    ));
    Ok(delayed)
}

/// Distance ridden (m) at every sample: trapezoids of the speed, no faster than forward.
pub fn distance(speed: &[f64], step_s: f64) -> Vec<f64> {
    let mut ridden = Vec::with_capacity(speed.len());
    let mut x = 0.0;
    for (i, v) in speed.iter().enumerate() {
        if i > 0 {
            x += 0.5 * step_s * (v.max(0.0) + speed[i - 1].max(0.0));
        }
        ridden.push(x);
    }
    ridden
}

fn by_distance(front: &[f64], speed: &[f64], step_s: f64, wheelbase_m: f64) -> Option<Delayed> {
    let slopes = spline::slopes(front, step_s);
    let ridden = distance(speed, step_s);
    let known_from = ridden.iter().position(|x| *x >= wheelbase_m)?;
    let mut i = 0;
    let road = (ridden.iter())
        .map(|x| {
            let behind = x - wheelbase_m;
            if behind <= 0.0 {
                return front[0];
            }
            while i + 2 < ridden.len() && ridden[i + 1] < behind {
                i += 1;
            }
            let width = ridden[i + 1] - ridden[i];
            let s = if width > 0.0 {
                ((behind - ridden[i]) / width).min(1.0)
            } else {
                1.0
            };
            let [c0, c1, c2, c3] =
                spline::cubic(front[i], front[i + 1], slopes[i], slopes[i + 1], step_s);
            c0 + s * (c1 + s * (c2 + s * c3))
        })
        .collect();
    Some(Delayed { road, known_from })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// A road of 0.7 m waves, ridden at v(t) = 4 + sin t.
    #[test]
    fn the_rear_wheel_meets_the_same_road() {
        let (step, wheelbase) = (0.005, 1.1);
        let time = |i: usize| i as f64 * step;
        let ridden = |t: f64| 4.0 * t + 1.0 - t.cos();
        let road = |x: f64| 0.01 * (x / 0.7).sin();
        let speed: Vec<f64> = (0..4000).map(|i| 4.0 + time(i).sin()).collect();
        let front: Vec<f64> = (0..4000).map(|i| road(ridden(time(i)))).collect();
        let rear = by_distance(&front, &speed, step, wheelbase).unwrap();
        assert!((time(rear.known_from) - 0.27).abs() < 0.02);
        for i in rear.known_from + 3..4000 {
            let truth = road(ridden(time(i)) - wheelbase);
            assert!(
                (rear.road[i] - truth).abs() < 1e-6,
                "{i}: {} is not {truth}",
                rear.road[i]
            );
        }
    }

    #[test]
    fn standing_still_has_no_rear_road() {
        assert!(by_distance(&[0.0; 100], &[0.0; 100], 0.01, 1.0).is_none());
        assert!(by_distance(&[0.0; 100], &[f64::MAX; 100], 0.01, 1.0).is_some());
    }
}
