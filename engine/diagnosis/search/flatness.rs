//! Whether what a model leaves is white where an effect acts: a resonance in the noise that the autoregression does not follow makes
//! chance look like an event.

use super::criteria::Search;
use veloid_model::fit::Model;

impl Search<'_> {
    /// Times the variance of a white residual that the whitened one of `larger` has along what sets it apart from `model`, and at
    /// least 1: by so much chance gains more there.
    pub fn unevenness(&self, model: &Model, larger: &Model) -> f64 {
        let samples = self.fitter.samples;
        let tracks = &self.fitter.dataset.tracks;
        let (mut along, mut length) = (0.0, 0.0);
        let left = self.residuals(larger);
        for (t, before, noise_model) in self.residuals(model) {
            let Some((_, after, _)) = left.iter().find(|(other, ..)| *other == t) else {
                continue;
            };
            let white = |residual: &[f64]| -> Vec<f64> {
                let size = noise_model.variance.sqrt();
                let white = noise_model
                    .whiten(residual)
                    .into_iter()
                    .zip(&tracks[t].valid);
                let white = white.map(|(w, valid)| if *valid { w / size } else { 0.0 });
                white.take(samples).collect()
            };
            let (before, after) = (white(&before), white(after));
            let added: Vec<f64> = before.iter().zip(&after).map(|(b, a)| b - a).collect();
            let [more, size] = weighed(added, after);
            along += more;
            length += size;
        }
        let times: f64 = along / length;
        if times.is_finite() {
            times.max(1.0)
        } else {
            1.0
        }
    }
}

/// Energy of what is `added`, weighted by how far the spectrum of what is `left` lies above its mean, and as it is.
fn weighed(added: Vec<f64>, left: Vec<f64>) -> [f64; 2] {
    let mean: f64 = left.iter().map(|x| x * x).sum();
    let (added, left) = (powers(added), powers(left));
    let weighted: f64 = added.iter().zip(left).map(|(a, l)| a * l).sum();
    [weighted / mean, added.iter().sum()]
}

/// Squared amplitudes at all frequencies.
fn powers(mut x: Vec<f64>) -> Vec<f64> {
    let fourier = veloid_fourier::forward(x.len());
    let mut out = fourier.make_output_vec();
    match fourier.process(&mut x, &mut out) {
        Ok(()) => out.iter().map(|o| o.norm_sqr()).collect(),
        Err(_) => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::weighed;
    use veloid_core::numerics::example::white;

    /// An event of one second at 6 Hz in 20 s at 100 Hz.
    fn event() -> Vec<f64> {
        let at = |i: usize| (0.06 * std::f64::consts::TAU * i as f64).sin();
        (0..2000)
            .map(|i| if (700..800).contains(&i) { at(i) } else { 0.0 })
            .collect()
    }

    #[test]
    fn noise_that_rings_where_an_event_does_makes_more_of_it() {
        let flat = white(2000, 3);
        let [along, length] = weighed(event(), flat.clone());
        assert!((along / length - 1.0).abs() < 0.5, "{}", along / length);
        // A resonance of the same frequency in the noise.
        let mut ringing = flat.clone();
        for i in 2..2000 {
            let ring = 2.0 * 0.98 * (0.06 * std::f64::consts::TAU).cos();
            ringing[i] += ring * ringing[i - 1] - 0.98 * 0.98 * ringing[i - 2];
        }
        let [along, length] = weighed(event(), ringing);
        assert!(along / length > 4.0, "{}", along / length);
    }
}
