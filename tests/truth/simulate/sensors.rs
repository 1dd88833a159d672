//! What the loggers write: noise, quantisation, jitter of the clock, and the sensor effects.

use super::effect::{Effect, Kind};
use super::integrate::Motion;
use crate::chance::Chance;

/// Imperfections of one logger.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sensors {
    /// White noise of z, m (standard deviation).
    pub white_m: f64,
    /// First-order autoregressive noise of z, m, and its correlation from sample to sample.
    pub coloured_m: f64,
    pub correlation: f64,
    /// Step of z, m; 0 writes every digit.
    pub quantum_m: f64,
    /// White noise of the road channels, m.
    pub road_m: f64,
    /// Standard deviation of the sampling instants, s.
    pub jitter_s: f64,
    /// All channels share the jitter (one logger), or each has its own.
    pub one_clock: bool,
}

/// One log, SI. Channels that the ride does not have are empty.
#[derive(Clone, Debug, Default)]
pub struct Log {
    pub t: Vec<f64>,
    pub u: [Vec<f64>; 2],
    pub z: [Vec<f64>; 2],
    pub force: [Vec<f64>; 2],
    pub a: [Vec<f64>; 2],
    pub v: Vec<f64>,
    pub cadence: Vec<f64>,
    /// Levels at which z saturates, m. No column of the file.
    pub limit_m: Option<[f64; 2]>,
}

impl Sensors {
    /// Sampling instants of a channel.
    pub fn instants(&self, nominal: &[f64], chance: &mut Chance) -> Vec<f64> {
        let limit = nominal.get(1).map_or(0.0, |dt| 0.45 * (dt - nominal[0]));
        nominal
            .iter()
            .map(|t| t + (self.jitter_s * chance.normal()).clamp(-limit, limit))
            .collect()
    }

    /// z of one axle as logged at the instants `at`, which the logger calls `nominal`.
    pub fn displacement(
        &self,
        motion: &Motion,
        axle: usize,
        effects: &[Effect],
        at: &[f64],
        nominal: &[f64],
        chance: &mut Chance,
    ) -> Vec<f64> {
        let chain = Chain::new(axle, effects, nominal.first().copied().unwrap_or(0.0));
        let fresh = (1.0 - self.correlation * self.correlation).sqrt();
        let mut coloured = self.coloured_m * chance.normal();
        at.iter()
            .zip(nominal)
            .map(|(&t, &logged)| {
                let noisy =
                    chain.reads(motion, t, logged) + self.white_m * chance.normal() + coloured;
                coloured = self.correlation * coloured + fresh * self.coloured_m * chance.normal();
                quantised(noisy, self.quantum_m)
            })
            .collect()
    }

    /// A road channel as logged.
    pub fn road(&self, height: impl Fn(f64) -> f64, at: &[f64], chance: &mut Chance) -> Vec<f64> {
        at.iter()
            .map(|&t| height(t) + self.road_m * chance.normal())
            .collect()
    }
}

/// The sensor effects of one axle: delay, gain, offset, drift.
pub struct Chain {
    axle: usize,
    delay_s: f64,
    gain: f64,
    offset_m: f64,
    drift_m_s: f64,
    first_s: f64,
}

impl Chain {
    /// `first_s`: time of the first sample, from which drift counts.
    pub fn new(axle: usize, effects: &[Effect], first_s: f64) -> Self {
        let find = |kind, otherwise| {
            effects
                .iter()
                .find(|e| e.kind == kind && e.axle.covers(axle))
                .map_or(otherwise, |e| e.values[0])
        };
        Self {
            axle,
            delay_s: find(Kind::SensorDelay, 0.0),
            gain: find(Kind::SensorGain, 1.0),
            offset_m: find(Kind::SensorOffset, 0.0),
            drift_m_s: find(Kind::SensorDrift, 0.0),
            first_s,
        }
    }

    /// z without noise, sampled at `t` and logged at `logged`.
    pub fn reads(&self, motion: &Motion, t: f64, logged: f64) -> f64 {
        self.gain * motion.position(self.axle, t - self.delay_s)
            + self.offset_m
            + self.drift_m_s * (logged - self.first_s)
    }
}

fn quantised(value: f64, quantum: f64) -> f64 {
    if quantum > 0.0 {
        (value / quantum).round() * quantum
    } else {
        value
    }
}

impl Log {
    /// Which axles moved: one that is not in a file rests.
    pub fn has(&self) -> [bool; 2] {
        self.z.each_ref().map(|z| z.iter().any(|z| *z != 0.0))
    }

    /// Takes an axle's channels away.
    pub fn leave_out(&mut self, axle: usize) {
        for channel in [&mut self.z, &mut self.u, &mut self.force, &mut self.a] {
            channel[axle].clear();
        }
    }

    /// Saturates each displacement at the level that `share` of its samples pass.
    pub fn clip(&mut self, share: f64) {
        let levels = self.z.each_ref().map(|z| {
            let mut sizes: Vec<f64> = z.iter().map(|z| z.abs()).collect();
            sizes.sort_by(f64::total_cmp);
            sizes[((1.0 - share) * (sizes.len() - 1) as f64) as usize]
        });
        for (z, level) in self.z.iter_mut().zip(levels) {
            z.iter_mut().for_each(|z| *z = z.clamp(-level, level));
        }
        self.limit_m = Some(levels);
    }

    /// The ride file of the contract.
    pub fn to_csv(&self) -> String {
        let mut columns: Vec<(&str, &Vec<f64>, usize)> = vec![("t", &self.t, 4)];
        let optional = [
            ("u_f", &self.u[0], 7),
            ("u_r", &self.u[1], 7),
            ("z_f", &self.z[0], 7),
            ("z_r", &self.z[1], 7),
            ("force_f", &self.force[0], 3),
            ("force_r", &self.force[1], 3),
            ("a_f", &self.a[0], 5),
            ("a_r", &self.a[1], 5),
            ("v", &self.v, 3),
            ("cadence", &self.cadence, 1),
        ];
        columns.extend(
            optional
                .into_iter()
                .filter(|(_, values, _)| !values.is_empty()),
        );
        let mut text: String = columns.iter().map(|c| c.0).collect::<Vec<_>>().join(",");
        text.push('\n');
        for row in 0..self.t.len() {
            for (i, (_, values, digits)) in columns.iter().enumerate() {
                let comma = if i == 0 { "" } else { "," };
                text += &format!("{comma}{:.digits$}", values[row]);
            }
            text.push('\n');
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coloured_noise_has_its_size_and_correlation() {
        let sensors = Sensors {
            coloured_m: 1e-4,
            correlation: 0.9,
            ..Sensors::default()
        };
        let at: Vec<f64> = (0..200_000).map(|i| 0.01 * i as f64).collect();
        let still = Motion {
            start_s: 0.0,
            step_s: 1.0,
            z: [vec![0.0; 2], vec![0.0; 2]],
            z_rate: [vec![0.0; 2], vec![0.0; 2]],
            z_acceleration: [vec![0.0; 2], vec![0.0; 2]],
        };
        let z = sensors.displacement(&still, 0, &[], &at, &at, &mut Chance::new(4, 0));
        let variance = z.iter().map(|x| x * x).sum::<f64>() / z.len() as f64;
        let lag = z.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / z.len() as f64;
        assert!((variance / 1e-8 - 1.0).abs() < 0.05, "{variance}");
        assert!((lag / variance - 0.9).abs() < 0.01, "{lag}");
    }

    #[test]
    fn csv_holds_only_the_channels_of_the_ride() {
        let log = Log {
            t: vec![0.0, 0.01],
            z: [vec![1e-3, 2e-3], vec![0.0, 0.0]],
            force: [vec![1.0, 2.0], vec![]],
            ..Log::default()
        };
        assert_eq!(
            log.to_csv(),
            "t,z_f,z_r,force_f\n0.0000,0.0010000,0.0000000,1.000\n0.0100,0.0020000,0.0000000,2.000\n"
        );
    }

    #[test]
    fn a_clipped_log_stays_within_its_levels() {
        let ramp = |slope: f64| (0..1000).map(|i| slope * (i as f64 - 500.0)).collect();
        let mut log = Log {
            z: [ramp(1e-5), ramp(2e-5)],
            ..Log::default()
        };
        log.clip(0.03);
        let limits = log.limit_m.unwrap_or_default();
        for (z, limit) in log.z.iter().zip(limits) {
            let at_limit = z.iter().filter(|z| z.abs() == limit).count();
            assert!((29..=32).contains(&at_limit), "{at_limit}");
        }
    }
}
