//! Whether a fit is the one answer of its record: at rest, and better than every other minimum that was found.

use super::problem::{AxleFit, Problem};
use super::split::Split;
use crate::simulate::sensitivity::walk;
use veloid_core::document::format_number::{WIDE, significant};
use veloid_core::plant::{Coefficient, Coefficients};

/// Parts of a record whose differences are taken as independent, as for the p values of axles.
const PARTS: usize = 40;

/// Most distance to the minimum, in standard errors, of a fit that has converged.
const AT_REST: f64 = 0.1;

/// Share of the measurement's squares that rounding leaves.
const ROUNDING: f64 = 1e-12;

/// Descents whose k and B are within this share ended in one minimum.
const SAME: f64 = 0.01;

/// Why k and B of a fit are none: squares that a whole step would still gain, of `squares` left on `samples` and of a measurement with
/// squares of `measured`.
pub fn not_at_rest(gain: f64, squares: f64, samples: usize, measured: f64) -> Option<String> {
    let distance = (gain / (squares / samples.max(1) as f64)).sqrt();
    let moves = gain > ROUNDING * measured && distance > AT_REST;
    moves.then(|| {
        format!(
            "the fit did not converge: it is {} standard errors from where it leads, expected at most {AT_REST}",
            significant(distance, 2)
        )
    })
}

impl Problem<'_> {
    /// The fit, with the reason why its k and B are none where one of `others`, minima of the same cost, lies outside of its intervals
    /// and fits no worse than the record can tell (Diebold & Mariano 1995, doi:10.1080/07350015.1995.10524599).
    pub fn alone(&self, fit: AxleFit, others: &[Coefficients], split: &Split) -> AxleFit {
        let rival = others
            .iter()
            .find(|other| is_elsewhere(&fit, other) && !self.is_better(&fit, other, split));
        match rival {
            Some(other) if fit.undetermined.is_none() => AxleFit {
                undetermined: Some(self.rival(other)),
                ..fit
            },
            _ => fit,
        }
    }

    fn rival(&self, other: &Coefficients) -> String {
        let m = 1.0 / other.per_mass;
        format!(
            "another minimum fits as well, with k = {} N/m and B = {} N s/m: check masses, units and clocks, and start with more trials",
            significant(other.kappa * m, 3),
            significant(other.beta * m, 3)
        )
    }

    /// Whether the squares that a fit leaves are surely fewer than those of the other.
    fn is_better(&self, fit: &AxleFit, other: &Coefficients, split: &Split) -> bool {
        let mut more = vec![0.0; split.train.end];
        walk(&self.input, other, split.train.end, |i, z, _| {
            if self.record.valid[i] {
                more[i] = (self.record.output()[i] - z).powi(2) - fit.residual[i].powi(2);
            }
        });
        let parts = more.chunks(more.len().div_ceil(PARTS).max(1));
        let sums: Vec<f64> = parts.map(|part| part.iter().sum()).collect();
        let n = sums.len() as f64;
        let mean = sums.iter().sum::<f64>() / n;
        let variance = sums.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / (n - 1.0);
        mean > WIDE * (variance / n).sqrt()
    }
}

/// Whether k or B of another minimum is outside of a fit's interval, and by more than rounding in a descent.
fn is_elsewhere(fit: &AxleFit, other: &Coefficients) -> bool {
    [Coefficient::Kappa, Coefficient::Beta]
        .into_iter()
        .enumerate()
        .any(|(a, c)| {
            let (own, other) = (fit.plain.get(c), other.get(c));
            let by = (other - own).abs();
            by > WIDE * fit.covariance[(a, a)].max(0.0).sqrt()
                && by > SAME * own.abs().max(other.abs())
        })
}
