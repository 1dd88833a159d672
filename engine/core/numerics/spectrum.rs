//! Power spectral densities, and the white noise that they show.

/// Part of a record that a stretch takes, whose spectra and those of the halves between them are averaged: a part and no
/// time, so that a record means the same whatever its unit of time. A minute of a bicycle is resolved to 0.13 Hz.
const STRETCH: [usize; 2] = [2, 15];
/// Share of the spectrum whose median density is taken for a level.
const BAND: f64 = 0.16;
/// Standard deviations of the difference of two levels that count as scatter.
const SURE: f64 = 2.0;
/// Samples that a stretch has at least, as long as the record has three of them.
const LEAST: usize = 64;

/// One-sided power spectral density (1/Hz), averaged over half-overlapping Hann-windowed stretches.
pub struct Spectrum {
    pub hz: Vec<f64>,
    pub density: Vec<f64>,
    /// Independent stretches that were averaged.
    pub stretches: f64,
}

/// Hann's window of a length, and the sum of its squares.
pub fn hann(length: usize) -> (Vec<f64>, f64) {
    let at = |i: usize| (std::f64::consts::PI * i as f64 / length as f64).sin();
    let window: Vec<f64> = (0..length).map(|i| at(i).powi(2)).collect();
    let power = window.iter().map(|w| w * w).sum();
    (window, power)
}

impl Spectrum {
    pub fn new(x: &[f64], step: f64) -> Option<Self> {
        let length = (STRETCH[0] * x.len() / STRETCH[1]).max(LEAST) & !1;
        if length > x.len() / 3 {
            return None;
        }
        let fourier = veloid_fourier::forward(length);
        let (mut part, mut out) = (fourier.make_input_vec(), fourier.make_output_vec());
        let (window, power) = hann(length);
        let mean = x.iter().sum::<f64>() / x.len() as f64;
        let mut density = vec![0.0; out.len()];
        let starts = (0..=x.len() - length).step_by(length / 2);
        let count = starts.clone().count() as f64;
        for start in starts {
            for ((p, x), w) in part.iter_mut().zip(&x[start..]).zip(&window) {
                *p = (x - mean) * w;
            }
            fourier.process(&mut part, &mut out).ok()?;
            for (d, o) in density.iter_mut().zip(&out) {
                *d += 2.0 * step * o.norm_sqr() / power / count;
            }
        }
        Some(Self {
            hz: (0..density.len())
                .map(|i| i as f64 / (length as f64 * step))
                .collect(),
            density,
            // Neighbouring Hann windows share about half of what they see.
            stretches: 0.55 * count,
        })
    }

    /// Median density of a sixth of the spectrum, from a share of its width on.
    fn median(&self, from: f64) -> f64 {
        let n = self.hz.len() as f64;
        let mut band = self.density[(from * n) as usize..((from + BAND) * n) as usize].to_vec();
        band.sort_by(f64::total_cmp);
        band[band.len() / 2]
    }

    /// Power of each bin that stands out of the white noise, weighed by the frequency's `order`th power.
    fn powers(&self, order: i32) -> Vec<f64> {
        let floor = LOUD * self.white_floor();
        let power = |(hz, density): (&f64, &f64)| (density - floor).max(0.0) * hz.powi(order);
        self.hz.iter().zip(&self.density).map(power).collect()
    }

    /// The frequency (Hz) above which what stands out of the white noise has a [`BEYOND`]th of its power, each frequency
    /// weighed by its `order`th power.
    fn fastest(&self, order: i32) -> f64 {
        let powers = self.powers(order);
        let total: f64 = powers.iter().sum();
        let mut beyond = 0.0;
        let last = powers.iter().rposition(|power| {
            beyond += power;
            beyond > BEYOND * total
        });
        self.hz[(last.unwrap_or(0) + 1).min(self.hz.len() - 1)]
    }

    /// The frequency (Hz) below and above which half of that power lies, between bins; none where nothing stands out.
    fn median_frequency(&self, order: i32) -> Option<f64> {
        let powers = self.powers(order);
        let half = 0.5 * powers.iter().sum::<f64>();
        let mut below = 0.0;
        for (i, power) in powers.iter().enumerate() {
            if below + power >= half && half > 0.0 {
                return Some((i as f64 - 0.5 + (half - below) / power).max(0.5) * self.hz[1]);
            }
            below += power;
        }
        None
    }

    /// Density of the white noise in a record: the least median of four bands in its upper half.
    pub fn white_floor(&self) -> f64 {
        self.upper_medians()
            .into_iter()
            .fold(f64::INFINITY, f64::min)
    }

    /// Density times frequency squared of what falls as roads do (ISO 8608) beyond half the sampling rate and is folded back there, as far
    /// as two bands below that fall like it by more than their scatter; zero for white noise and for what ends before.
    pub fn tail(&self) -> f64 {
        let Some(half) = self.hz.last() else {
            return 0.0;
        };
        let bands = [0.52, 0.82];
        let levels = bands.map(|from| self.median(from) / MEDIAN);
        let shapes = bands.map(|from| {
            let hz = (from + 0.5 * BAND) * half;
            hz.powi(-2) + (2.0 * half - hz).powi(-2)
        });
        let scatter = SURE / (BAND * self.hz.len() as f64 * self.stretches).sqrt();
        let fall = levels[0] - levels[1] - scatter * levels[0].hypot(levels[1]);
        (fall / (shapes[0] - shapes[1])).clamp(0.0, levels[1] / shapes[1])
    }

    /// Density of the record where most of its power is: its own level for noise that is white within a band and nothing beyond.
    pub fn level(&self) -> f64 {
        let power: f64 = self.density.iter().sum();
        let squares: f64 = self.density.iter().map(|d| d * d).sum();
        if power > 0.0 { squares / power } else { 0.0 }
    }

    /// Median densities of four bands in the upper half.
    fn upper_medians(&self) -> [f64; 4] {
        [0.4, 0.52, 0.66, 0.82].map(|from| self.median(from))
    }

    /// The same where the upper bands agree, so that it is noise and not motion or a filter; nothing elsewhere.
    fn flat_floor(&self) -> Option<f64> {
        let medians = [0.52, 0.66, 0.82].map(|from| self.median(from));
        let least = medians.into_iter().fold(f64::INFINITY, f64::min);
        let most = medians.into_iter().fold(0.0, f64::max);
        (least > 0.0 && most < FLAT * least).then(|| medians.iter().sum::<f64>() / 3.0 / MEDIAN)
    }
}

/// Squared amplitudes at the multiples of 1/`length` of Hann-windowed stretches of that many samples, one after the other.
pub fn adjoining_powers(x: &[f64], length: usize) -> Vec<Vec<f64>> {
    let fourier = veloid_fourier::forward(length);
    let (window, _) = hann(length);
    let power = |part: &[f64]| {
        let mut part: Vec<f64> = part.iter().zip(&window).map(|(x, w)| x * w).collect();
        let mut out = fourier.make_output_vec();
        fourier.process(&mut part, &mut out).ok()?;
        Some(out.iter().map(|o| o.norm_sqr()).collect())
    };
    x.chunks_exact(length).filter_map(power).collect()
}

/// Standard deviation (m) of white noise with a one-sided density (m^2/Hz), sampled every `step` (s).
pub fn deviation(density: f64, step: f64) -> f64 {
    (0.5 * density / step).sqrt()
}

/// Times the floor from which a bin counts as more than noise.
const LOUD: f64 = 3.0;
/// Share of a record's power that may be faster than what counts as its fastest.
const BEYOND: f64 = 1e-3;

/// The frequency (Hz) beyond which hardly anything moves in a record, as far as it shows: by its rate of change where it is
/// `driven`, by itself where it swings freely.
pub fn fastest(record: &[f64], driven: bool, step: f64) -> f64 {
    let order = if driven { 2 } else { 0 };
    Spectrum::new(record, step).map_or(0.5 / step, |s| s.fastest(order))
}

/// The frequency (Hz) below and above which half of a record's power lies, with the same weights; none where the record is too
/// short to show or holds nothing but noise.
pub fn median_frequency(record: &[f64], driven: bool, step: f64) -> Option<f64> {
    let order = if driven { 2 } else { 0 };
    Spectrum::new(record, step)?.median_frequency(order)
}

/// Density (m^2/Hz, one-sided) of the white noise in a record, at most; zero where it is too short to show.
pub fn white_floor(record: &[f64], step: f64) -> f64 {
    Spectrum::new(record, step).map_or(0.0, |s| s.white_floor())
}

/// Standard deviation of the white noise that a record may hold at most, whatever a filter has taken off its fastest part; nothing
/// where it is too short to show.
pub fn most_white(record: &[f64], step: f64) -> Option<f64> {
    let loudest = Spectrum::new(record, step)?.upper_medians().into_iter();
    Some(deviation(loudest.fold(0.0, f64::max), step))
}

/// The white noise of a record's own sensor (m, RMS), where the record shows it.
pub fn measured_noise(record: &[f64], step: f64) -> Option<f64> {
    let density = Spectrum::new(record, step)?.flat_floor()?;
    Some(deviation(density, step))
}

/// Ratio of the largest to the least median of bands that hold one white noise: on ten stretches, medians of 60 bins
/// scatter by some 5 %.
const FLAT: f64 = 1.25;
/// Median over mean of densities that are averaged over some ten stretches (chi-square with twenty degrees of freedom).
const MEDIAN: f64 = 0.967;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::autoregressive::NoiseModel;

    use crate::numerics::example::{shaken, white};

    #[test]
    fn density_of_white_noise() {
        let s = Spectrum::new(&white(60_000, 3), 0.01).expect("long enough");
        assert!(
            (s.white_floor() / 0.02 - 1.0).abs() < 0.15,
            "{}",
            s.white_floor()
        );
    }

    #[test]
    fn a_slow_swing_in_noise_is_as_slow_as_it_is() {
        let noise = white(30_000, 5);
        let swing =
            |i: usize| 50.0 * (std::f64::consts::TAU * 0.7 * i as f64 * 1e-3).sin() + noise[i];
        let record: Vec<f64> = (0..30_000).map(swing).collect();
        let hz = fastest(&record, false, 1e-3);
        assert!(hz > 0.6 && hz < 2.0, "{hz} Hz");
    }

    #[test]
    fn a_sensors_noise_is_measured_where_nothing_else_is_recorded() {
        let noise: Vec<f64> = white(6000, 4).iter().map(|x| 2e-5 * x).collect();
        let slow = |i: usize| 1e-2 * (std::f64::consts::TAU * 3.0 * 0.01 * i as f64).sin();
        let record: Vec<f64> = noise.iter().enumerate().map(|(i, x)| x + slow(i)).collect();
        let found = measured_noise(&record, 0.01).expect("flat");
        assert!((found / 2e-5 - 1.0).abs() < 0.08, "{found}");
        let moving = shaken(6000, 12);
        assert_eq!(measured_noise(&moving, 0.01), None);
        let red = NoiseModel {
            a: vec![-0.9],
            variance: 1.0,
        };
        assert_eq!(measured_noise(&red.noise_model(&noise), 0.01), None);
        assert_eq!(measured_noise(&[0.0; 6000], 0.01), None);
    }

    #[test]
    fn a_filter_takes_no_noise_off_the_most_there_may_be() {
        let noise = white(6000, 4);
        let found = most_white(&noise, 0.01).expect("long enough");
        assert!((found - 1.0).abs() < 0.1, "{found}");
        // Zero at half the sampling rate, and two where all is slow.
        let filtered: Vec<f64> = noise.windows(2).map(|x| x[0] + x[1]).collect();
        let [least, most] = [
            white_floor(&filtered, 0.01),
            most_white(&filtered, 0.01).expect("long enough"),
        ];
        assert!(deviation(least, 0.01) < 0.6 && most > 1.2, "{least} {most}");
    }

    #[test]
    fn a_sine_holds_its_power_at_its_frequency() {
        let (step, hz, amplitude) = (0.01, 7.0, 2.0);
        let turn = std::f64::consts::TAU * hz * step;
        let sine: Vec<f64> = (0..20_000)
            .map(|i| amplitude * (turn * i as f64).sin())
            .collect();
        let s = Spectrum::new(&sine, step).expect("long enough");
        let power = s.density.iter().sum::<f64>() * s.hz[1];
        assert!((power / (0.5 * amplitude * amplitude) - 1.0).abs() < 0.01);
        let top = s.density.iter().copied().fold(0.0, f64::max);
        let peak = s.density.iter().position(|d| *d == top).expect("a peak");
        assert!((s.hz[peak] - hz).abs() <= s.hz[1]);
        let middle = median_frequency(&sine, false, step).expect("something moves");
        assert!((middle - hz).abs() <= s.hz[1], "{middle} Hz");
    }
}
