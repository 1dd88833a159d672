//! The spectra that the likelihood is made of.

use std::f64::consts::TAU;

use nalgebra::Complex;

use super::band::Band;
use super::record::Sensor;
use super::windows::Windows;
use veloid_core::numerics::spectrum::hann;

/// Most sensors that one ride rests on.
pub const MOST_SENSORS: usize = 4;

/// One frequency of one window.
#[derive(Clone, Debug)]
pub struct Bin {
    /// Frequency (rad/s) in the front wheel's time.
    pub omega: f64,
    pub cycles_per_m: f64,
    /// How many sensors reach it: the first ones.
    pub active: usize,
    /// What they show, over their scale.
    pub x: [Complex<f64>; MOST_SENSORS],
}

/// The frequencies of one window, one after the other.
#[derive(Clone, Debug)]
pub struct Group {
    pub time_s: f64,
    pub speed: f64,
    pub delay_s: f64,
    pub stretch: f64,
    pub bins: Vec<Bin>,
}

impl Group {
    /// Whether nothing of a window lies in the band.
    pub fn is_empty(&self) -> bool {
        self.bins.is_empty()
    }
}

#[derive(Clone, Debug)]
pub struct Bins {
    pub groups: Vec<Group>,
    /// Spacing of the frequencies (rad/s).
    pub spacing: f64,
    /// Root mean square of each sensor's spectrum in the band.
    pub scale: Vec<f64>,
    /// How many times the windows see each independent number.
    pub repeats: f64,
}

impl Bins {
    /// What lies in the band; `sensors` in the order of falling reach.
    pub fn of(windows: &Windows, sensors: &[Sensor], band: Band) -> Self {
        let spacing = windows.spacing_hz;
        let first = (band.low_hz / spacing).ceil().max(2.0) as usize;
        let groups = windows.list.iter().map(|window| {
            let bins = window.spectra.iter().enumerate().skip(first);
            let bins = bins.map(|(k, x)| {
                let hz = k as f64 * spacing;
                let reach = |s: &&Sensor| hz <= s.highest_hz.min(band.high_hz);
                let active = sensors.iter().take_while(reach).count();
                let mut xs = [Complex::new(0.0, 0.0); MOST_SENSORS];
                xs[..active].copy_from_slice(&x[..active]);
                Bin {
                    omega: TAU * hz,
                    cycles_per_m: hz / window.speed,
                    active,
                    x: xs,
                }
            });
            Group {
                time_s: window.time_s,
                speed: window.speed,
                delay_s: window.delay_s,
                stretch: window.stretch,
                bins: (bins.take_while(|b| b.active > 0 && b.cycles_per_m <= band.highest_per_m))
                    .collect(),
            }
        });
        let mut out = Self {
            groups: groups.collect(),
            spacing: TAU * spacing,
            scale: vec![1.0; sensors.len()],
            repeats: repeats(),
        };
        out.rescale();
        out
    }

    /// Every `every`th window: enough to find where the likelihood is largest.
    pub fn thinned(&self, every: usize) -> Self {
        Self {
            groups: self.groups.iter().step_by(every.max(1)).cloned().collect(),
            spacing: self.spacing,
            scale: self.scale.clone(),
            repeats: self.repeats,
        }
    }

    pub fn all(&self) -> impl Iterator<Item = &Bin> {
        self.groups.iter().flat_map(|g| &g.bins)
    }

    /// Lowest and highest spatial frequency (cycles/m); nothing where there is no bin.
    pub fn span(&self) -> Option<(f64, f64)> {
        let n = || self.all().map(|b| b.cycles_per_m);
        let (low, high) = (n().fold(f64::INFINITY, f64::min), n().fold(0.0, f64::max));
        (low > 0.0 && low < high).then_some((low, high))
    }

    fn rescale(&mut self) {
        for i in 0..self.scale.len() {
            let reached: Vec<f64> = (self.all().filter(|b| b.active > i))
                .map(|b| b.x[i].norm_sqr())
                .collect();
            let rms = (reached.iter().sum::<f64>() / reached.len().max(1) as f64).sqrt();
            if rms > 0.0 && rms.is_finite() {
                self.scale[i] = rms;
            }
        }
        let scale = self.scale.clone();
        for bin in self.groups.iter_mut().flat_map(|g| &mut g.bins) {
            for (x, scale) in bin.x.iter_mut().zip(&scale) {
                *x = x.unscale(*scale);
            }
        }
    }
}

/// Sum of the squared correlations of a Hann window's spectrum with its neighbours' and with those of the windows half a
/// length on: how many times each independent number is seen (Welch 1967, for all frequencies together).
fn repeats() -> f64 {
    const N: usize = 256;
    let (window, power) = hann(N);
    let shape = |i: usize| window.get(i).copied().unwrap_or(0.0);
    let correlation = |shift: usize, k: i32| -> f64 {
        let turn = |i: usize| TAU * f64::from(k) * i as f64 / N as f64;
        let terms = (0..N).map(|i| Complex::from_polar(shape(i) * shape(i + shift), turn(i)));
        terms.sum::<Complex<f64>>().norm_sqr() / (power * power)
    };
    (-4..=4)
        .map(|k| correlation(0, k) + 2.0 * correlation(N / 2, k))
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Correlations of a Hann window: 2/3 and 1/6 with the next frequencies; 60 s of half-overlapping windows hold 60 s.
    #[test]
    fn windows_repeat_about_twice() {
        let alone = 1.0 + 2.0 * (4.0 / 9.0 + 1.0 / 36.0);
        assert!(
            repeats() > alone && (repeats() - 2.1).abs() < 0.05,
            "{}",
            repeats()
        );
    }
}
