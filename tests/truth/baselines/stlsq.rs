//! Sequentially thresholded least squares (SINDy) on the differentiated recording.
//!
//! One candidate per kind; the threshold (share of the target's rms that a term must carry) is chosen on the last 40 %, as a
//! careful user would.

use super::columns::groups;
use super::gram::Gram;
use super::regress_bic::plain;
use super::signals::Signals;
use crate::prove::outcome::Name;

const THRESHOLDS: [f64; 5] = [0.02, 0.05, 0.1, 0.2, 0.4];
const ROUNDS: usize = 12;
/// A coarser threshold is preferred when it costs less than this share of the held-out error.
const TOLERANCE: f64 = 0.02;

pub fn choose(s: &Signals) -> Vec<Name> {
    let (k, b) = plain(s);
    let s = &Signals { k, b, ..s.clone() };
    let mut list = groups(s, false);
    list.dedup_by_key(|g| g.kind);
    let mut columns = vec![s.deflection(), s.rate()];
    let mut owner = vec![None, None];
    for (i, group) in list.iter().enumerate() {
        owner.extend(group.columns.iter().map(|_| Some(i)));
        columns.extend(group.columns.iter().cloned());
    }
    let target: Vec<f64> = s
        .z_bend
        .iter()
        .zip(&s.force)
        .map(|(a, f)| s.mass_kg * a - f)
        .collect();
    let cut = target.len() * 6 / 10;
    let head: Vec<Vec<f64>> = columns.iter().map(|c| c[..cut].to_vec()).collect();
    let gram = Gram::new(&head, &target[..cut]);
    let fits: Vec<(Vec<usize>, f64)> = THRESHOLDS
        .iter()
        .filter_map(|&threshold| {
            let (kept, coefficients) = threshold_fit(&gram, columns.len(), threshold)?;
            let error: f64 = (cut..target.len())
                .map(|i| {
                    let model: f64 = kept
                        .iter()
                        .zip(&coefficients)
                        .map(|(&c, a)| a * columns[c][i] / gram.scale(c))
                        .sum();
                    (target[i] - model).powi(2)
                })
                .sum();
            Some((kept, error))
        })
        .collect();
    let least = fits.iter().map(|f| f.1).fold(f64::INFINITY, f64::min);
    let chosen = fits.iter().rev().find(|f| f.1 <= least * (1.0 + TOLERANCE));
    let mut names: Vec<Name> = chosen
        .into_iter()
        .flat_map(|f| &f.0)
        .filter_map(|&c| owner[c])
        .map(|g| list[g].name(s.axle))
        .collect();
    names.dedup();
    names
}

/// Keeps d and w always; drops what carries less than `threshold` of the target's rms until nothing changes.
fn threshold_fit(gram: &Gram, count: usize, threshold: f64) -> Option<(Vec<usize>, Vec<f64>)> {
    let mut kept: Vec<usize> = (0..count).collect();
    for _ in 0..ROUNDS {
        let (coefficients, _) = gram.fit(&kept)?;
        let next: Vec<usize> = kept
            .iter()
            .zip(&coefficients)
            .filter(|(column, a)| **column < 2 || a.abs() >= threshold * gram.target_rms())
            .map(|(column, _)| *column)
            .collect();
        if next.len() == kept.len() {
            break;
        }
        kept = next;
    }
    let (coefficients, _) = gram.fit(&kept)?;
    Some((kept, coefficients))
}
