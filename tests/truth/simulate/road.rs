//! A road profile as a function of distance: sines with an ISO 8608 spectrum, plus bumps and kerbs.
//!
//! The profile is tabulated every [`STEP_M`] with its exact slope; between the nodes the road IS the cubic through them,
//! so height, slope and integral agree to rounding.

use std::f64::consts::TAU;

use crate::chance::Chance;

/// Distance between nodes, m.
pub const STEP_M: f64 = 0.005;
const SINES: usize = 220;
/// Reference spatial frequency of ISO 8608, cycles/m.
const REFERENCE_PER_M: f64 = 0.1;

/// One obstacle, centred on or starting at `at_m`.
#[derive(Clone, Copy, Debug)]
pub enum Obstacle {
    /// Raised cosine of the given length (m) and height (m), centred on `at_m`.
    Bump {
        at_m: f64,
        length_m: f64,
        height_m: f64,
    },
    /// Smooth step to another level that begins at `at_m`; a negative height goes down.
    Ramp {
        at_m: f64,
        length_m: f64,
        height_m: f64,
    },
}

/// Displacement spectral density at 0.1 cycles/m in m^3 (class A 16e-6, B 64e-6, C 256e-6, D 1024e-6) between two spatial frequencies.
#[derive(Clone, Copy, Debug)]
pub struct Spectrum {
    pub density_m3: f64,
    pub lowest_per_m: f64,
    pub highest_per_m: f64,
}

#[derive(Clone, Debug)]
pub struct Road {
    start_m: f64,
    height: Vec<f64>,
    slope: Vec<f64>,
    integral: Vec<f64>,
}

impl Road {
    /// A road from `start_m` to `end_m`.
    pub fn new(
        start_m: f64,
        end_m: f64,
        spectrum: Spectrum,
        obstacles: &[Obstacle],
        chance: &mut Chance,
    ) -> Self {
        let count = ((end_m - start_m) / STEP_M).ceil() as usize + 2;
        let mut height = vec![0.0; count];
        let mut slope = vec![0.0; count];
        let ratio = (spectrum.highest_per_m / spectrum.lowest_per_m).powf(1.0 / SINES as f64);
        for band in 0..SINES {
            let low = spectrum.lowest_per_m * ratio.powi(band as i32);
            let n = chance.uniform(low, low * ratio);
            let density = spectrum.density_m3 * (n / REFERENCE_PER_M).powi(-2);
            add_sine(
                &mut height,
                &mut slope,
                (2.0 * density * low * (ratio - 1.0)).sqrt(),
                TAU * n,
                chance.phase(),
            );
        }
        for obstacle in obstacles {
            for (i, (h, s)) in height.iter_mut().zip(&mut slope).enumerate() {
                let (dh, ds) = obstacle.at(start_m + i as f64 * STEP_M);
                *h += dh;
                *s += ds;
            }
        }
        Self::from_nodes(start_m, height, slope)
    }

    /// The road through equidistant nodes.
    pub fn from_nodes(start_m: f64, height: Vec<f64>, slope: Vec<f64>) -> Self {
        let mut road = Self {
            start_m,
            height,
            slope,
            integral: vec![0.0],
        };
        for cell in 0..road.height.len() - 1 {
            let up_to = road.integral[cell] + road.within(cell, 1.0);
            road.integral.push(up_to);
        }
        road
    }

    /// The same road with every height multiplied, for sizing.
    pub fn scaled(&self, factor: f64) -> Self {
        let times = |v: &Vec<f64>| v.iter().map(|x| x * factor).collect();
        Self {
            start_m: self.start_m,
            height: times(&self.height),
            slope: times(&self.slope),
            integral: times(&self.integral),
        }
    }

    fn cell(&self, x: f64) -> (usize, f64) {
        let at = ((x - self.start_m) / STEP_M).clamp(0.0, (self.height.len() - 1) as f64);
        let cell = (at as usize).min(self.height.len() - 2);
        (cell, at - cell as f64)
    }

    /// Height at distance `x` (m), m.
    pub fn height(&self, x: f64) -> f64 {
        let (i, s) = self.cell(x);
        let (a, b) = (self.height[i], self.height[i + 1]);
        let (p, q) = (self.slope[i] * STEP_M, self.slope[i + 1] * STEP_M);
        a + s * (p + s * (3.0 * (b - a) - 2.0 * p - q + s * (2.0 * (a - b) + p + q)))
    }

    /// Slope at distance `x` (m), m/m.
    pub fn slope(&self, x: f64) -> f64 {
        let (i, s) = self.cell(x);
        let (a, b) = (self.height[i], self.height[i + 1]);
        let (p, q) = (self.slope[i] * STEP_M, self.slope[i + 1] * STEP_M);
        (p + s * (2.0 * (3.0 * (b - a) - 2.0 * p - q) + s * 3.0 * (2.0 * (a - b) + p + q))) / STEP_M
    }

    /// Integral of the height from the start of the road to `x`, m^2.
    pub fn integral(&self, x: f64) -> f64 {
        let (i, s) = self.cell(x);
        self.integral[i] + self.within(i, s)
    }

    fn within(&self, i: usize, s: f64) -> f64 {
        let (a, b) = (self.height[i], self.height[i + 1]);
        let (p, q) = (self.slope[i] * STEP_M, self.slope[i + 1] * STEP_M);
        let (c2, c3) = (3.0 * (b - a) - 2.0 * p - q, 2.0 * (a - b) + p + q);
        STEP_M * s * (a + s * (p / 2.0 + s * (c2 / 3.0 + s * c3 / 4.0)))
    }
}

impl Obstacle {
    /// Height (m) and slope at `x`.
    fn at(&self, x: f64) -> (f64, f64) {
        match *self {
            Obstacle::Bump {
                at_m,
                length_m,
                height_m,
            } => {
                let s = (x - at_m) / length_m;
                if s.abs() >= 0.5 {
                    return (0.0, 0.0);
                }
                let wave = TAU / length_m;
                (
                    height_m * 0.5 * (1.0 + (TAU * s).cos()),
                    -height_m * 0.5 * wave * (TAU * s).sin(),
                )
            }
            Obstacle::Ramp {
                at_m,
                length_m,
                height_m,
            } => {
                let s = ((x - at_m) / length_m).clamp(0.0, 1.0);
                let rise = s * s * s * (10.0 - 15.0 * s + 6.0 * s * s);
                (
                    height_m * rise,
                    height_m / length_m * 30.0 * (s * (1.0 - s)).powi(2),
                )
            }
        }
    }
}

/// Adds amplitude sin(k x + phase) by rotating a phasor from node to node.
fn add_sine(height: &mut [f64], slope: &mut [f64], amplitude: f64, k: f64, phase: f64) {
    let (turn_s, turn_c) = (k * STEP_M).sin_cos();
    let (mut s, mut c) = phase.sin_cos();
    for (h, g) in height.iter_mut().zip(slope) {
        *h += amplitude * s;
        *g += amplitude * k * c;
        (s, c) = (s * turn_c + c * turn_s, c * turn_c - s * turn_s);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn road() -> Road {
        let spectrum = Spectrum {
            density_m3: 16e-6,
            lowest_per_m: 0.05,
            highest_per_m: 4.0,
        };
        let bump = Obstacle::Bump {
            at_m: 20.0,
            length_m: 0.5,
            height_m: 0.01,
        };
        Road::new(-5.0, 200.0, spectrum, &[bump], &mut Chance::new(1, 0))
    }

    #[test]
    fn slope_and_integral_are_the_derivative_and_antiderivative() {
        let road = road();
        for i in 0..500 {
            let (x, e) = (0.37 * i as f64, 1e-5);
            let numeric = (road.height(x + e) - road.height(x - e)) / (2.0 * e);
            assert!((numeric - road.slope(x)).abs() < 1e-5, "slope at {x} m");
            let mean = (road.integral(x + e) - road.integral(x - e)) / (2.0 * e);
            assert!((mean - road.height(x)).abs() < 1e-9, "height at {x} m");
        }
    }

    #[test]
    fn variance_matches_the_spectrum() {
        let spectrum = Spectrum {
            density_m3: 16e-6,
            lowest_per_m: 0.05,
            highest_per_m: 4.0,
        };
        let road = Road::new(0.0, 4000.0, spectrum, &[], &mut Chance::new(2, 0));
        let n = 200_000;
        let square: f64 = (0..n)
            .map(|i| road.height(0.02 * i as f64).powi(2))
            .sum::<f64>()
            / n as f64;
        let expected = 16e-6 * 0.01 * (1.0 / 0.05 - 1.0 / 4.0);
        assert!(
            (square / expected - 1.0).abs() < 0.05,
            "{square} against {expected}"
        );
    }

    #[test]
    fn a_ramp_ends_at_its_height() {
        let ramp = Obstacle::Ramp {
            at_m: 10.0,
            length_m: 0.4,
            height_m: 0.02,
        };
        assert_eq!(ramp.at(9.99), (0.0, 0.0));
        assert!((ramp.at(10.4).0 - 0.02).abs() < 1e-15);
    }
}
