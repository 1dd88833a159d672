//! Noise as a sensor makes it.

use nalgebra::Complex;

use veloid_core::numerics::random::Normal;

/// Gaussian noise of a one-sided density (unit^2/Hz) that is reported at rising frequencies (Hz), evenly spaced: held below the first,
/// nothing from one spacing after the last. Nothing where no density is reported.
pub fn noise(densities: &[[f64; 2]], samples: usize, rate_hz: f64, seed: u64) -> Option<Vec<f64>> {
    let [[first_hz, _], [second_hz, _], ..] = densities else {
        return None;
    };
    let density = |hz: f64| {
        let place = ((hz - first_hz) / (second_hz - first_hz)).round().max(0.0);
        densities.get(place as usize).map_or(0.0, |[_, d]| *d)
    };
    let inverse = veloid_fourier::inverse(samples);
    let mut spectrum = inverse.make_input_vec();
    let mut random = Normal::new(seed);
    let last = spectrum.len() - 1;
    // Both ends of the spectrum stay zero, as the inverse wants them.
    for (k, x) in spectrum.iter_mut().enumerate().take(last).skip(1) {
        let hz = k as f64 * rate_hz / samples as f64;
        let size = (0.25 * density(hz) * rate_hz / samples as f64).sqrt();
        *x = Complex::new(size * random.draw(), size * random.draw());
    }
    let mut out = inverse.make_output_vec();
    inverse.process(&mut spectrum, &mut out).ok()?;
    Some(out)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn it_has_the_density_that_was_asked_for() {
        let white: Vec<[f64; 2]> = (4..=40).map(|k| [0.25 * f64::from(k), 1e-8]).collect();
        let made = noise(&white, 60_001, 100.0, 3).unwrap();
        let square = made.iter().map(|x| x * x).sum::<f64>() / made.len() as f64;
        // Up to 10 Hz and half a spacing.
        assert!((square / (1e-8 * 10.125) - 1.0).abs() < 0.05, "{square}");
        assert!(noise(&[], 100, 100.0, 3).is_none());
        assert_eq!(noise(&white, 60_001, 100.0, 3).unwrap(), made);
    }
}
