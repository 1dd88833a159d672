//! Speed and cadence as smooth functions of time.

use crate::chance::Chance;

/// A slowly varying quantity: a base, sines and smooth steps. Its derivative is exact.
#[derive(Clone, Debug, Default)]
pub struct Profile {
    pub base: f64,
    /// (amplitude, angular frequency rad/s, phase rad)
    pub waves: Vec<(f64, f64, f64)>,
    /// (start s, duration s, change)
    pub steps: Vec<(f64, f64, f64)>,
}

impl Profile {
    pub fn value(&self, t: f64) -> f64 {
        let waves: f64 = self
            .waves
            .iter()
            .map(|&(a, w, p)| a * (w * t + p).sin())
            .sum();
        let steps: f64 = self
            .steps
            .iter()
            .map(|&(at, lasts, change)| {
                let s = ((t - at) / lasts).clamp(0.0, 1.0);
                change * s * s * (3.0 - 2.0 * s)
            })
            .sum();
        self.base + waves + steps
    }

    pub fn rate(&self, t: f64) -> f64 {
        let waves: f64 = self
            .waves
            .iter()
            .map(|&(a, w, p)| a * w * (w * t + p).cos())
            .sum();
        let steps: f64 = self
            .steps
            .iter()
            .map(|&(at, lasts, change)| {
                let s = ((t - at) / lasts).clamp(0.0, 1.0);
                change / lasts * 6.0 * s * (1.0 - s)
            })
            .sum();
        waves + steps
    }

    /// Slow wobble: three sines of 0.02-0.2 Hz, together about `size` (rms).
    pub fn wobble(base: f64, size: f64, chance: &mut Chance) -> Self {
        let waves = (0..3)
            .map(|_| {
                (
                    size * chance.uniform(0.5, 1.1),
                    std::f64::consts::TAU * chance.log_uniform(0.02, 0.2),
                    chance.phase(),
                )
            })
            .collect();
        Self {
            base,
            waves,
            steps: Vec::new(),
        }
    }

    /// Adds accelerations and brakings of about `acceleration` (m/s^2) that keep the value between `low` and `high`.
    pub fn with_steps(
        mut self,
        until_s: f64,
        acceleration: f64,
        low: f64,
        high: f64,
        chance: &mut Chance,
    ) -> Self {
        let mut at = -1.0;
        let mut level = self.base;
        while at < until_s {
            let target = if level > (low + high) / 2.0 {
                chance.uniform(low, low + 0.35 * (high - low))
            } else {
                chance.uniform(high - 0.35 * (high - low), high)
            };
            let change = target - level;
            // The smoothstep's mean rate is two thirds of its peak.
            let lasts = (1.5 * change.abs() / (acceleration * chance.uniform(0.7, 1.2))).max(0.8);
            self.steps.push((at, lasts, change));
            level = target;
            at += lasts + chance.uniform(0.5, 3.0);
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rate_is_the_derivative() {
        let chance = &mut Chance::new(3, 0);
        let speed = Profile::wobble(5.0, 0.2, chance).with_steps(60.0, 1.5, 3.0, 8.0, chance);
        for i in 0..600 {
            let (t, e) = (0.1 * i as f64 + 0.013, 1e-5);
            let numeric = (speed.value(t + e) - speed.value(t - e)) / (2.0 * e);
            assert!((numeric - speed.rate(t)).abs() < 1e-4, "at {t} s");
            assert!(speed.value(t) > 1.5 && speed.value(t) < 9.5);
        }
    }
}
