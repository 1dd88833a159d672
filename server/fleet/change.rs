//! A step in a bicycle's history: a tyre was changed, a fork was serviced, something broke.

use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use serde::Serialize;
use utoipa::ToSchema;

use super::weighted;
use crate::time;

/// Fewest rides on each side of a step.
const SIDE: usize = 3;
/// Orders of the rides that the best step is compared with.
const SHUFFLES: usize = 999;

/// The step that divides the history best.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct Change {
    /// Time of the first ride after it.
    #[schema(format = DateTime)]
    pub at: String,
    /// Weighted means before and after.
    pub before: f64,
    pub after: f64,
    /// Share of random orders of the same rides that hold as clear a step.
    pub p_value: f64,
}

impl Change {
    /// `points`: time (epoch ms), value, standard deviation, oldest first.
    pub fn of(points: &[(i64, f64, f64)]) -> Option<Self> {
        if points.len() < 2 * SIDE {
            return None;
        }
        let mut values: Vec<(f64, f64)> = points.iter().map(|(_, v, s)| (*v, s.powi(-2))).collect();
        let (split, size) = best(&values);
        let (before, after) = (mean(&values[..split]), mean(&values[split..]));
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let as_clear = (0..SHUFFLES)
            .filter(|_| {
                values.shuffle(&mut random);
                best(&values).1 >= size
            })
            .count();
        Some(Self {
            at: time::text(points[split].0),
            before,
            after,
            p_value: (as_clear + 1) as f64 / (SHUFFLES + 1) as f64,
        })
    }
}

fn mean(values: &[(f64, f64)]) -> f64 {
    weighted(values.iter().copied()).0
}

/// The split with the largest sum of squares between its sides.
fn best(values: &[(f64, f64)]) -> (usize, f64) {
    let sum = |(a, b): (f64, f64), (value, weight): &(f64, f64)| (a + weight * value, b + weight);
    let (all, weights) = values.iter().fold((0.0, 0.0), sum);
    let mut left = values[..SIDE - 1].iter().fold((0.0, 0.0), sum);
    let mut found = (SIDE, f64::NEG_INFINITY);
    for split in SIDE..=values.len() - SIDE {
        left = sum(left, &values[split - 1]);
        let (value, weight) = left;
        let gap = value / weight - (all - value) / (weights - weight);
        let between = gap * gap * weight * (weights - weight) / weights;
        if between > found.1 {
            found = (split, between);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_step_is_dated_and_scatter_is_no_step() {
        let noise = [0.4, -0.3, 0.1, -0.5, 0.2, 0.3, -0.2, 0.0, 0.1, -0.4];
        let history = |step: f64| -> Vec<(i64, f64, f64)> {
            let value = |i: usize| 100.0 + noise[i] + if i >= 6 { step } else { 0.0 };
            (0..noise.len())
                .map(|i| (i as i64 * 1000, value(i), 0.3))
                .collect()
        };
        let change = Change::of(&history(-5.0)).unwrap();
        assert_eq!(change.at, time::text(6000));
        assert!(change.p_value < 0.02, "{change:?}");
        assert!((change.before - change.after - 5.0).abs() < 0.5);
        assert!(Change::of(&history(0.0)).unwrap().p_value > 0.1);
        assert_eq!(Change::of(&history(1.0)[..5]), None);
    }
}
