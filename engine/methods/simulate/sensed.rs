//! A simulated ride as two accelerometers and a speed sensor record it.

use super::simulated_ride::SimulatedRide;
use veloid_core::EngineError;
use veloid_core::bicycle::PerAxle;
use veloid_core::numerics::random::Normal;
use veloid_core::settings::within;
use veloid_ride::{Ride, SensorKind, SensorRecord};

impl SimulatedRide {
    /// The ride without road and displacement: accelerometers with white noise (m/s^2, standard deviation), and the speed.
    ///
    /// # Errors
    /// A number that is out of range.
    pub fn sensed(&self, noise: f64) -> Result<Ride, EngineError> {
        self.validate()?;
        self.accelerations(&self.motion().map(|_, m| m.acceleration.clone()), noise)
    }

    /// The same of axles that move otherwise: with these accelerations (m/s^2) at the logger's samples.
    ///
    /// # Errors
    /// A noise that is out of range.
    pub fn accelerations(
        &self,
        accelerations: &PerAxle<Vec<f64>>,
        noise: f64,
    ) -> Result<Ride, EngineError> {
        within("noise", noise, 0.0, f64::MAX)?;
        let mut ride = self.ride();
        let mut random = Normal::new(self.seed.wrapping_add(0x7365_6e73_6564));
        ride.axles = PerAxle::default();
        for (axle, values) in accelerations.iter() {
            let values: Vec<f64> = values.iter().map(|a| a + noise * random.draw()).collect();
            ride.sensors.push(SensorRecord {
                axle,
                kind: SensorKind::Acceleration,
                valid: vec![true; values.len()],
                values,
                rate_hz: self.rate_hz,
                first_s: ride.start_s,
            });
        }
        Ok(ride)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn sensors_record_the_motion_and_their_noise() {
        let simulated_ride = SimulatedRide {
            duration_s: 20.0,
            ..SimulatedRide::default()
        };
        let (quiet, noisy) = (
            simulated_ride.sensed(0.0).unwrap(),
            simulated_ride.sensed(0.1).unwrap(),
        );
        assert!(quiet.axles.front.is_none() && quiet.sensors.len() == 2);
        for ((_, motion), (quiet, noisy)) in
            (simulated_ride.motion().iter()).zip(quiet.sensors.iter().zip(&noisy.sensors))
        {
            assert_eq!(quiet.values, motion.acceleration);
            let off = quiet.values.iter().zip(&noisy.values);
            let squares: f64 = off.map(|(a, b)| (a - b).powi(2)).sum();
            let rms = (squares / quiet.values.len() as f64).sqrt();
            assert!((rms / 0.1 - 1.0).abs() < 0.05, "{rms}");
        }
    }
}
