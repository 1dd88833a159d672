//! The band that an axle's channels are kept in where sensors do not reach further.

use std::f64::consts::TAU;

use serde::{Deserialize, Serialize};

use veloid_core::numerics::filter::{Beyond, filter};

/// Limits (Hz); a missing one does not limit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Band {
    /// Lowest frequency (Hz).
    pub low_hz: Option<f64>,
    /// Highest frequency (Hz).
    pub high_hz: Option<f64>,
}

impl Band {
    /// Whether it has no limit.
    pub fn is_everything(&self) -> bool {
        self.low_hz.is_none() && self.high_hz.is_none()
    }

    /// Whether a frequency (Hz) lies in the band.
    pub fn contains(&self, hz: f64) -> bool {
        self.low_hz.is_none_or(|low| hz >= low) && self.high_hz.is_none_or(|high| hz <= high)
    }

    /// The narrower of both at either end.
    pub fn within(&self, other: Band) -> Band {
        let pick = |a: Option<f64>, b: Option<f64>, f: fn(f64, f64) -> f64| match (a, b) {
            (Some(a), Some(b)) => Some(f(a, b)),
            (a, b) => a.or(b),
        };
        Band {
            low_hz: pick(self.low_hz, other.low_hz, f64::max),
            high_hz: pick(self.high_hz, other.high_hz, f64::min),
        }
    }

    /// Squared Butterworth magnitudes: of second order below, of eighth above.
    fn gain(&self, hz: f64) -> f64 {
        let high_pass = self.low_hz.map_or(1.0, |low| {
            let x = (hz / low).powi(4);
            x / (1.0 + x)
        });
        let low_pass = self
            .high_hz
            .map_or(1.0, |high| 1.0 / (1.0 + (hz / high).powi(16)));
        high_pass * low_pass
    }

    /// How long (s) a disturbance is felt on either side of it.
    pub fn memory_s(&self) -> f64 {
        self.low_hz.map_or(0.0, |low| 1.0 / low) + self.high_hz.map_or(0.0, |high| 1.0 / high)
    }

    /// How long (s) a disturbance shorter than the band resolves is seen on either side of it.
    pub fn resolution_s(&self) -> f64 {
        self.high_hz.map_or(0.0, |high| 1.0 / high)
    }

    /// What of `values` lies in the band; no phase is added.
    pub fn keep(&self, values: &[f64], rate_hz: f64) -> Vec<f64> {
        let margin = 4.0 * self.memory_s();
        filter(values, rate_hz, margin, Beyond::Points, |hz| self.gain(hz))
    }

    /// Displacement from acceleration, -1/omega^2 within the band.
    pub fn integrate_twice(&self, values: &[f64], rate_hz: f64) -> Vec<f64> {
        let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
        let centred: Vec<f64> = values.iter().map(|v| v - mean).collect();
        let margin = 4.0 * self.memory_s();
        filter(&centred, rate_hz, margin, Beyond::Mirror, |hz| {
            if hz > 0.0 {
                -self.gain(hz) / (TAU * hz).powi(2)
            } else {
                0.0
            }
        })
    }

    /// The band in words.
    pub fn describe(&self) -> String {
        match (self.low_hz, self.high_hz) {
            (Some(low), Some(high)) => format!("only {low:.2} Hz to {high:.2} Hz"),
            (None, Some(high)) => format!("only frequencies below {high:.2} Hz"),
            (Some(low), None) => format!("only frequencies above {low:.2} Hz"),
            (None, None) => "all frequencies, up to a constant".to_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BAND: Band = Band {
        low_hz: Some(0.5),
        high_hz: Some(12.6),
    };

    /// z = sum of sines within the band, on 60 s at 100 Hz.
    fn motion(order: i32) -> Vec<f64> {
        let lines = [
            (1.7, 3e-3, 0.4),
            (4.1, 2e-3, 1.0),
            (7.3, 1e-3, 2.0),
            (9.7, 5e-4, 3.0),
        ];
        let at = |t: f64| {
            lines.iter().map(move |(f, a, p)| {
                let w = TAU * f;
                let s = (w * t + p).sin();
                if order == 0 { a * s } else { -w * w * a * s }
            })
        };
        (0..6000).map(|i| at(i as f64 * 0.01).sum()).collect()
    }

    #[test]
    fn integration_is_exact_within_the_band_and_its_ends_settle_in_its_memory() {
        let bias = 9.81;
        let a: Vec<f64> = motion(2).iter().map(|a| a + bias).collect();
        let (z, made) = (
            BAND.keep(&motion(0), 100.0),
            BAND.integrate_twice(&a, 100.0),
        );
        let margin = (BAND.memory_s() * 100.0) as usize;
        let worst = |from: usize, to: usize| {
            (from..to)
                .map(|i| (z[i] - made[i]).abs())
                .fold(0.0, f64::max)
        };
        assert!(worst(1000, 5000) < 1e-6, "middle: {}", worst(1000, 5000));
        assert!(
            worst(margin, 6000 - margin) < 2e-4,
            "after the ends: {}",
            worst(margin, 6000 - margin)
        );
    }

    #[test]
    fn nothing_else_passes() {
        let drift: Vec<f64> = (0..6000).map(|i| 1.0 + 1e-3 * i as f64).collect();
        let left = BAND.keep(&drift, 100.0);
        assert!(left[500..5500].iter().all(|v| v.abs() < 1e-3));
        let fast: Vec<f64> = (0..6000).map(|i| (i as f64 * TAU * 0.2).sin()).collect();
        assert!(
            BAND.keep(&fast, 100.0)[500..5500]
                .iter()
                .all(|v| v.abs() < 1e-3)
        );
    }

    #[test]
    fn bands_narrow_each_other() {
        let wide = Band {
            low_hz: None,
            high_hz: Some(5.0),
        };
        assert_eq!(
            BAND.within(wide),
            Band {
                low_hz: Some(0.5),
                high_hz: Some(5.0)
            }
        );
    }
}
