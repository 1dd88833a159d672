//! Fourier transforms of real records. A crate of its own, since realfft is generic: here it is compiled for `f64` once, and not
//! again with every change of the engine and with its tests.

use std::sync::Arc;

pub use realfft::num_complex::Complex;
pub use realfft::{ComplexToReal, RealToComplex};

/// From `length` real numbers to `length / 2 + 1` complex ones, without a factor.
pub fn forward(length: usize) -> Arc<dyn RealToComplex<f64>> {
    realfft::RealFftPlanner::new().plan_fft_forward(length)
}

/// From `length / 2 + 1` complex numbers to `length` real ones, `length` times the inverse of [`forward`].
pub fn inverse(length: usize) -> Arc<dyn ComplexToReal<f64>> {
    realfft::RealFftPlanner::new().plan_fft_inverse(length)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_and_back_is_the_length_times_the_record() {
        for length in [1, 2, 7, 64, 100] {
            let record: Vec<f64> = (0..length).map(|i| (i * i % 13) as f64 - 5.0).collect();
            let (mut there, mut back) = (record.clone(), vec![0.0; length]);
            let mut spectrum = vec![Complex::default(); length / 2 + 1];
            assert!(forward(length).process(&mut there, &mut spectrum).is_ok());
            assert!(inverse(length).process(&mut spectrum, &mut back).is_ok());
            for (x, y) in record.iter().zip(&back) {
                assert!(
                    (x * length as f64 - y).abs() < 1e-9 * length as f64,
                    "{length}"
                );
            }
        }
    }
}
