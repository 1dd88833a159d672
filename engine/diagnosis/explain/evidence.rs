//! The data of the verdict's figures, per axle: the stretch where the plain model is worst, the spectrum
//! of what each model leaves, and the force that the plain spring and damper lack.

use veloid_core::numerics::finite::finite;
use veloid_core::numerics::spectrum::Spectrum;
use veloid_model::dataset::Track;
use veloid_model::fit::Motion;
use veloid_report::Estimate;
use veloid_report::diagnosis::{Excerpt, ResidualSpectrum, Surface};

/// Longest excerpt (samples and s).
const EXCERPT: usize = 1000;
const EXCERPT_S: f64 = 6.0;

/// `plain` and `left` are measured minus simulated, along the whole ride.
pub fn excerpt(track: &Track, plain: &[f64], left: &[f64]) -> Excerpt {
    let n = track.measured.len();
    let length = EXCERPT
        .min((EXCERPT_S / track.input.step).ceil() as usize)
        .clamp(1, n.max(1));
    let excess = |i: usize| {
        if track.valid[i] {
            plain[i].powi(2) - 0.5 * left[i].powi(2)
        } else {
            0.0
        }
    };
    let mut sum: f64 = (0..length.min(n)).map(excess).sum();
    let (mut from, mut most) = (0, sum);
    for i in length..n {
        sum += excess(i) - excess(i - length);
        if sum > most {
            (from, most) = (i + 1 - length, sum);
        }
    }
    let window = from..(from + length).min(n);
    let model = |residual: &[f64]| {
        let value = |i: usize| finite(track.measured[i] - residual[i]);
        window.clone().map(value).collect()
    };
    Excerpt {
        t_s: window
            .clone()
            .map(|i| i as f64 * track.input.step)
            .collect(),
        measured_m: window
            .clone()
            .map(|i| track.valid[i].then_some(track.measured[i]))
            .collect(),
        plain_m: model(plain),
        extended_m: model(left),
    }
}

/// Points of the spectrum.
const POINTS: usize = 160;

pub fn residual_spectrum(track: &Track, plain: &[f64], left: &[f64]) -> ResidualSpectrum {
    let step = track.input.step;
    let (Some(plain), Some(left)) = (Spectrum::new(plain, step), Spectrum::new(left, step)) else {
        return ResidualSpectrum::default();
    };
    let bins = plain.hz.len();
    // Bins join to bands of equal ratio, as the axis is logarithmic.
    let ratio = (bins as f64).powf(1.0 / POINTS as f64);
    let mut spectrum = ResidualSpectrum::default();
    let mut from = 1;
    while from < bins {
        let to = ((from as f64 * ratio).round() as usize).clamp(from + 1, bins);
        let mean = |x: &[f64]| x[from..to].iter().sum::<f64>() / (to - from) as f64;
        spectrum.frequency_hz.push(mean(&plain.hz));
        spectrum.plain_m2_hz.push(finite(mean(&plain.density)));
        spectrum.extended_m2_hz.push(finite(mean(&left.density)));
        from = to;
    }
    spectrum
}

/// Cells along each side of the surface, and its half width in RMS values.
const CELLS: usize = 15;
const REACH: f64 = 2.5;
const LEAST: usize = 3;

/// `motion` is the plain model's, `residual` measured minus simulated. Empty where the model runs away.
pub fn surface(track: &Track, motion: &Motion, residual: &[f64], plain: &Estimate) -> Surface {
    let (step, r) = (track.input.step, residual);
    let (m, k, b) = (plain.mass_kg, plain.k_n_m, plain.b_n_s_m);
    let points: Vec<[f64; 3]> = (1..r.len().saturating_sub(1))
        .filter(|i| track.valid[i - 1..=i + 1].iter().all(|v| *v))
        .map(|i| {
            let slope = (r[i + 1] - r[i - 1]) / (2.0 * step);
            let bend = (r[i + 1] - 2.0 * r[i] + r[i - 1]) / (step * step);
            if track.input.prescribed {
                return [motion.d[i], motion.w[i], r[i]];
            }
            let lacking = m * bend + b * slope + k * r[i];
            [motion.d[i] - r[i], motion.w[i] - slope, lacking]
        })
        .collect();
    surface_of(&points, [k, b])
}

/// The mean force at each place of deflection (m), rate (m/s) and force (N), beside that of a plain spring (N/m) and damper (N s/m). Empty
/// where a number is none.
pub fn surface_of(points: &[[f64; 3]], [k, b]: [f64; 2]) -> Surface {
    if points.iter().flatten().any(|x| !x.is_finite()) {
        return Surface::default();
    }
    let count = points.len().max(1) as f64;
    let axis = |q: usize| -> Vec<f64> {
        let middle = points.iter().map(|p| p[q]).sum::<f64>() / count;
        let square: f64 = points.iter().map(|p| (p[q] - middle).powi(2)).sum();
        let top = REACH * (square / count).sqrt();
        let cell = |i: usize| middle + top * (2.0 * i as f64 / (CELLS - 1) as f64 - 1.0);
        (0..CELLS).map(cell).collect()
    };
    let (deflection, rate) = (axis(0), axis(1));
    let mut sums = vec![vec![(0.0, 0_usize); CELLS]; CELLS];
    for [d, w, force] in points {
        if let (Some(column), Some(row)) = (cell(&deflection, *d), cell(&rate, *w)) {
            let sum = &mut sums[row][column];
            *sum = (sum.0 + force, sum.1 + 1);
        }
    }
    let plain = |w: &f64| deflection.iter().map(|d| k * d + b * w).collect();
    Surface {
        lacking_n: grid(&sums, |(sum, n)| (*n >= LEAST).then(|| sum / *n as f64)),
        samples: grid(&sums, |(_, n)| *n),
        plain_n: rate.iter().map(plain).collect(),
        deflection_m: deflection,
        rate_m_s: rate,
    }
}

fn cell(axis: &[f64], x: f64) -> Option<usize> {
    let position = ((x - axis[0]) / (axis[1] - axis[0])).round();
    (0.0..axis.len() as f64)
        .contains(&position)
        .then_some(position as usize)
}

fn grid<T, U>(rows: &[Vec<T>], of: impl Fn(&T) -> U) -> Vec<Vec<U>> {
    rows.iter()
        .map(|row| row.iter().map(&of).collect())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_off_the_grid_have_no_cell() {
        let axis = [-1.0, 0.0, 1.0];
        assert_eq!(cell(&axis, 0.4), Some(1));
        assert_eq!(cell(&axis, 1.6), None);
        assert_eq!(cell(&axis, f64::NAN), None);
        assert_eq!(cell(&[0.0, 0.0], 0.0), None);
    }
}
