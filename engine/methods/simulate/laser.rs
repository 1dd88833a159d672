//! A laser that measures an axle's height over the road, on a logger whose clock is its own.

use serde::Serialize;

use super::simulated_ride::SimulatedRide;
use veloid_core::bicycle::Axle;
use veloid_core::numerics::random::Normal;
use veloid_core::numerics::spline::{cubic, slopes};
use veloid_core::settings::within;
use veloid_core::{EngineError, RideProblem};
use veloid_ride::{RATES_HZ, SensorKind, channel_name};

/// Where it is, and how its clock goes: at time t of the ride it reads t + offset + drift t.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Laser {
    /// Where it sits.
    pub axle: Axle,
    /// Standard deviation of its white noise (m).
    pub noise_m: f64,
    /// How late its clock is at the start (s).
    pub offset_s: f64,
    /// Parts per million.
    pub drift_ppm: f64,
    /// By its own clock (Hz).
    pub rate_hz: f64,
}

/// What it wrote: the deflection u - z (m) and its own time stamps (s).
pub struct Logged {
    /// Canonical name, `d_f` or `d_r`.
    pub channel: &'static str,
    /// By its own clock (s).
    pub stamps_s: Vec<f64>,
    /// As many (m).
    pub values: Vec<f64>,
}

/// Largest offset (s) and drift (ppm) of a clock that can be simulated.
const MOST: [f64; 2] = [1e3, 1e5];

impl Laser {
    /// What it writes on a ride.
    ///
    /// # Errors
    /// A number that is out of range; a ride without that axle.
    pub fn logged(&self, simulated_ride: &SimulatedRide) -> Result<Logged, EngineError> {
        within("noise of the laser", self.noise_m, 0.0, f64::MAX)?;
        within(
            "offset of the laser's clock (s)",
            self.offset_s,
            -MOST[0],
            MOST[0],
        )?;
        within(
            "drift of the laser's clock (ppm)",
            self.drift_ppm,
            -MOST[1],
            MOST[1],
        )?;
        within(
            "rate of the laser",
            self.rate_hz,
            *RATES_HZ.start(),
            *RATES_HZ.end(),
        )?;
        let fine = simulated_ride.fine();
        let record = fine.axles.get(self.axle).ok_or(EngineError::Ride {
            axle: self.axle,
            problem: RideProblem::OnlyLaser,
        })?;
        let d: Vec<f64> = (record.road.iter().zip(&record.displacement))
            .map(|(u, z)| u - z)
            .collect();
        let slope = slopes(&d, fine.step_s);
        let at = |t: f64| {
            let place = t / fine.step_s;
            let i = (place as usize).min(d.len() - 2);
            let c = cubic(d[i], d[i + 1], slope[i], slope[i + 1], fine.step_s);
            let s = place - i as f64;
            c[0] + s * (c[1] + s * (c[2] + s * c[3]))
        };
        let rate = 1.0 + 1e-6 * self.drift_ppm;
        let samples = (simulated_ride.duration_s * rate * self.rate_hz) as usize + 1;
        let own = |i: usize| i as f64 / self.rate_hz;
        let side = match self.axle {
            Axle::Front => 0,
            Axle::Rear => 1,
        };
        let mut noise = Normal::new(simulated_ride.seed.wrapping_add(0x6c61_7365_7200 + side));
        Ok(Logged {
            channel: channel_name(SensorKind::Deflection, self.axle),
            stamps_s: (0..samples).map(|i| self.offset_s + own(i)).collect(),
            values: (0..samples)
                .map(|i| at(own(i) / rate) + self.noise_m * noise.draw())
                .collect(),
        })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    const LASER: Laser = Laser {
        axle: Axle::Rear,
        noise_m: 0.0,
        offset_s: 0.0,
        drift_ppm: 0.0,
        rate_hz: 50.0,
    };

    #[test]
    fn it_measures_the_deflection_by_its_own_clock() {
        let simulated_ride = SimulatedRide {
            duration_s: 20.0,
            ..SimulatedRide::default()
        };
        let motion = simulated_ride.motion().rear.unwrap();
        let d = |i: usize| motion.road[i] - motion.displacement[i];
        let right = LASER.logged(&simulated_ride).unwrap();
        assert_eq!((right.channel, right.values.len()), ("d_r", 1001));
        assert!((0..1001).all(|i| (right.values[i] - d(2 * i)).abs() < 1e-12));
        // 5 % fast: after 10 s of the ride it reads 10.5 s and half a second more.
        let late = Laser {
            offset_s: 0.5,
            drift_ppm: 5e4,
            ..LASER
        };
        let late = late.logged(&simulated_ride).unwrap();
        let i = late
            .stamps_s
            .iter()
            .position(|t| (t - 11.0).abs() < 1e-9)
            .unwrap();
        assert!((late.values[i] - d(1000)).abs() < 1e-9);
        assert!((late.stamps_s.last().unwrap() - 21.5).abs() < 0.03);
    }

    #[test]
    fn what_cannot_be_is_refused() {
        let simulated_ride = SimulatedRide {
            rear: None,
            ..SimulatedRide::default()
        };
        assert!(LASER.logged(&simulated_ride).is_err());
        for wrong in [
            Laser {
                noise_m: -1.0,
                ..LASER
            },
            Laser {
                offset_s: f64::NAN,
                ..LASER
            },
            Laser {
                drift_ppm: -1e6,
                ..LASER
            },
            Laser {
                rate_hz: 0.0,
                ..LASER
            },
        ] {
            assert!(
                wrong.logged(&SimulatedRide::default()).is_err(),
                "{wrong:?}"
            );
        }
    }
}
