//! What the residual's spectrum says: does it resonate like the axle, as the answer to a force left
//! out would, or is it noise of the sensors?

use std::ops::Range;

use crate::policy;
use veloid_core::numerics::spectrum::Spectrum;
use veloid_methods::simulate::linear::{force_answer, road_answer};
use veloid_ride::Band;

/// Evidence that a force is left in a residual.
#[derive(Clone, Copy, Debug, Default)]
pub struct Resonance {
    /// Gain in Whittle log likelihood by forces beside noise.
    pub gain: f64,
    /// Share of the residual's power that the forces take.
    pub share: f64,
}

/// Correlations of first-order sensor noise, and corner frequencies (Hz) of forces, in the mixtures.
const NOISES: [f64; 11] = [0.0, 0.3, 0.5, 0.7, 0.8, 0.88, 0.93, 0.96, 0.98, 0.99, 0.995];
const FORCES_HZ: [f64; 7] = [0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 1e3];

/// Steps of the multiplicative fit of a mixture.
const STEPS: usize = 300;

/// Density of white noise that the channels which drive an axle have at most, one-sided.
pub struct Inputs {
    /// Road (m^2/Hz).
    pub road: f64,
    /// Force over the axle mass (m^2/s^4/Hz).
    pub force: f64,
    /// What road and displacement contain, where they were computed from other sensors.
    pub band: Option<Band>,
}

/// The spectrum of a residual (m) of an axle, and the noises that may explain it.
struct Noisy {
    spectrum: Spectrum,
    range: Range<usize>,
    kappa: f64,
    beta: f64,
    /// Noise of the displacement sensor of any reddish colour, of the road, of clock and force.
    noises: Vec<Part>,
}

impl Noisy {
    fn new(residual: &[f64], step: f64, kappa: f64, beta: f64, inputs: &Inputs) -> Option<Self> {
        let spectrum = Spectrum::new(residual, step)?;
        let all = 2..(0.96 * spectrum.hz.len() as f64) as usize;
        let is_contained = |i: &usize| inputs.band.is_none_or(|b| b.contains(spectrum.hz[*i]));
        let first = all.clone().find(is_contained)?;
        let range = first..all.rev().find(is_contained)? + 1;
        let hz = &spectrum.hz[range.clone()];
        if !spectrum.density[range.clone()].iter().all(|d| *d > 0.0) {
            return None;
        }
        // Slower than the spectrum resolves is as good as still.
        let kappa = kappa.max((std::f64::consts::TAU * spectrum.hz[1]).powi(2));
        let beta = beta.max(0.02 * kappa.sqrt());
        let part = |shape: &dyn Fn(f64) -> f64, most: f64| {
            Part::new(hz.iter().map(|f| shape(*f)).collect(), most)
        };
        let red = |phi: f64, f: f64| {
            let turn = std::f64::consts::TAU * f * step;
            1.0 / (1.0 - 2.0 * phi * turn.cos() + phi * phi)
        };
        let by_road = |f: f64| road_answer(kappa, beta, f);
        let by_force = |f: f64| force_answer(kappa, beta, f);
        // |1 - G|^2 with G the road's answer: 1 - G = -w^2 / (kappa - w^2 + i w beta).
        let slip = |f: f64| (std::f64::consts::TAU * f).powi(4) * by_force(f);
        // Noise of the road channel, alone and where a jittering clock puts the same into both channels.
        let road = policy::FLOOR_UNSURE * inputs.road;
        let mut noises = vec![part(&by_road, road), part(&slip, road)];
        // White noise of an accelerometer from which road and displacement were computed acts as a force on the axle.
        let force = match inputs.band {
            Some(_) => f64::INFINITY,
            None => policy::FLOOR_UNSURE * inputs.force,
        };
        noises.push(part(&by_force, force));
        noises.extend(NOISES.map(|phi| part(&|f| red(phi, f), f64::INFINITY)));
        Some(Self {
            spectrum,
            range,
            kappa,
            beta,
            noises,
        })
    }

    fn density(&self) -> &[f64] {
        &self.spectrum.density[self.range.clone()]
    }

    /// Forces of several colours, as they move the axle.
    fn forces(&self) -> Vec<Part> {
        let hz = &self.spectrum.hz[self.range.clone()];
        FORCES_HZ
            .map(|corner| {
                let force = |f: &f64| {
                    force_answer(self.kappa, self.beta, *f) / (1.0 + (f / corner).powi(2))
                };
                Part::new(hz.iter().map(force).collect(), f64::INFINITY)
            })
            .into()
    }
}

/// Explains the spectrum of a residual (m) of an axle with k/m = `kappa` and B/m = `beta` by noise of
/// its displacement sensor of any reddish colour and by noise of its `inputs`, then also by forces.
pub fn resonance(residual: &[f64], step: f64, kappa: f64, beta: f64, inputs: &Inputs) -> Resonance {
    let Some(noisy) = Noisy::new(residual, step, kappa, beta, inputs) else {
        return Resonance::default();
    };
    let without = mixed(&noisy.noises, noisy.density());
    let mut parts = noisy.forces();
    let forces = parts.len();
    parts.extend(noisy.noises.iter().cloned());
    let with = mixed(&parts, noisy.density());
    let total: f64 = with.weights.iter().sum();
    Resonance {
        gain: noisy.spectrum.stretches * (without.misfit - with.misfit),
        share: with.weights[..forces].iter().sum::<f64>() / total,
    }
}

/// Density (m^2/Hz, one-sided) of white noise of the road that the spectrum of a residual holds, at
/// most `inputs.road`: roughness, which moves the axle, leaves nothing there.
pub fn road_noise(residual: &[f64], step: f64, kappa: f64, beta: f64, inputs: &Inputs) -> f64 {
    let Some(noisy) = Noisy::new(residual, step, kappa, beta, inputs) else {
        return 0.0;
    };
    let road = mixed(&noisy.noises, noisy.density()).weights[0] / noisy.noises[0].mean;
    road.min(inputs.road)
}

/// One part of a mixture: its shape over its mean, and the most of it that there can be.
#[derive(Clone)]
struct Part {
    shape: Vec<f64>,
    mean: f64,
    most: f64,
}

impl Part {
    fn new(mut shape: Vec<f64>, most: f64) -> Self {
        let mean = shape.iter().sum::<f64>() / shape.len() as f64;
        shape.iter_mut().for_each(|s| *s /= mean);
        Self {
            shape,
            mean,
            most: most * mean,
        }
    }
}

struct Mixed {
    weights: Vec<f64>,
    /// Sum of ln S + P/S.
    misfit: f64,
}

/// Non-negative weights of the parts by multiplicative steps on the Itakura-Saito divergence
/// (Fevotte, Bertin & Durrieu 2009, doi 10.1162/neco.2008.04-08-771).
fn mixed(parts: &[Part], density: &[f64]) -> Mixed {
    let mean = density.iter().sum::<f64>() / density.len() as f64;
    let mut weights: Vec<f64> = parts
        .iter()
        .map(|p| (mean / parts.len() as f64).min(0.9 * p.most))
        .collect();
    let mut sum = vec![0.0; density.len()];
    let add = |weights: &[f64], sum: &mut [f64]| {
        sum.fill(0.0);
        for (w, p) in weights.iter().zip(parts) {
            for (s, x) in sum.iter_mut().zip(&p.shape) {
                *s += w * x;
            }
        }
    };
    for _ in 0..STEPS {
        add(&weights, &mut sum);
        let inverse: Vec<f64> = sum.iter().map(|s| 1.0 / s).collect();
        let pull: Vec<f64> = inverse
            .iter()
            .zip(density)
            .map(|(i, d)| d * i * i)
            .collect();
        for (w, p) in weights.iter_mut().zip(parts) {
            let up: f64 = p.shape.iter().zip(&pull).map(|(s, x)| s * x).sum();
            let down: f64 = p.shape.iter().zip(&inverse).map(|(s, x)| s * x).sum();
            *w = (*w * (up / down).sqrt()).min(p.most);
        }
    }
    add(&weights, &mut sum);
    Mixed {
        misfit: sum.iter().zip(density).map(|(s, d)| s.ln() + d / s).sum(),
        weights,
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use veloid_core::numerics::autoregressive::NoiseModel;
    use veloid_core::numerics::example::{shaken, white};

    const QUIET: Inputs = Inputs {
        road: 0.0,
        force: 0.0,
        band: None,
    };

    #[test]
    fn sensor_noise_does_not_resonate() {
        let noise_models = [(0.0, 1.0), (0.85, 1.0), (0.97, 0.3)];
        for (i, (phi, size)) in noise_models.into_iter().enumerate() {
            let red = NoiseModel {
                a: vec![-phi],
                variance: size,
            };
            let slow = red.noise_model(&white(6000, 5 + i as u64));
            let noise: Vec<f64> = slow
                .iter()
                .zip(white(6000, 17))
                .map(|(a, b)| a + b)
                .collect();
            let r = resonance(&noise, 0.01, 355.0, 11.3, &QUIET);
            assert!(r.gain < 10.0, "{phi}: {r:?}");
        }
    }

    #[test]
    fn a_force_does() {
        let noise = white(6000, 11);
        let rms = |x: &[f64]| (x.iter().map(|x| x * x).sum::<f64>() / x.len() as f64).sqrt();
        let moved = shaken(6000, 12);
        let share = 0.5 * rms(&noise) / rms(&moved);
        let both: Vec<f64> = noise
            .iter()
            .zip(&moved)
            .map(|(a, b)| a + share * b)
            .collect();
        let r = resonance(&both, 0.01, 355.0, 11.3, &QUIET);
        assert!(r.gain > 30.0 && (0.1..0.3).contains(&r.share), "{r:?}");
    }

    #[test]
    fn noise_of_an_accelerometer_does_not() {
        let band = Band {
            low_hz: Some(0.5),
            high_hz: Some(40.0),
        };
        let inputs = Inputs {
            band: Some(band),
            ..QUIET
        };
        let r = resonance(&shaken(6000, 12), 0.01, 355.0, 11.3, &inputs);
        assert!(r.gain < 10.0, "{r:?}");
    }

    #[test]
    fn the_channels_that_drive_have_as_much_noise_as_their_floors_may_be_too_low() {
        let (kappa, beta) = (355.0, 11.3);
        let inputs = Inputs {
            road: 2e-8,
            force: 3e-2,
            band: None,
        };
        let noisy = Noisy::new(&white(6000, 5), 0.01, kappa, beta, &inputs).unwrap();
        let hz = &noisy.spectrum.hz[noisy.range.clone()];
        let mean = |answer: fn(f64, f64, f64) -> f64| {
            hz.iter().map(|f| answer(kappa, beta, *f)).sum::<f64>() / hz.len() as f64
        };
        let most = policy::FLOOR_UNSURE * 2e-8 * mean(road_answer);
        assert!((noisy.noises[0].most / most - 1.0).abs() < 1e-9);
        let most = policy::FLOOR_UNSURE * 3e-2 * mean(force_answer);
        assert!((noisy.noises[2].most / most - 1.0).abs() < 1e-9);
    }
}
