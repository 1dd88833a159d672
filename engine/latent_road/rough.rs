//! Roughly how late one sensor's clock is beside another's.

use nalgebra::Complex;

use super::record::{Lateness, since_middle_s};

/// Furthest that clocks are looked for apart (s): 3, and half a second for what 200 ppm make of an hour.
const FURTHEST_S: f64 = 3.5;
/// Shortest record (times that) in which such a delay leaves enough to compare.
const LEAST: usize = 3;
/// Band (Hz) in which a laser follows the accelerometer beside it: d = z'' / (k/m + i omega B/m) hardly turns there.
const BAND_HZ: [f64; 2] = [1.0, 12.0];
/// Least part of both that must go together at the best delay, and how many times the next hill's: a delay that is less clear is
/// left to the fit.
const CLEAR: f64 = 0.3;
const CLEARER: f64 = 1.2;
/// What counts as the same hill (s).
const HILL_S: f64 = 0.25;

/// Stretches (s) that long records are looked at in: 200 ppm are 12 ms in each, a sixth of a swing at 12 Hz.
const STRETCH_S: f64 = 60.0;

/// How late `late` is beside `early`, where that is clear: by the middle of the stretches' delays, and how these rise (Theil 1950,
/// Sen 1968: medians, so that a few stretches may be wrong).
pub fn rough_lateness(early: &[f64], late: &[f64], step_s: f64) -> Option<Lateness> {
    let samples = early.len().min(late.len());
    let count = ((samples as f64 * step_s / STRETCH_S) as usize).max(1);
    let length = samples / count;
    let found: Vec<(f64, f64)> = (0..count)
        .filter_map(|n| {
            let range = n * length..(n + 1) * length;
            let delay = rough_delay(&early[range.clone()], &late[range.clone()], step_s)?;
            let middle = range.start as f64 + 0.5 * (length as f64 - 1.0);
            Some((since_middle_s(middle, samples, step_s), delay * step_s))
        })
        .collect();
    let mut rises = Vec::new();
    for (i, (t, delay)) in found.iter().enumerate() {
        for (earlier, before) in &found[..i] {
            rises.push((delay - before) / (t - earlier));
        }
    }
    let drift = middle(&mut rises).unwrap_or(0.0);
    let mut levels: Vec<f64> = found.iter().map(|(t, delay)| delay - drift * t).collect();
    Some(Lateness {
        offset_s: middle(&mut levels)?,
        drift,
    })
}

/// The median; nothing of nothing.
fn middle(values: &mut [f64]) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let (low, high) = ((values.len().checked_sub(1)?) / 2, values.len() / 2);
    Some(0.5 * (values[low] + values[high]))
}

/// Samples by which `late` comes after `early`, where that is clear: the largest correlation of both within [`BAND_HZ`], between
/// samples by the parabola through its top.
fn rough_delay(early: &[f64], late: &[f64], step_s: f64) -> Option<f64> {
    let samples = early.len().min(late.len());
    let reach = (FURTHEST_S / step_s) as usize;
    if samples < LEAST * reach.max(1) {
        return None;
    }
    let n = (samples + reach).next_power_of_two();
    let forward = veloid_fourier::forward(n);
    let spectrum = |values: &[f64]| {
        let mean = values[..samples].iter().sum::<f64>() / samples as f64;
        let mut padded = forward.make_input_vec();
        for (p, x) in padded.iter_mut().zip(&values[..samples]) {
            *p = x - mean;
        }
        let mut out = forward.make_output_vec();
        forward.process(&mut padded, &mut out).ok()?;
        for (k, x) in out.iter_mut().enumerate() {
            let hz = k as f64 / (n as f64 * step_s);
            if !(BAND_HZ[0]..=BAND_HZ[1]).contains(&hz) {
                *x = Complex::new(0.0, 0.0);
            }
        }
        Some(out)
    };
    let (a, b) = (spectrum(early)?, spectrum(late)?);
    let size = |x: &[Complex<f64>]| x.iter().map(|x| x.norm_sqr()).sum::<f64>();
    let most = (size(&a) * size(&b)).sqrt();
    if !(most > 0.0 && most.is_finite()) {
        return None;
    }
    let mut cross: Vec<_> = a
        .iter()
        .zip(&b)
        .map(|(a, b)| b * a.conj() / (2.0 * most))
        .collect();
    let mut correlation = vec![0.0; n];
    // Both ends of the spectrum are zero, as the inverse wants them.
    let inverse = veloid_fourier::inverse(n);
    inverse.process(&mut cross, &mut correlation).ok()?;
    let at = |lag: isize| correlation[lag.rem_euclid(n as isize) as usize];
    let lags = || -(reach as isize)..=reach as isize;
    let best = lags().max_by(|x, y| at(*x).abs().total_cmp(&at(*y).abs()))?;
    let hill = (HILL_S / step_s) as isize;
    let next = lags().filter(|lag| (lag - best).abs() > hill);
    let next = next.map(|lag| at(lag).abs()).fold(0.0, f64::max);
    let top = at(best).abs();
    let [before, after] = [best - 1, best + 1].map(|lag| at(lag).abs());
    let bend = before - 2.0 * top + after;
    let part = if bend < 0.0 {
        (0.5 * (before - after) / bend).clamp(-0.5, 0.5)
    } else {
        0.0
    };
    (top > CLEAR && top > CLEARER * next).then_some(best as f64 + part)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::align::interpolate;
    use veloid_core::numerics::example::{shaken, white};

    #[test]
    fn a_shift_is_found_either_way() {
        let x = shaken(6000, 4);
        for lag in [-250_isize, -3, 0, 120] {
            let last = x.len() as isize - 1;
            let late: Vec<f64> = (0..=last)
                .map(|i| x[(i - lag).clamp(0, last) as usize])
                .collect();
            is_near(rough_delay(&x, &late, 0.01), lag as f64);
        }
        // Turned over it is the same delay.
        let turned: Vec<f64> = x.iter().map(|x| -x).collect();
        is_near(rough_delay(&x, &turned, 0.01), 0.0);
    }

    fn is_near(found: Option<f64>, samples: f64) {
        assert!(
            found.is_some_and(|f| (f - samples).abs() < 0.1),
            "{found:?}"
        );
    }

    #[test]
    fn a_drift_is_found_over_many_stretches() {
        let x = shaken(60_000, 4);
        let late = |drift: f64, wrong: usize| -> Vec<f64> {
            let at = |i: usize| i as f64 - (12.3 + drift * (i as f64 - 30_000.0));
            let late = (0..x.len())
                .map(|i| interpolate(&x, at(i)))
                .collect::<Vec<_>>();
            let noise = white(wrong, 3).into_iter();
            noise.chain(late.into_iter().skip(wrong)).collect()
        };
        for (drift, wrong) in [(0.0, 0), (200e-6, 0), (-200e-6, 12_000)] {
            let found = rough_lateness(&x, &late(drift, wrong), 0.01).unwrap();
            assert!((found.offset_s - 0.123).abs() < 2e-3, "{found:?}");
            assert!((found.drift - drift).abs() < 10e-6, "{found:?}");
        }
        assert_eq!(rough_lateness(&x, &white(60_000, 7), 0.01), None);
        assert_eq!(rough_lateness(&[], &[], 0.01), None);
    }

    #[test]
    fn a_delay_that_is_not_clear_is_none() {
        let (x, y) = (shaken(6000, 4), shaken(6000, 11));
        let mixed = |share: f64| -> Option<f64> {
            let rest = (1.0 - share * share).sqrt();
            let z: Vec<f64> = x
                .iter()
                .zip(&y)
                .map(|(x, y)| share * x + rest * y)
                .collect();
            rough_delay(&x, &z, 0.01)
        };
        assert!(mixed(1.4 * CLEAR).is_some_and(|found| found.abs() < 1.0));
        assert_eq!(mixed(0.6 * CLEAR), None);
        // A swing repeats itself.
        let swing: Vec<f64> = (0..6000).map(|i| (0.2 * f64::from(i)).sin()).collect();
        assert_eq!(rough_delay(&swing, &swing, 0.01), None);
    }

    #[test]
    fn what_has_nothing_in_common_has_no_delay() {
        let [x, y] = [white(6000, 4), white(6000, 9)];
        assert_eq!(rough_delay(&x, &y, 0.01), None);
        assert_eq!(rough_delay(&x, &[0.0; 6000], 0.01), None);
        assert_eq!(rough_delay(&[], &[], 0.01), None);
        assert_eq!(rough_delay(&[1e300; 6000], &[f64::MAX; 6000], 0.01), None);
        assert_eq!(rough_delay(&[f64::NAN; 6000], &x, 0.01), None);
    }
}
