//! The ride as models are fitted to it, for exports.

use std::borrow::Cow;

use super::prepare::slower;
use veloid_model::dataset::speed;
use veloid_ride::Ride;

/// The ride on the samples of the diagnosis, and the rate of its speed (m/s^2) there, where it has one.
pub fn as_diagnosed(ride: &Ride) -> (Cow<'_, Ride>, Option<Vec<f64>>) {
    let ride = slower(ride).map_or(Cow::Borrowed(ride), Cow::Owned);
    let rate = ride.speed.as_ref();
    let rate = rate.map(|speed| speed::rate(speed, ride.step_s));
    (ride, rate)
}

#[cfg(test)]
mod tests {
    use super::*;
    use veloid_methods::simulate::simulated_ride::SimulatedRide;

    #[test]
    fn a_ride_that_is_sampled_too_often_is_thinned() {
        let simulated = SimulatedRide {
            duration_s: 20.0,
            ..SimulatedRide::default()
        };
        let ride = simulated.ride();
        let (same, rate) = as_diagnosed(&ride);
        assert_eq!(same.samples, ride.samples);
        assert_eq!(rate.map(|rate| rate.len()), Some(ride.samples));
        let often = SimulatedRide {
            rate_hz: 4000.0,
            ..simulated
        };
        let often = often.ride();
        assert!(as_diagnosed(&often).0.samples < often.samples);
    }
}
