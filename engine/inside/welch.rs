//! Spectra and cross spectra by Welch's method.

use veloid_core::numerics::spectrum::hann;
use veloid_fourier::Complex;

/// Independent averages that a half-overlapping Hann-windowed segment is worth.
const WORTH: f64 = 0.55;

/// Averaged over segments: of the input, of the outputs, and of each output with the input.
pub struct Spectra {
    pub segments: usize,
    /// Samples of a segment.
    pub length: usize,
    pub input: Vec<f64>,
    pub outputs: Vec<Vec<f64>>,
    pub cross: Vec<Vec<Complex<f64>>>,
}

impl Spectra {
    /// Of half-overlapping segments whose samples are all valid, each less its straight line, under Hann's window.
    pub fn new(input: &[f64], outputs: &[&[f64]], valid: &[bool], length: usize) -> Self {
        let fourier = veloid_fourier::forward(length);
        let (window, _) = hann(length);
        let bins = length / 2 + 1;
        let mut found = Self {
            segments: 0,
            length,
            input: vec![0.0; bins],
            outputs: vec![vec![0.0; bins]; outputs.len()],
            cross: vec![vec![Complex::default(); bins]; outputs.len()],
        };
        let transformed = |x: &[f64]| {
            let mut part = detrended(x);
            part.iter_mut().zip(&window).for_each(|(x, w)| *x *= w);
            let mut out = fourier.make_output_vec();
            // Fails only on lengths other than planned.
            let _ = fourier.process(&mut part, &mut out);
            out
        };
        let last = input.len().saturating_sub(length);
        for start in (0..=last).step_by(length / 2) {
            let range = start..start + length;
            if !valid[range.clone()].iter().all(|valid| *valid) {
                continue;
            }
            found.segments += 1;
            let x = transformed(&input[range.clone()]);
            for (sum, x) in found.input.iter_mut().zip(&x) {
                *sum += x.norm_sqr();
            }
            for (q, output) in outputs.iter().enumerate() {
                let y = transformed(&output[range.clone()]);
                for i in 0..bins {
                    found.outputs[q][i] += y[i].norm_sqr();
                    found.cross[q][i] += y[i] * x[i].conj();
                }
            }
        }
        found
    }

    /// Independent averages.
    pub fn averages(&self) -> f64 {
        (WORTH * self.segments as f64).max(1.0)
    }

    /// Output over input at a bin, as the cross spectrum has it: noise of the output only scatters it.
    pub fn response(&self, output: usize, bin: usize) -> Complex<f64> {
        self.cross[output][bin] / self.input[bin]
    }

    /// Coherence (0 to 1) at a bin.
    pub fn coherence(&self, output: usize, bin: usize) -> f64 {
        let power = self.input[bin] * self.outputs[output][bin];
        (self.cross[output][bin].norm_sqr() / power).clamp(0.0, 1.0)
    }
}

/// Less the straight line of least squares.
fn detrended(x: &[f64]) -> Vec<f64> {
    let n = x.len() as f64;
    let middle = 0.5 * (n - 1.0);
    let mean = x.iter().sum::<f64>() / n;
    let (mut moment, mut inertia) = (0.0, 0.0);
    for (i, x) in x.iter().enumerate() {
        let t = i as f64 - middle;
        moment += t * x;
        inertia += t * t;
    }
    let slope = moment / inertia;
    let straight = |i: usize| mean + slope * (i as f64 - middle);
    x.iter().enumerate().map(|(i, x)| x - straight(i)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use veloid_core::numerics::example::white;

    #[test]
    fn a_trend_is_taken_off_and_a_gain_is_found() {
        let input: Vec<f64> = white(8000, 5);
        let output: Vec<f64> = (0..8000)
            .map(|i| 3.0 * input[i] + 1e-2 * i as f64)
            .collect();
        let mut valid = vec![true; 8000];
        let whole = Spectra::new(&input, &[&output], &valid, 500);
        assert_eq!(whole.segments, 31);
        for bin in 2..250 {
            let response = whole.response(0, bin);
            assert!((response.re - 3.0).abs() < 1e-9 && response.im.abs() < 1e-9);
            assert!(whole.coherence(0, bin) > 0.999_999);
        }
        // Segments with a sample that is not valid do not count: two contain it.
        valid[1000 - 1] = false;
        assert_eq!(Spectra::new(&input, &[&output], &valid, 500).segments, 29);
    }
}
