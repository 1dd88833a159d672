//! Cross-validation over contiguous blocks, with the rule of one standard error.

use super::design::Design;
use super::gram::{Gram, Model};

/// A model and its validated error as a share of the target's mean square.
pub struct Validated {
    pub model: Model,
    pub error: f64,
}

/// The simplest model of a path (from simple to complex, of the same length for any rows) that on blocks left out is within
/// one standard error of the best.
pub fn validated(design: &Design, path: impl Fn(&Gram) -> Vec<Model>) -> Option<Validated> {
    let blocks = &design.blocks;
    let whole = Gram::without(blocks, None);
    let of_all = path(&whole);
    let mut errors = vec![Vec::new(); of_all.len()];
    for (left_out, block) in blocks.iter().enumerate() {
        let models = path(&Gram::without(blocks, Some(left_out)));
        for (errors, model) in errors.iter_mut().zip(&models) {
            errors.push(block.error(model));
        }
    }
    let (at, error) = simplest(&errors)?;
    Some(Validated {
        model: of_all.into_iter().nth(at)?,
        error: error / whole.square().max(1e-300),
    })
}

/// The first whose mean is within one standard error of the least, and its mean.
fn simplest(errors: &[Vec<f64>]) -> Option<(usize, f64)> {
    let mean = |each: &[f64]| each.iter().sum::<f64>() / each.len() as f64;
    let best = errors.iter().min_by(|a, b| mean(a).total_cmp(&mean(b)))?;
    let least = mean(best);
    let squares: Vec<f64> = best.iter().map(|e| (e - least).powi(2)).collect();
    let of_mean = (mean(&squares) / (best.len() as f64 - 1.0).max(1.0)).sqrt();
    let at = errors
        .iter()
        .position(|each| mean(each) <= least + of_mean)?;
    Some((at, mean(&errors[at])))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_simplest_within_a_standard_error_is_taken() {
        let ladder = [
            vec![9.0, 9.0],
            vec![1.25, 2.25],
            vec![1.0, 2.0],
            vec![1.3, 2.3],
        ];
        assert_eq!(simplest(&ladder), Some((1, 1.75)));
        assert_eq!(simplest(&[vec![3.0, 3.0], vec![1.0, 1.0]]), Some((1, 1.0)));
        assert_eq!(simplest(&[]), None);
    }
}
