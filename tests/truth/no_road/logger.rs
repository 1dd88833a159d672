//! What two accelerometers and a speedometer write.

use crate::chance::Chance;
use crate::simulate::integrate::Motion;
use crate::simulate::lowpass::LowPass;
use crate::simulate::speed::Profile;

/// Where the filters before sampling cut, in parts of the rate.
const CUTS: f64 = 0.4;

#[derive(Clone, Debug)]
pub struct Logger {
    pub rate_hz: f64,
    /// White noise of the accelerometers, m/s^2.
    pub noise_m_s2: f64,
    /// Gain of the rear accelerometer.
    pub rear_gain: f64,
    /// How late the rear accelerometer is, s.
    pub rear_late_s: f64,
    /// What each accelerometer shows at rest, m/s^2.
    pub zero_m_s2: [f64; 2],
    /// Noise of the speed, which comes once a second, m/s.
    pub speed_m_s: f64,
}

impl Logger {
    pub fn draw(rate_hz: f64, chance: &mut Chance) -> Self {
        Self {
            rate_hz,
            noise_m_s2: chance.uniform(0.03, 0.1),
            rear_gain: 1.0 + 0.01 * chance.normal(),
            rear_late_s: 1e-3 * chance.normal(),
            zero_m_s2: [0, 1].map(|_| 0.1 * chance.normal()),
            speed_m_s: match chance.happens(1.0 / 3.0) {
                true => chance.uniform(0.05, 0.1),
                false => 0.03,
            },
        }
    }

    /// The acceleration of an axle at these times, from a sensor that is late by `late_s` more than the logger's.
    pub fn acceleration(
        &self,
        motion: &Motion,
        axle: usize,
        late_s: f64,
        times: &[f64],
        chance: &mut Chance,
    ) -> Vec<f64> {
        let passes = LowPass::new(CUTS * self.rate_hz, 1.0 / motion.step_s);
        let values = passes.filtered(&motion.z_acceleration[axle]);
        let (gain, own_late_s) = match axle {
            0 => (1.0, 0.0),
            _ => (self.rear_gain, self.rear_late_s),
        };
        let one = |t: &f64| {
            let at = (t - late_s - own_late_s - motion.start_s) / motion.step_s;
            gain * between(&values, at) + self.zero_m_s2[axle] + self.noise_m_s2 * chance.normal()
        };
        times.iter().map(one).collect()
    }

    /// The speed at these times, linear between what was logged each second.
    pub fn speed(&self, speed: &Profile, times: &[f64], chance: &mut Chance) -> Vec<f64> {
        let last = times.last().copied().unwrap_or(0.0).ceil() as usize + 1;
        let logged: Vec<f64> = (0..=last)
            .map(|s| speed.value(s as f64) + self.speed_m_s * chance.normal())
            .collect();
        let one = |t: &f64| {
            let (second, part) = (t.floor(), t.fract());
            let [a, b] = [0, 1].map(|i| logged[second as usize + i]);
            a + part * (b - a)
        };
        times.iter().map(one).collect()
    }
}

/// The cubic through the four values around a place.
fn between(values: &[f64], at: f64) -> f64 {
    let before = (at as usize).clamp(1, values.len() - 3);
    let s = at - before as f64;
    let [a, b, c, d] = [0, 1, 2, 3].map(|i| values[before + i - 1]);
    let weights = [
        -s * (s - 1.0) * (s - 2.0) / 6.0,
        (s + 1.0) * (s - 1.0) * (s - 2.0) / 2.0,
        -(s + 1.0) * s * (s - 2.0) / 2.0,
        (s + 1.0) * s * (s - 1.0) / 6.0,
    ];
    weights[0] * a + weights[1] * b + weights[2] * c + weights[3] * d
}

#[cfg(test)]
mod tests {
    use super::*;

    const TURN: f64 = std::f64::consts::TAU;

    fn exact(rate_hz: f64) -> Logger {
        Logger {
            rate_hz,
            noise_m_s2: 0.0,
            rear_gain: 1.02,
            rear_late_s: 2e-3,
            zero_m_s2: [0.0, 0.3],
            speed_m_s: 0.0,
        }
    }

    /// Both axles swing at 5 Hz.
    fn swinging() -> Motion {
        let a: Vec<f64> = (0..24_000)
            .map(|i| (TURN * 5.0 * (i as f64 / 4000.0 - 1.0)).sin())
            .collect();
        Motion {
            start_s: -1.0,
            step_s: 1.0 / 4000.0,
            z: Default::default(),
            z_rate: Default::default(),
            z_acceleration: [a.clone(), a],
        }
    }

    #[test]
    fn the_rear_is_late_and_loud_and_both_are_filtered() {
        let times: Vec<f64> = (0..400).map(|i| f64::from(i) / 100.0).collect();
        let (logger, motion, chance) = (exact(100.0), swinging(), &mut Chance::new(1, 0));
        let front = logger.acceleration(&motion, 0, 0.0, &times, chance);
        let late = logger.acceleration(&motion, 0, 10e-3, &times, chance);
        let rear = logger.acceleration(&motion, 1, 8e-3, &times, chance);
        for i in 100..399 {
            assert!((late[i + 1] - front[i]).abs() < 1e-6);
            assert!((rear[i + 1] - 0.3 - 1.02 * front[i]).abs() < 1e-6);
        }
        // Fourth-order Butterworth at 40 Hz is late by 2.613 / (2 pi 40) s.
        let at = TURN * 5.0 * (times[123] - 2.613 / (TURN * 40.0));
        assert!((front[123] - at.sin()).abs() < 5e-3, "{}", front[123]);
    }

    #[test]
    fn cubics_are_kept_between_samples() {
        let cubic = |x: f64| 1.0 + x - 0.5 * x * x + 0.1 * x * x * x;
        let values: Vec<f64> = (0..12).map(|i| cubic(f64::from(i))).collect();
        for at in [1.0, 4.3, 7.99, 9.2] {
            assert!((between(&values, at) - cubic(at)).abs() < 1e-9);
        }
    }

    #[test]
    fn speeds_are_linear_between_seconds() {
        let speed = Profile {
            base: 5.0,
            waves: vec![(1.0, TURN / 4.0, 0.0)],
            steps: Vec::new(),
        };
        let logged = exact(100.0).speed(&speed, &[0.0, 0.5, 1.0, 3.0], &mut Chance::new(1, 0));
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
        near(logged[0], 5.0);
        near(logged[1], 5.5);
        near(logged[2], 6.0);
        near(logged[3], 4.0);
    }
}
