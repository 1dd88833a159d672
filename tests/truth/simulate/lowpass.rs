//! A logger's anti-alias filter: Butterworth's low-pass of fourth order.

use std::f64::consts::PI;

/// Two sections of second order in a row, each by the bilinear transform.
pub struct LowPass([Section; 2]);

/// y_i = b0 (x_i + 2 x_(i-1) + x_(i-2)) - a1 y_(i-1) - a2 y_(i-2).
struct Section {
    b0: f64,
    a1: f64,
    a2: f64,
}

impl LowPass {
    /// Half the power passes at `cut_hz`; values come at `rate_hz`.
    pub fn new(cut_hz: f64, rate_hz: f64) -> Self {
        let k = (PI * cut_hz / rate_hz).tan();
        Self([1.0, 3.0].map(|odd| {
            let damping = 2.0 * (odd * PI / 8.0).cos() * k;
            let a0 = 1.0 + damping + k * k;
            Section {
                b0: k * k / a0,
                a1: 2.0 * (k * k - 1.0) / a0,
                a2: (1.0 - damping + k * k) / a0,
            }
        }))
    }

    /// From rest.
    pub fn filtered(&self, values: &[f64]) -> Vec<f64> {
        let [first, second] = &self.0;
        second.filtered(&first.filtered(values))
    }
}

impl Section {
    fn filtered(&self, values: &[f64]) -> Vec<f64> {
        let (mut x, mut y) = ([0.0; 2], [0.0; 2]);
        let one = |&now: &f64| {
            let out = self.b0 * (now + 2.0 * x[0] + x[1]) - self.a1 * y[0] - self.a2 * y[1];
            (x, y) = ([now, x[0]], [out, y[0]]);
            out
        };
        values.iter().map(one).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Amplitude of a sine that has passed a filter of 40 Hz.
    fn passed(hz: f64) -> f64 {
        let sine: Vec<f64> = (0..8000)
            .map(|i| (2.0 * PI * hz * i as f64 / 4000.0).sin())
            .collect();
        let out = LowPass::new(40.0, 4000.0).filtered(&sine);
        let power = out[4000..].iter().map(|y| y * y).sum::<f64>() / 4000.0;
        (2.0 * power).sqrt()
    }

    #[test]
    fn it_passes_what_butterworth_does() {
        for hz in [5.0_f64, 20.0, 40.0, 80.0] {
            let exact = 1.0 / (1.0 + (hz / 40.0).powi(8)).sqrt();
            assert!((passed(hz) - exact).abs() < 2e-3, "{hz} Hz: {}", passed(hz));
        }
    }
}
