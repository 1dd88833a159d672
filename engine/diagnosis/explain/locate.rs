//! Where the plain model fails: windows of time, bands of frequency, regions of the state. All from
//! the excess of the plain residual over what the extended model leaves.

use std::ops::Range;

use veloid_core::numerics::spectrum::adjoining_powers;
use veloid_core::numerics::statistics::normal_tail;
use veloid_model::dataset::Dataset;
use veloid_model::fit::Motion;

/// Times (s) where the excess of squared residual is significant, corrected for the number of windows.
pub fn windows(
    plain: &[f64],
    left: &[f64],
    valid: &[bool],
    dataset: &Dataset,
    alpha: f64,
) -> Vec<[f64; 2]> {
    const WINDOWS: usize = 30;
    let n = plain.len();
    let length = (n / WINDOWS).max(1);
    let mut found: Vec<[f64; 2]> = Vec::new();
    for (k, start) in (0..n).step_by(length).enumerate() {
        let end = (start + length).min(n);
        let excess: Vec<f64> = (start..end)
            .filter(|i| valid[*i])
            .map(|i| plain[i].powi(2) - left[i].powi(2))
            .collect();
        if significance(&excess) < alpha / WINDOWS as f64 {
            let window = [start as f64 * dataset.step, end as f64 * dataset.step];
            match found.last_mut() {
                Some(last) if k > 0 && (last[1] - window[0]).abs() < 0.5 * dataset.step => {
                    last[1] = window[1]
                }
                _ => found.push(window),
            }
        }
    }
    found
}

/// p value of a positive mean, for values correlated over about a tenth of the stretch.
fn significance(excess: &[f64]) -> f64 {
    const BLOCKS: usize = 10;
    if excess.len() < 2 * BLOCKS {
        return 1.0;
    }
    let length = excess.len() / BLOCKS;
    let means: Vec<f64> = excess
        .chunks_exact(length)
        .map(|c| c.iter().sum::<f64>() / length as f64)
        .collect();
    let count = means.len() as f64;
    let mean = means.iter().sum::<f64>() / count;
    let variance = means.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / (count - 1.0);
    if variance > 0.0 {
        normal_tail(mean / (variance / count).sqrt())
    } else {
        1.0
    }
}

/// Bands (Hz) where the plain residual's spectrum lies significantly above the other's.
pub fn bands(plain: &[f64], left: &[f64], step: f64, alpha: f64) -> Vec<[f64; 2]> {
    let length = (4.0 / step).round().clamp(64.0, 2048.0) as usize & !1;
    if plain.len() / length < 4 {
        return Vec::new();
    }
    let bins = 40.min(length / 4);
    let top = 0.5 / step;
    let powers = [plain, left].map(|x| adjoining_powers(x, length));
    // Power of each stretch in a band.
    let energy = |powers: &[Vec<f64>], band: usize| -> Vec<f64> {
        let inside = [band, band + 1].map(|edge| edge * length / 2 / bins);
        let sum = |power: &Vec<f64>| power[inside[0]..inside[1]].iter().sum();
        powers.iter().map(sum).collect()
    };
    let mut found: Vec<[f64; 2]> = Vec::new();
    for band in 0..bins {
        let [a, b] = [&powers[0], &powers[1]].map(|powers| energy(powers, band));
        let differences: Vec<f64> = a.iter().zip(&b).map(|(a, b)| a - b).collect();
        let count = differences.len() as f64;
        let mean = differences.iter().sum::<f64>() / count;
        let floor = b.iter().sum::<f64>() / count;
        let variance = differences.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (count - 1.0);
        let clear = mean > 0.3 * floor
            && normal_tail(mean / (variance / count).sqrt()) < alpha / bins as f64;
        if clear {
            let edges = [
                band as f64 * top / bins as f64,
                (band + 1) as f64 * top / bins as f64,
            ];
            match found.last_mut() {
                Some(last) if (last[1] - edges[0]).abs() < 1e-9 => last[1] = edges[1],
                _ => found.push(edges),
            }
        }
    }
    found
}

/// Regions of deflection, rate, speed and crank angle in which most of the missing force (m/s^2)
/// lies although the ride spends little time there, in words.
pub fn states(force: &[f64], m: &Motion, dataset: &Dataset, samples: Range<usize>) -> Vec<String> {
    let total: f64 = samples.clone().map(|i| force[i] * force[i]).sum();
    if !(total > 0.0) {
        return Vec::new();
    }
    let share = |inside: &dyn Fn(usize) -> bool| -> (f64, f64) {
        let (mut energy, mut time) = (0.0, 0.0);
        for i in samples.clone().filter(|i| inside(*i)) {
            energy += force[i] * force[i];
            time += 1.0;
        }
        (energy / total, time / samples.len() as f64)
    };
    let mut words = Vec::new();
    let mut mark = |what: String, inside: &dyn Fn(usize) -> bool| {
        let (energy, time) = share(inside);
        if energy > 0.8 && energy > time + 0.3 {
            words.push(format!(
                "{what}: {:.0} % of the missing force in {:.0} % of the time",
                100.0 * energy,
                100.0 * time
            ));
            return true;
        }
        false
    };
    let rms = |x: &[f64]| {
        (samples.clone().map(|i| x[i] * x[i]).sum::<f64>() / samples.len() as f64).sqrt()
    };
    let (ds, ws) = (rms(&m.d), rms(&m.w));
    for level in [2.0, 1.5, 1.0, 0.5] {
        let d = level * ds;
        let mm = 1e3 * d;
        if mark(format!("compression beyond {mm:.2} mm"), &|i| m.d[i] > d)
            || mark(format!("rebound beyond {mm:.2} mm"), &|i| m.d[i] < -d)
            || mark(
                format!("deflection beyond {mm:.2} mm in either direction"),
                &|i| m.d[i].abs() > d,
            )
        {
            break;
        }
    }
    for level in [2.0, 1.5, 1.0, 0.5] {
        let w = level * ws;
        if mark(format!("rates beyond {w:.3} m/s"), &|i| m.w[i].abs() > w) {
            break;
        }
    }
    mark("compression".into(), &|i| m.d[i] > 0.0);
    mark("rebound".into(), &|i| m.d[i] < 0.0);
    mark("while compressing".into(), &|i| m.w[i] > 0.0);
    mark("while rebounding".into(), &|i| m.w[i] < 0.0);
    let mut speeds: Vec<f64> = samples.clone().map(|i| dataset.speed[i]).collect();
    speeds.sort_by(f64::total_cmp);
    if let (Some(low), Some(high)) = (
        speeds.get(speeds.len() / 3),
        speeds.get(2 * speeds.len() / 3),
    ) && high - low > 0.1
    {
        let (low, high) = (*low, *high);
        mark(format!("speeds above {high:.1} m/s"), &|i| {
            dataset.speed[i] > high
        });
        mark(format!("speeds below {low:.1} m/s"), &|i| {
            dataset.speed[i] < low
        });
    }
    words
}
