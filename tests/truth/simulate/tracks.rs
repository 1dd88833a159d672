//! The tracks of two wheels on an isotropic road: a stationary Gaussian surface that looks alike in every direction.
//!
//! Two tracks at a distance s have, at n cycles/m, the coherence (x K1(x))^2 with x = 2 pi n s.

use std::f64::consts::{PI, TAU};

use nalgebra::Complex;

use super::bessel::x_k1;
use super::fourier::sum_lines;
use super::road::{Road, STEP_M};
use crate::chance::Chance;

/// Where the spectrum begins and ends, cycles/m.
const LOWEST_PER_M: f64 = 0.02;
const HIGHEST_PER_M: f64 = 60.0;
/// Reference spatial frequency of ISO 8608, cycles/m.
const REFERENCE_PER_M: f64 = 0.1;
/// Distance (m) over which steering goes to and fro.
const STEERS_M: [f64; 2] = [20.0, 60.0];

/// A road, and how both wheels run on it, front then rear.
#[derive(Clone, Debug)]
pub struct Ground {
    /// Displacement spectral density at 0.1 cycles/m, m^3.
    pub density_m3: f64,
    /// Length over which each wheel's contact patch averages the road, m.
    pub patch_m: [f64; 2],
    /// Between which distances the rear wheel's track wanders beside the front wheel's, m.
    pub offset_m: [f64; 2],
}

/// Height and slope at every node.
struct Laid {
    height: Vec<f64>,
    slope: Vec<f64>,
}

impl Ground {
    /// What each wheel meets from `from_m` to `to_m`.
    pub fn tracks(&self, [from_m, to_m]: [f64; 2], chance: &mut Chance) -> [Road; 2] {
        let nodes = ((to_m - from_m) / STEP_M).ceil() as usize + 2;
        let len = nodes.next_power_of_two();
        let shared = self.lines(len, chance);
        let own = self.lines(len, chance);
        let [front, rear] = self.patch_m;
        let laid = lay(len, |i, n| shared[i] * averaged(n * front));
        let [near, far] = self.offset_m.map(|offset| {
            lay(len, |i, n| {
                let g = x_k1(TAU * n * offset);
                (shared[i] * g + own[i] * (1.0 - g * g).max(0.0).sqrt()) * averaged(n * rear)
            })
        });
        let steers = (
            TAU / chance.uniform(STEERS_M[0], STEERS_M[1]),
            chance.phase(),
        );
        [laid, near.steered(&far, steers)].map(|mut laid| {
            laid.height.truncate(nodes);
            laid.slope.truncate(nodes);
            Road::from_nodes(from_m, laid.height, laid.slope)
        })
    }

    /// Random amplitudes of the lines of a profile of `len` nodes.
    fn lines(&self, len: usize, chance: &mut Chance) -> Vec<Complex<f64>> {
        let line = |i: usize| {
            let n = frequency(i, len);
            if i > len / 2 || !(LOWEST_PER_M..HIGHEST_PER_M).contains(&n) {
                return Complex::default();
            }
            let density = self.density_m3 * (n / REFERENCE_PER_M).powi(-2);
            let amplitude = (density * frequency(1, len)).sqrt();
            Complex::new(amplitude * chance.normal(), amplitude * chance.normal())
        };
        (0..len).map(line).collect()
    }
}

impl Laid {
    /// Goes from this profile to the other one and back, with the wave number (1/m) and the phase of a sine.
    fn steered(mut self, other: &Self, (wave, phase): (f64, f64)) -> Self {
        for i in 0..self.height.len() {
            let (s, c) = (wave * STEP_M * i as f64 + phase).sin_cos();
            let (share, change) = (0.5 + 0.5 * s, 0.5 * wave * c);
            let apart = other.height[i] - self.height[i];
            self.slope[i] += share * (other.slope[i] - self.slope[i]) + change * apart;
            self.height[i] += share * apart;
        }
        self
    }
}

/// Cycles/m of line `i` of `len`.
fn frequency(i: usize, len: usize) -> f64 {
    i as f64 / (len as f64 * STEP_M)
}

/// What is left of a sine that is averaged over so many of its periods.
fn averaged(periods: f64) -> f64 {
    match PI * periods {
        0.0 => 1.0,
        x => x.sin() / x,
    }
}

/// The real part of the sum of lines; `line` gives their amplitudes, by number and cycles/m.
fn lay(len: usize, line: impl Fn(usize, f64) -> Complex<f64>) -> Laid {
    let amplitude = |i: usize| line(i, frequency(i, len));
    let slope = |i: usize| amplitude(i) * Complex::new(0.0, TAU * frequency(i, len));
    Laid {
        height: real((0..len).map(amplitude).collect()),
        slope: real((0..len).map(slope).collect()),
    }
}

fn real(mut lines: Vec<Complex<f64>>) -> Vec<f64> {
    sum_lines(&mut lines);
    lines.iter().map(|x| x.re).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const WINDOW: usize = 1024;

    fn ground(offset_m: f64) -> Ground {
        Ground {
            density_m3: 256e-6,
            patch_m: [0.0; 2],
            offset_m: [offset_m; 2],
        }
    }

    /// Power of both tracks' slopes, and what they have in common, by line of windows of 5 m.
    fn spectra(tracks: &[Road; 2], length_m: f64) -> [Vec<Complex<f64>>; 3] {
        let mut sums = [const { Vec::new() }; 3].map(|_: Vec<()>| vec![Complex::default(); WINDOW]);
        let windows = (length_m / STEP_M) as usize / WINDOW;
        for w in 0..windows {
            let [front, rear] = tracks.each_ref().map(|road| {
                let at = |i: usize| {
                    let taper = 0.5 - 0.5 * (TAU * i as f64 / WINDOW as f64).cos();
                    let x = STEP_M * (w * WINDOW + i) as f64;
                    Complex::from(taper * road.slope(x))
                };
                let mut lines: Vec<_> = (0..WINDOW).map(at).collect();
                sum_lines(&mut lines);
                lines
            });
            for i in 0..WINDOW {
                sums[0][i] += front[i] * front[i].conj();
                sums[1][i] += rear[i] * rear[i].conj();
                sums[2][i] += front[i] * rear[i].conj();
            }
        }
        sums
    }

    #[test]
    fn tracks_beside_each_other_are_as_coherent_as_the_road_lets_them_be() {
        let (length, offset) = (5000.0, 0.02);
        let tracks = ground(offset).tracks([0.0, length], &mut Chance::new(3, 0));
        let [front, rear, both] = spectra(&tracks, length);
        for from in [3_usize, 10, 20, 40, 80, 200] {
            let to = from + from.div_ceil(3);
            let of = |x: &[Complex<f64>]| x[from..to].iter().sum::<Complex<f64>>();
            let coherence = of(&both).norm_sqr() / (of(&front) * of(&rear)).re;
            let middle = 0.5 * (from + to - 1) as f64 / (WINDOW as f64 * STEP_M);
            let exact = x_k1(TAU * middle * offset).powi(2);
            assert!(
                (coherence - exact).abs() < 0.03,
                "{middle} cycles/m: {coherence} and {exact}"
            );
        }
    }

    #[test]
    fn each_track_has_the_spectrum() {
        let length = 20_000.0;
        for track in ground(0.01).tracks([0.0, length], &mut Chance::new(4, 0)) {
            let nodes = (length / STEP_M) as usize;
            let power = (0..nodes).map(|i| track.slope(STEP_M * i as f64).powi(2));
            let exact = 256e-6 * 0.01 * TAU * TAU * (HIGHEST_PER_M - LOWEST_PER_M);
            let share = power.sum::<f64>() / nodes as f64 / exact;
            assert!((share - 1.0).abs() < 0.02, "{share}");
        }
    }

    #[test]
    fn a_track_that_wanders_has_the_slope_of_its_height() {
        let ground = Ground {
            offset_m: [0.0, 0.05],
            patch_m: [0.06, 0.1],
            ..ground(0.0)
        };
        let [_, rear] = ground.tracks([-3.0, 90.0], &mut Chance::new(5, 0));
        let scatter = |of: &dyn Fn(f64) -> f64| {
            let values = (0..1500).map(|i| of(0.05 * f64::from(i)).powi(2));
            (values.sum::<f64>() / 1500.0).sqrt()
        };
        // Over 5 mm heights change by their slopes.
        let off = |x: f64| {
            let rise = (rear.height(x + STEP_M) - rear.height(x - STEP_M)) / (2.0 * STEP_M);
            rise - rear.slope(x)
        };
        assert!(scatter(&off) < 0.05 * scatter(&|x| rear.slope(x)));
    }

    #[test]
    fn a_patch_that_is_a_period_long_hides_it() {
        assert!(averaged(1.0).abs() < 1e-15 && averaged(0.0) == 1.0);
        assert!((averaged(0.5) - 2.0 / PI).abs() < 1e-15);
    }
}
