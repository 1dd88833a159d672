//! k, B and m as an oscillator, with their errors.

use std::f64::consts::TAU;

use nalgebra::Matrix3;

use veloid_core::numerics::finite::std_error;
use veloid_report::Estimate;
use veloid_report::dynamics::Pole;

/// A mass on a spring and a damper.
#[derive(Clone, Debug)]
pub struct Oscillator {
    k: f64,
    b: f64,
    m: f64,
    /// Covariance of k (N/m), B (N s/m) and m (kg) with all that widens it; none where the fit gives no correlations.
    covariance: Option<Matrix3<f64>>,
}

impl Oscillator {
    /// Of an estimate with k above zero and a mass. `heavier` is how far k, B and m move together when a mass that is only known to
    /// within a standard deviation is that much larger: on a road in proportion, so that neither natural frequency nor damping ratio
    /// moves. Whatever else widens the standard errors keeps the correlation of the fit.
    pub fn of(e: &Estimate, heavier: [f64; 3]) -> Option<Self> {
        let (k, b, m) = (e.k_n_m, e.b_n_s_m, e.mass_kg);
        let own = |std: Option<f64>, by: f64| {
            std.map_or(0.0, |std| (std * std - by * by).max(0.0).sqrt())
        };
        let std = [
            own(e.k_std_n_m, heavier[0]),
            own(e.b_std_n_s_m, heavier[1]),
            e.mass_std_kg.unwrap_or(0.0),
        ];
        let covariance = e.covariance.map(|fit| {
            let correlation = correlations(&fit);
            Matrix3::from_fn(|i, j| std[i] * std[j] * correlation[(i, j)] + heavier[i] * heavier[j])
        });
        (k > 0.0 && m > 0.0 && b.is_finite()).then_some(Self {
            k,
            b,
            m,
            covariance,
        })
    }

    fn std_error(&self, by: [f64; 3]) -> Option<f64> {
        let by = nalgebra::Vector3::from(by);
        std_error(by.dot(&(self.covariance? * by)))
    }

    /// sqrt(k/m)/2pi (Hz) and its standard error.
    pub fn natural_frequency_hz(&self) -> (f64, Option<f64>) {
        let hz = (self.k / self.m).sqrt() / TAU;
        let by = [0.5 * hz / self.k, 0.0, -0.5 * hz / self.m];
        (hz, self.std_error(by))
    }

    /// B/(2 sqrt(k m)), above 1 where nothing swings, and its standard error.
    pub fn damping_ratio(&self) -> (f64, Option<f64>) {
        let root = 2.0 * (self.k * self.m).sqrt();
        let ratio = self.b / root;
        let by = [-0.5 * ratio / self.k, 1.0 / root, -0.5 * ratio / self.m];
        (ratio, self.std_error(by))
    }

    /// Roots of m s^2 + B s + k, the slower one first.
    pub fn poles(&self) -> [Pole; 2] {
        let (half, square) = (0.5 * self.b / self.m, self.k / self.m);
        let below = half * half - square;
        if below < 0.0 {
            let turns = (-below).sqrt();
            return [turns, -turns].map(|im| Pole {
                re_1_s: -half,
                im_rad_s: im,
            });
        }
        // The larger root by the sum, the other by the product: their difference would lose digits.
        let far = -half - below.sqrt().copysign(half);
        [square / far, far].map(|re_1_s| Pole {
            re_1_s,
            im_rad_s: 0.0,
        })
    }

    /// Height (m) at a time after a step of 1 m of the road.
    pub fn after_road_step(&self, t: f64) -> f64 {
        let [even, odd] = self.modes(t);
        let half = 0.5 * self.b / self.m;
        // y'' + 2 half y' + w^2 y = 0 for y = z - u from y(0) = -1, y'(0) = 2 half: the step's impulse through the damper.
        1.0 - even + half * odd
    }

    /// Height (m) at a time after a force of 1 N sets in.
    pub fn after_force_step(&self, t: f64) -> f64 {
        let [even, odd] = self.modes(t);
        let half = 0.5 * self.b / self.m;
        (1.0 - even - half * odd) / self.k
    }

    /// exp(-half t) cos(w t) and exp(-half t) sin(w t)/w, with cosh and sinh where nothing swings.
    fn modes(&self, t: f64) -> [f64; 2] {
        let (half, square) = (0.5 * self.b / self.m, self.k / self.m);
        let below = half * half - square;
        let w = below.abs().sqrt();
        if w * t < 1e-6 {
            let decay = (-half * t).exp();
            return [decay, decay * t];
        }
        if below < 0.0 {
            let decay = (-half * t).exp();
            return [decay * (w * t).cos(), decay * (w * t).sin() / w];
        }
        let (slow, fast) = (((w - half) * t).exp(), ((-w - half) * t).exp());
        [0.5 * (slow + fast), 0.5 * (slow - fast) / w]
    }

    /// Time (s) after which a step response has settled, or some swings later where it hardly does.
    pub fn settled_after_s(&self) -> f64 {
        let period = TAU * (self.m / self.k).sqrt();
        let slowest = self.poles()[0].re_1_s.abs();
        (SETTLED / slowest).clamp(period, SWINGS * period)
    }
}

/// Decay times of the slower pole that a step response is shown for: 1.8 % are left.
const SETTLED: f64 = 4.0;
/// Swings that it is shown for at most: with ten points to each, 60 points.
const SWINGS: f64 = 6.0;

/// Correlations of a covariance; of what is known exactly, with itself alone.
pub fn correlations(covariance: &[[f64; 3]; 3]) -> Matrix3<f64> {
    Matrix3::from_fn(|i, j| {
        let scale = (covariance[i][i] * covariance[j][j]).sqrt();
        match (i == j, scale > 0.0) {
            (true, _) => 1.0,
            (false, true) => (covariance[i][j] / scale).clamp(-1.0, 1.0),
            (false, false) => 0.0,
        }
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use veloid_methods::simulate::linear::{Input, simulate};

    const M: f64 = 23.0;

    fn estimate(k: f64, b: f64) -> Estimate {
        Estimate {
            k_n_m: k,
            b_n_s_m: b,
            k_std_n_m: Some(100.0),
            b_std_n_s_m: Some(5.0),
            mass_kg: M,
            covariance: Some([[1e4, 200.0, 0.0], [200.0, 25.0, 0.0], [0.0; 3]]),
            ..Estimate::default()
        }
    }

    /// Against central differences of the formulas along the square root of the covariance.
    #[test]
    fn errors_are_those_of_the_delta_method() {
        let (k, b) = (110e3, 1150.0);
        let found = Oscillator::of(&estimate(k, b), [0.0; 3]).unwrap();
        let (hz, hz_std) = found.natural_frequency_hz();
        let (ratio, ratio_std) = found.damping_ratio();
        assert!((hz - (k / M).sqrt() / TAU).abs() < 1e-12);
        assert!((ratio - b / (2.0 * (k * M).sqrt())).abs() < 1e-12);
        // Columns of the covariance's Cholesky factor: (100, 2) and (0, sqrt 21).
        let along = |of: &dyn Fn(f64, f64) -> f64| {
            let by = |dk: f64, db: f64| {
                let h = 1e-4;
                (of(k + h * dk, b + h * db) - of(k - h * dk, b - h * db)) / (2.0 * h)
            };
            by(100.0, 2.0).hypot(by(0.0, 21.0_f64.sqrt()))
        };
        let expected = along(&|k, _| (k / M).sqrt() / TAU);
        assert!((hz_std.unwrap() / expected - 1.0).abs() < 1e-6);
        let expected = along(&|k, b| b / (2.0 * (k * M).sqrt()));
        assert!((ratio_std.unwrap() / expected - 1.0).abs() < 1e-6);
    }

    /// k = (k/m) m: what a road shows is k/m and B/m, whatever the mass.
    #[test]
    fn an_uncertain_mass_cancels_on_a_road_and_not_beside_a_force() {
        let (k, b) = (110e3, 1150.0);
        let exact = Oscillator::of(&estimate(k, b), [0.0; 3]).unwrap();
        let share = 0.02;
        let wide = Estimate {
            k_std_n_m: Some(100.0_f64.hypot(share * k)),
            b_std_n_s_m: Some(5.0_f64.hypot(share * b)),
            ..estimate(k, b)
        };
        let road = Oscillator::of(&wide, [share * k, share * b, share * M]).unwrap();
        let near = |a: (f64, Option<f64>), b: (f64, Option<f64>)| {
            assert!((a.1.unwrap() / b.1.unwrap() - 1.0).abs() < 1e-6)
        };
        near(road.natural_frequency_hz(), exact.natural_frequency_hz());
        near(road.damping_ratio(), exact.damping_ratio());
        // A force keeps k and B where they are.
        let force = Oscillator::of(&estimate(k, b), [0.0, 0.0, share * M]).unwrap();
        let (hz, std) = force.natural_frequency_hz();
        assert!((std.unwrap() / hz / (0.5 * share) - 1.0).abs() < 0.01);
    }

    #[test]
    fn poles_are_the_roots_of_the_characteristic_polynomial() {
        for (k, b) in [(110e3, 1150.0), (400.0, 4e3), (110e3, 0.0), (1e3, -20.0)] {
            let poles = Oscillator::of(&estimate(k, b), [0.0; 3]).unwrap().poles();
            for Pole { re_1_s, im_rad_s } in poles {
                let re = M * (re_1_s * re_1_s - im_rad_s * im_rad_s) + b * re_1_s + k;
                let im = 2.0 * M * re_1_s * im_rad_s + b * im_rad_s;
                assert!(re.abs() < 1e-9 * k && im.abs() < 1e-9 * k, "{k} {b}");
            }
        }
        // Overdamped: two real ones, the natural frequency as ever.
        let stiff = Oscillator::of(&estimate(400.0, 4e3), [0.0; 3]).unwrap();
        assert!(stiff.damping_ratio().0 > 1.0 && stiff.poles()[0].re_1_s > stiff.poles()[1].re_1_s);
    }

    /// Against the exact solution of the plain model under a force of 1 N, and for the road by its transfer function's derivative.
    #[test]
    fn val_steps_are_those_of_the_plain_model() {
        for (k, b) in [(110e3, 1150.0), (400.0, 4e3), (2300.0, 460.0)] {
            let found = Oscillator::of(&estimate(k, b), [0.0; 3]).unwrap();
            let step = 1e-3;
            let force = vec![1.0; 2000];
            let input = Input::new(&vec![0.0; 2000], Some(&force), step);
            let (z, v) = simulate(&input, k / M, b / M, 1.0 / M, 0.0, [0.0; 2]);
            for i in 0..2000 {
                let t = i as f64 * step;
                assert!((found.after_force_step(t) - z[i]).abs() < 1e-8 / k, "{i}");
                // u = 1 m pushes by k and, as an impulse, by B: k z_F + B z_F'.
                let road = k * z[i] + b * v[i];
                assert!((found.after_road_step(t) - road).abs() < 1e-8, "{i}");
            }
        }
    }
}
