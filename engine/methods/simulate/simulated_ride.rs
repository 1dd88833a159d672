//! Whole simulated rides of the plain model, with everything known: for tests, for `veloid simulate`
//! and for the figures in the documentation.

use std::f64::consts::TAU;

use serde::{Deserialize, Serialize};

use super::linear::{Input, simulate};
use super::road::{Bump, Profile, Roughness};
use veloid_core::EngineError;
use veloid_core::bicycle::{Axle, PerAxle};
use veloid_core::numerics::random::Normal;
use veloid_core::plant::PlantRef;
use veloid_core::settings::within;
use veloid_ride::{AxleRecord, RATES_HZ, Ride, RideSummary};

/// One axle of the simulated bicycle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Spring {
    /// Mass that the wheel carries (kg).
    pub mass_kg: f64,
    /// Stiffness (N/m).
    pub k_n_m: f64,
    /// Damping (N s/m).
    pub b_n_s_m: f64,
}

/// What excites the bicycle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Excitation {
    /// Riding over a road with bumps, rough or else flat.
    Road {
        /// None: flat.
        roughness: Option<Roughness>,
        /// Laid over it.
        bumps: Vec<Bump>,
    },
    /// A sine force on each axle mass whose frequency rises evenly; the ground is at rest.
    Shaker {
        /// Of the force (N).
        amplitude_n: f64,
        /// Frequency at the start (Hz).
        from_hz: f64,
        /// Frequency at the end (Hz).
        to_hz: f64,
    },
    /// Let go from a displaced position; the ground is at rest.
    Release {
        /// From here (m).
        displacement_m: f64,
    },
}

/// The speed swings around its mean: V (1 + share sin(2 pi t / period)).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpeedChange {
    /// Of the mean speed (-0.95 to 0.95).
    pub share: f64,
    /// Of a swing (s).
    pub period_s: f64,
}

/// A ride to simulate. The default is the paper's bicycle for a minute on an ISO class B road.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SimulatedRide {
    /// Length of the ride (s).
    pub duration_s: f64,
    /// Sampling rate (Hz).
    pub rate_hz: f64,
    /// Mean speed (m/s).
    pub speed_m_s: f64,
    /// How the speed swings, where it does.
    pub speed_change: Option<SpeedChange>,
    /// Steady pedalling (revolutions per minute).
    pub cadence_rpm: Option<f64>,
    /// By how much the rear wheel is behind (m).
    pub wheelbase_m: f64,
    /// None: not recorded.
    pub front: Option<Spring>,
    /// None: not recorded.
    pub rear: Option<Spring>,
    /// What moves the axles.
    pub excitation: Excitation,
    /// Highest frequency (Hz) of a rough road where the ride is fastest, up to [`FULL_BAND`] of the rate. None: a fifth of the rate, and
    /// at most 4 cycles/m.
    pub road_to_hz: Option<f64>,
    /// By how much the rear wheel runs to the side of the front one's track (m), on a road that is rough alike in all directions.
    pub track_offset_m: f64,
    /// Standard deviation of the white noise on z (m).
    pub noise_displacement_m: f64,
    /// Standard deviation of the white noise on u (m).
    pub noise_road_m: f64,
    /// Seed of the road and of the noise.
    pub seed: u64,
}

impl Default for SimulatedRide {
    fn default() -> Self {
        let spring = |mass_kg| {
            Some(Spring {
                mass_kg,
                k_n_m: 110e3,
                b_n_s_m: 1150.0,
            })
        };
        Self {
            duration_s: 60.0,
            rate_hz: 100.0,
            speed_m_s: 5.0,
            speed_change: None,
            cadence_rpm: None,
            wheelbase_m: 1.101,
            front: spring(23.0),
            rear: spring(63.0),
            excitation: Excitation::Road {
                roughness: Some(Roughness::B),
                bumps: Vec::new(),
            },
            road_to_hz: None,
            track_offset_m: 0.0,
            noise_displacement_m: 0.0,
            noise_road_m: 0.0,
            seed: 1,
        }
    }
}

/// Share of the sampling rate up to which a road can reach: the sensors have no low-pass.
pub const FULL_BAND: f64 = 0.45;

/// Exact steps of the model within one sample interval; road and force are splines through them.
pub const FINE: usize = 8;

/// What drives one axle, and how it moves, without noise.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Motion {
    /// u (m).
    pub road: Vec<f64>,
    /// F (N).
    pub force: Option<Vec<f64>>,
    /// z (m).
    pub displacement: Vec<f64>,
    /// z' (m/s).
    pub velocity: Vec<f64>,
    /// z'' (m/s^2).
    pub acceleration: Vec<f64>,
}

impl Motion {
    fn at_samples(&self) -> Self {
        let thin = |x: &Vec<f64>| x.iter().step_by(FINE).copied().collect();
        Self {
            road: thin(&self.road),
            force: self.force.as_ref().map(thin),
            displacement: thin(&self.displacement),
            velocity: thin(&self.velocity),
            acceleration: thin(&self.acceleration),
        }
    }
}

/// Samples that one simulation may write.
const MOST_SAMPLES: f64 = 1e7;

impl SimulatedRide {
    /// Rejects what cannot be simulated.
    ///
    /// # Errors
    /// A number that is out of range.
    pub fn validate(&self) -> Result<(), EngineError> {
        let (least, most) = (f64::MIN_POSITIVE, f64::MAX);
        within("rate", self.rate_hz, *RATES_HZ.start(), *RATES_HZ.end())?;
        within(
            "duration x rate",
            self.duration_s * self.rate_hz,
            10.0,
            MOST_SAMPLES,
        )?;
        for spring in [self.front, self.rear].into_iter().flatten() {
            within("mass", spring.mass_kg, least, most)?;
            within("stiffness", spring.k_n_m, -most, most)?;
            within("damping", spring.b_n_s_m, -most, most)?;
        }
        within("wheelbase", self.wheelbase_m, 0.0, 100.0)?;
        if let Some(change) = self.speed_change {
            within("share of the speed change", change.share, -0.95, 0.95)?;
            within("period of the speed change", change.period_s, 0.1, most)?;
        }
        if let Some(cadence) = self.cadence_rpm {
            within("cadence", cadence, 1.0, 300.0)?;
        }
        if let Some(hz) = self.road_to_hz {
            within(
                "highest frequency of the road",
                hz,
                0.1,
                FULL_BAND * self.rate_hz,
            )?;
        }
        within("offset of the tracks", self.track_offset_m, 0.0, 10.0)?;
        within("noise", self.noise_displacement_m, 0.0, most)?;
        within("road noise", self.noise_road_m, 0.0, most)?;
        match &self.excitation {
            Excitation::Road { bumps, .. } => {
                within("speed", self.speed_m_s, 0.1, 100.0)?;
                bumps.iter().try_for_each(|bump| {
                    within("place of a bump", bump.at_m, 0.0, most)?;
                    within("length of a bump", bump.length_m, 1e-3, most)?;
                    within("height of a bump", bump.height_m, -most, most)
                })
            }
            Excitation::Shaker {
                amplitude_n,
                from_hz,
                to_hz,
            } => {
                within("force of the shaker", *amplitude_n, -most, most)?;
                // Half the sampling rate is the most that its samples can show.
                within("frequency of the shaker", *from_hz, 0.0, 0.5 * self.rate_hz)?;
                within("frequency of the shaker", *to_hz, 0.0, 0.5 * self.rate_hz)
            }
            Excitation::Release { displacement_m } => {
                within("release", *displacement_m, -most, most)
            }
        }
    }

    /// As many as a logger writes.
    pub fn samples(&self) -> usize {
        (self.duration_s * self.rate_hz).round() as usize + 1
    }

    fn spring(&self, axle: Axle) -> Option<Spring> {
        match axle {
            Axle::Front => self.front,
            Axle::Rear => self.rear,
        }
    }

    /// Distance ridden by the front wheel (m) and speed (m/s) at time `t` (s).
    fn ridden(&self, t: f64) -> (f64, f64) {
        let v = self.speed_m_s;
        let Some(SpeedChange { share, period_s }) = self.speed_change else {
            return (v * t, v);
        };
        let (sin, cos) = (TAU * t / period_s).sin_cos();
        (
            v * (t + share * period_s / TAU * (1.0 - cos)),
            v * (1.0 + share * sin),
        )
    }

    /// The motion without noise, at the samples.
    pub fn motion(&self) -> PerAxle<Motion> {
        self.fine_motion().map(|_, m| m.at_samples())
    }

    fn fine_motion(&self) -> PerAxle<Motion> {
        let fine_step = 1.0 / (self.rate_hz * FINE as f64);
        let samples = (self.samples() - 1) * FINE + 1;
        let front = self.profile(fine_step, 0.0);
        let beside =
            (self.track_offset_m > 0.0).then(|| self.profile(fine_step, self.track_offset_m));
        let mut motion = PerAxle::default();
        for axle in Axle::BOTH {
            let Some(spring) = self.spring(axle) else {
                continue;
            };
            let (behind, profile) = match axle {
                Axle::Front => (0.0, &front),
                Axle::Rear => (self.wheelbase_m, beside.as_ref().unwrap_or(&front)),
            };
            let road: Vec<f64> = (0..samples)
                .map(|i| profile.height(self.ridden(i as f64 * fine_step).0 - behind))
                .collect();
            let force = self.force(samples, fine_step);
            motion.set(axle, self.run(spring, &road, force, fine_step));
        }
        motion
    }

    fn profile(&self, fine_step: f64, beside_m: f64) -> Profile {
        match &self.excitation {
            Excitation::Road { roughness, bumps } => {
                let (length, _) = self.ridden(self.duration_s);
                let swing = self.speed_change.map_or(0.0, |change| change.share.abs());
                let fastest = self.speed_m_s * (1.0 + swing);
                let highest = match self.road_to_hz {
                    Some(hz) => hz / fastest,
                    None => (0.2 * self.rate_hz / fastest).min(4.0),
                };
                let spacing = self.speed_m_s * fine_step;
                let road = match roughness {
                    Some(class) if beside_m > 0.0 => {
                        Profile::beside(*class, length, spacing, highest, self.seed, beside_m)
                    }
                    Some(class) => Profile::iso(*class, length, spacing, highest, self.seed),
                    None => Profile::flat(length, spacing),
                };
                road.with_bumps(bumps)
            }
            Excitation::Shaker { .. } | Excitation::Release { .. } => Profile::flat(1.0, 0.1),
        }
    }

    fn force(&self, samples: usize, fine_step: f64) -> Option<Vec<f64>> {
        let Excitation::Shaker {
            amplitude_n,
            from_hz,
            to_hz,
        } = self.excitation
        else {
            return None;
        };
        let rise = (to_hz - from_hz) / self.duration_s;
        Some(
            (0..samples)
                .map(|i| {
                    let t = i as f64 * fine_step;
                    let cycles = from_hz * t + 0.5 * rise * t * t;
                    amplitude_n * (TAU * cycles).sin()
                })
                .collect(),
        )
    }

    fn run(&self, spring: Spring, road: &[f64], force: Option<Vec<f64>>, fine_step: f64) -> Motion {
        let start = match self.excitation {
            Excitation::Release { displacement_m } => displacement_m,
            _ => 0.0,
        };
        let (kappa, beta, per_mass) = (
            spring.k_n_m / spring.mass_kg,
            spring.b_n_s_m / spring.mass_kg,
            1.0 / spring.mass_kg,
        );
        let input = Input::new(road, force.as_deref(), fine_step);
        let (z, v) = simulate(&input, kappa, beta, per_mass, 0.0, [start, 0.0]);
        let acceleration = (0..z.len())
            .map(|i| {
                kappa * (road[i] - z[i])
                    + beta * (input.road_slope[i] - v[i])
                    + per_mass * force.as_ref().map_or(0.0, |f| f[i])
            })
            .collect();
        Motion {
            road: input.road,
            force,
            displacement: z,
            velocity: v,
            acceleration,
        }
    }

    /// The ride as it would be recorded.
    pub fn ride(&self) -> Ride {
        self.recorded(&self.fine())
    }

    /// The ride at every step of the simulation, without noise.
    pub fn fine(&self) -> Ride {
        let mut axles = PerAxle::default();
        let motion = self.fine_motion();
        for (axle, m) in [(Axle::Front, motion.front), (Axle::Rear, motion.rear)] {
            let Some(m) = m else { continue };
            axles.set(
                axle,
                AxleRecord {
                    valid: vec![true; m.road.len()],
                    road: m.road,
                    force: m.force,
                    displacement: m.displacement,
                    acceleration: None,
                    prescribed: false,
                    plant: PlantRef::default(),
                    band: None,
                },
            );
        }
        self.logged(axles, FINE)
    }

    /// What a logger makes of a fine ride: its own rate, its own noise.
    pub fn recorded(&self, fine: &Ride) -> Ride {
        let mut noise = Normal::new(self.seed.wrapping_add(0x6e6f_6973_6500));
        let thin = |x: &[f64]| x.iter().step_by(FINE).copied().collect::<Vec<_>>();
        let mut noisy = |clean: &[f64], size: f64| -> Vec<f64> {
            let clean = clean.iter().step_by(FINE);
            clean.map(|x| x + size * noise.draw()).collect()
        };
        let axles = fine.axles.map(|_, r| AxleRecord {
            road: match self.excitation {
                Excitation::Road { .. } => noisy(&r.road, self.noise_road_m),
                _ => thin(&r.road),
            },
            force: r.force.as_deref().map(thin),
            displacement: noisy(&r.displacement, self.noise_displacement_m),
            acceleration: None,
            valid: vec![true; self.samples()],
            prescribed: false,
            plant: PlantRef::default(),
            band: None,
        });
        self.logged(axles, 1)
    }

    /// A ride of these records, `per_sample` times as often as the simulated ride's rate.
    fn logged(&self, axles: PerAxle<AxleRecord>, per_sample: usize) -> Ride {
        let samples = (self.samples() - 1) * per_sample + 1;
        let rate_hz = self.rate_hz * per_sample as f64;
        let speed = |i: usize| self.ridden(i as f64 / rate_hz).1;
        Ride {
            start_s: 0.0,
            step_s: 1.0 / rate_hz,
            samples,
            axles,
            speed: matches!(self.excitation, Excitation::Road { .. })
                .then(|| (0..samples).map(speed).collect()),
            cadence: self.cadence_rpm.map(|cadence| vec![cadence; samples]),
            summary: RideSummary {
                samples,
                rows: samples,
                duration_s: self.duration_s,
                rate_hz,
                ..RideSummary::default()
            },
            ..Ride::default()
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn rear_meets_the_road_one_wheelbase_later() {
        let simulated_ride = SimulatedRide {
            speed_m_s: 11.01,
            duration_s: 5.0,
            ..SimulatedRide::default()
        };
        let m = simulated_ride.motion();
        let (f, r) = (m.front.unwrap(), m.rear.unwrap());
        for i in 0..400 {
            assert!((f.road[i] - r.road[i + 10]).abs() < 1e-9);
        }
    }

    #[test]
    fn motion_obeys_the_model() {
        let simulated_ride = SimulatedRide {
            duration_s: 10.0,
            rate_hz: 1000.0,
            ..SimulatedRide::default()
        };
        let m = simulated_ride.motion().front.unwrap();
        for i in 1..m.displacement.len() - 1 {
            let v = (m.displacement[i + 1] - m.displacement[i - 1]) * 500.0;
            let a = (m.velocity[i + 1] - m.velocity[i - 1]) * 500.0;
            assert!((v - m.velocity[i]).abs() < 2e-3);
            assert!((a - m.acceleration[i]).abs() < 0.5);
        }
    }

    #[test]
    fn noise_is_as_large_as_asked() {
        let quiet = SimulatedRide::default();
        let noisy = SimulatedRide {
            noise_displacement_m: 5e-5,
            ..quiet.clone()
        };
        let (a, b) = (
            quiet.ride().axles.rear.unwrap(),
            noisy.ride().axles.rear.unwrap(),
        );
        let n = a.displacement.len() as f64;
        let difference = a
            .displacement
            .iter()
            .zip(&b.displacement)
            .map(|(a, b)| b - a);
        let rms = (difference.map(|d| d * d).sum::<f64>() / n).sqrt();
        assert!((rms / 5e-5 - 1.0).abs() < 0.03, "{rms}");
        assert_eq!(a.road, b.road);
    }
}
