//! Road profiles for simulated rides: ISO 8608 roughness and bumps, as a function of distance.

use std::f64::consts::TAU;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use veloid_core::numerics::spline::{cubic, slopes};

/// Roughness classes of ISO 8608, by the geometric mean of their displacement PSD at 0.1 cycles/m.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Roughness {
    /// 16e-6 m^3.
    A,
    /// 64e-6 m^3.
    #[default]
    B,
    /// 256e-6 m^3.
    C,
    /// 1024e-6 m^3.
    D,
    /// 4096e-6 m^3.
    E,
    /// 16384e-6 m^3.
    F,
    /// 65536e-6 m^3.
    G,
    /// 262144e-6 m^3.
    H,
}

impl Roughness {
    /// Gd(n0) (m^3), n0 = 0.1 cycles/m.
    pub fn psd_m3(self) -> f64 {
        match self {
            Self::A => 16e-6,
            Self::B => 64e-6,
            Self::C => 256e-6,
            Self::D => 1024e-6,
            Self::E => 4096e-6,
            Self::F => 16_384e-6,
            Self::G => 65_536e-6,
            Self::H => 262_144e-6,
        }
    }

    /// Smoothest first.
    pub const ALL: [Self; 8] = [
        Self::A,
        Self::B,
        Self::C,
        Self::D,
        Self::E,
        Self::F,
        Self::G,
        Self::H,
    ];

    /// The class whose mean a density Gd(n0) (m^3) is nearest to, by ratio.
    pub fn nearest(psd_m3: f64) -> Self {
        let off = |class: &Self| (psd_m3 / class.psd_m3()).ln().abs();
        let nearest = Self::ALL
            .into_iter()
            .min_by(|a, b| off(a).total_cmp(&off(b)));
        nearest.unwrap_or_default()
    }

    /// A to H.
    pub fn name(self) -> &'static str {
        match self {
            Self::A => "A",
            Self::B => "B",
            Self::C => "C",
            Self::D => "D",
            Self::E => "E",
            Self::F => "F",
            Self::G => "G",
            Self::H => "H",
        }
    }
}

/// A rounded bump: height (1 - cos)/2 over its length.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bump {
    /// Where it begins (m).
    pub at_m: f64,
    /// Length (m).
    pub length_m: f64,
    /// Height (m; negative for a hole).
    pub height_m: f64,
}

impl Bump {
    fn height(&self, x: f64) -> f64 {
        let s = (x - self.at_m) / self.length_m;
        if (0.0..1.0).contains(&s) {
            0.5 * self.height_m * (1.0 - (TAU * s).cos())
        } else {
            0.0
        }
    }
}

/// Height over distance: a cubic spline, flat (0) before the start and constant after the end.
#[derive(Clone, Debug)]
pub struct Profile {
    spacing_m: f64,
    height: Vec<f64>,
    slope: Vec<f64>,
}

/// Sines that make up a rough road.
const SINES: usize = 600;
/// Lowest spatial frequency (cycles/m) of ISO 8608.
const LOWEST: f64 = 0.01;
const REFERENCE: f64 = 0.1;
/// The road rises from flat ground over this distance (m).
const FADE_M: f64 = 2.0;

/// One sine of a road: spatial frequency (cycles/m), amplitude (m), phase (rad).
struct Sine {
    n: f64,
    height: f64,
    phase: f64,
}

fn sines(roughness: Roughness, highest: f64, seed: u64) -> Vec<Sine> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let ratio = (highest / LOWEST).powf(1.0 / SINES as f64);
    let mut edge = LOWEST;
    let one = |_| {
        let width = edge * (ratio - 1.0);
        let n = edge + width * random.random::<f64>();
        let psd = roughness.psd_m3() * (n / REFERENCE).powi(-2);
        edge *= ratio;
        Sine {
            n,
            height: (2.0 * psd * width).sqrt(),
            phase: TAU * random.random::<f64>(),
        }
    };
    (0..SINES).map(one).collect()
}

/// Root of the coherence of two tracks `offset_m` (m) apart on an isotropic road at `n` cycles/m: x K1(x), x = 2 pi n offset, for a
/// density as n^-2 (Kamash and Robson 1978, J. Sound Vib. 57), with K1(x) = integral of exp(-x cosh t) cosh t over t > 0.
pub fn shared(n: f64, offset_m: f64) -> f64 {
    let x = TAU * n * offset_m;
    if x < 1e-9 {
        return 1.0;
    }
    const STEP: f64 = 0.05;
    // Beyond this the exponential is below 1e-300.
    let steps = ((700.0 / x).max(1.0).acosh() / STEP) as usize;
    let at = |i: usize| {
        let cosh = (i as f64 * STEP).cosh();
        x * cosh * (-x * cosh).exp()
    };
    STEP * (0.5 * at(0) + (1..=steps).map(at).sum::<f64>())
}

impl Profile {
    /// Flat ground of `length_m` (m), tabulated every `spacing_m` (m).
    pub fn flat(length_m: f64, spacing_m: f64) -> Self {
        let n = (length_m / spacing_m).ceil() as usize + 4;
        Self {
            spacing_m,
            height: vec![0.0; n],
            slope: vec![0.0; n],
        }
    }

    /// A road of ISO 8608: Gd(n) = Gd(n0) (n/n0)^-2 from 0.01 to `highest` cycles/m, as a sum of sines
    /// with random frequencies within equal ratios and random phases. It begins at height 0 with slope 0.
    pub fn iso(
        roughness: Roughness,
        length_m: f64,
        spacing_m: f64,
        highest: f64,
        seed: u64,
    ) -> Self {
        let mut road = Self::flat(length_m, spacing_m);
        for Sine { n, height, phase } in sines(roughness, highest, seed) {
            road.add_sine(height, n, phase);
        }
        road.begun()
    }

    /// The same road `offset_m` (m) to the side of [`Profile::iso`] of the same seed, if it is isotropic: of each sine the share
    /// [`shared`] is the same, and the rest is a road of its own.
    pub fn beside(
        roughness: Roughness,
        length_m: f64,
        spacing_m: f64,
        highest: f64,
        seed: u64,
        offset_m: f64,
    ) -> Self {
        let mut road = Self::flat(length_m, spacing_m);
        let own_seed = seed.wrapping_add(0x6265_7369_6465);
        for Sine { n, height, phase } in sines(roughness, highest, seed) {
            road.add_sine(shared(n, offset_m) * height, n, phase);
        }
        for Sine { n, height, phase } in sines(roughness, highest, own_seed) {
            let own = (1.0 - shared(n, offset_m).powi(2)).max(0.0).sqrt();
            road.add_sine(own * height, n, phase);
        }
        road.begun()
    }

    /// The road that rises from flat ground.
    fn begun(mut self) -> Self {
        let start = self.height[0];
        for (i, h) in self.height.iter_mut().enumerate() {
            *h = (*h - start) * smooth(i as f64 * self.spacing_m / FADE_M);
        }
        self.slope = slopes(&self.height, self.spacing_m);
        self
    }

    /// The same road with bumps on it.
    pub fn with_bumps(mut self, bumps: &[Bump]) -> Self {
        for (i, h) in self.height.iter_mut().enumerate() {
            let x = i as f64 * self.spacing_m;
            *h += bumps.iter().map(|b| b.height(x)).sum::<f64>();
        }
        self.slope = slopes(&self.height, self.spacing_m);
        self
    }

    fn add_sine(&mut self, amplitude: f64, cycles_per_m: f64, phase: f64) {
        let (sin, cos) = (TAU * cycles_per_m * self.spacing_m).sin_cos();
        let (mut s, mut c) = phase.sin_cos();
        for h in &mut self.height {
            *h += amplitude * s;
            (s, c) = (s * cos + c * sin, c * cos - s * sin);
        }
    }

    /// Height (m) at distance `x` (m).
    pub fn height(&self, x: f64) -> f64 {
        let place = x / self.spacing_m;
        if place <= 0.0 {
            return self.height[0];
        }
        let i = place as usize;
        if i + 1 >= self.height.len() {
            return self.height[self.height.len() - 1];
        }
        let (y, m, s) = (&self.height, &self.slope, place - i as f64);
        let c = cubic(y[i], y[i + 1], m[i], m[i + 1], self.spacing_m);
        c[0] + s * (c[1] + s * (c[2] + s * c[3]))
    }
}

/// From 0 at 0 to 1 at 1 with two continuous derivatives.
fn smooth(s: f64) -> f64 {
    let s = s.clamp(0.0, 1.0);
    s * s * s * (10.0 + s * (6.0 * s - 15.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Classes reach from half to twice their mean.
    #[test]
    fn classes_end_at_twice_their_mean() {
        for class in Roughness::ALL {
            for share in [0.51, 1.0, 1.99] {
                assert_eq!(Roughness::nearest(share * class.psd_m3()), class);
            }
        }
        assert_eq!(Roughness::nearest(1e-12).name(), "A");
        assert_eq!(Roughness::nearest(1e12).name(), "H");
    }

    #[test]
    fn roughness_is_that_of_its_class() {
        // Mean square of the road = integral of the PSD = Gd(n0) n0^2 (1/0.01 - 1/4).
        let want = 64e-6 * 0.01 * (1.0 / LOWEST - 1.0 / 4.0);
        let mean = (0..20)
            .map(|seed| {
                let road = Profile::iso(Roughness::B, 2000.0, 0.05, 4.0, seed);
                let heights = &road.height[2000..];
                let mean = heights.iter().sum::<f64>() / heights.len() as f64;
                heights.iter().map(|h| (h - mean).powi(2)).sum::<f64>() / heights.len() as f64
            })
            .sum::<f64>()
            / 20.0;
        assert!((mean / want - 1.0).abs() < 0.15, "{mean} m^2 for {want}");
    }

    /// K1(1) = 0.6019072302, K1(0.1) = 9.8538447809, K1(5) = 0.0040446134 (Abramowitz and Stegun, table 9.8).
    #[test]
    fn tracks_share_what_an_isotropic_road_lets_them() {
        for (x, k1) in [
            (1.0, 0.601_907_230_2),
            (0.1, 9.853_844_780_9),
            (5.0, 0.004_044_613_4),
        ] {
            assert!((shared(x / TAU, 1.0) / (x * k1) - 1.0).abs() < 1e-7, "{x}");
        }
        assert_eq!(shared(4.0, 0.0), 1.0);
        assert!(shared(4.0, 100.0) < 1e-9);
    }

    #[test]
    fn a_track_beside_another_is_as_rough() {
        let of = |offset| Profile::beside(Roughness::C, 2000.0, 0.05, 4.0, 3, offset);
        let front = Profile::iso(Roughness::C, 2000.0, 0.05, 4.0, 3);
        assert_eq!(of(0.0).height, front.height);
        let high = |p: &Profile| p.height.windows(2).map(|w| w[1] - w[0]).collect::<Vec<_>>();
        let power = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>();
        let (a, b) = (high(&front), high(&of(0.05)));
        assert!((power(&b) / power(&a) - 1.0).abs() < 0.1);
        let both: f64 = a.iter().zip(&b).map(|(a, b)| a * b).sum();
        let same = both / (power(&a) * power(&b)).sqrt();
        assert!((0.3..0.95).contains(&same), "{same}");
    }

    #[test]
    fn road_begins_flat_and_bumps_stand_where_they_should() {
        let road = Profile::flat(20.0, 0.005).with_bumps(&[Bump {
            at_m: 5.0,
            length_m: 0.5,
            height_m: 0.03,
        }]);
        assert_eq!(road.height(-1.0), 0.0);
        assert!(road.height(4.9).abs() < 1e-12 && road.height(30.0).abs() < 1e-12);
        assert!((road.height(5.25) - 0.03).abs() < 1e-9);
        let rough = Profile::iso(Roughness::C, 20.0, 0.005, 4.0, 3);
        assert_eq!(rough.height(0.0), 0.0);
        assert!(rough.height(0.01).abs() < 1e-7 && rough.height(10.0) != 0.0);
    }
}
