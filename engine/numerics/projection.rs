//! Inner products, orthonormal bases and projections.

use super::lanes::{LANES, widest};

pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    widest(
        #[inline(always)]
        || {
            // Sums that do not wait for each other.
            const SUMS: usize = 4;
            let (a, a_rest) = a.as_chunks::<{ SUMS * LANES }>();
            let (b, b_rest) = b.as_chunks::<{ SUMS * LANES }>();
            let mut sums = [0.0; SUMS * LANES];
            for (a, b) in a.iter().zip(b) {
                for (sum, (a, b)) in sums.iter_mut().zip(a.iter().zip(b)) {
                    *sum += a * b;
                }
            }
            let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
            sums.iter().sum::<f64>() + rest
        },
    )
}

/// What is left of `x` outside the span of an orthonormal basis.
pub fn without(x: &[f64], basis: &[Vec<f64>]) -> Vec<f64> {
    let mut left = x.to_vec();
    // Twice, against rounding.
    for _ in 0..2 {
        for b in basis {
            let along = dot(&left, b);
            widest(
                #[inline(always)]
                || left.iter_mut().zip(b).for_each(|(x, b)| *x -= along * b),
            );
        }
    }
    left
}

/// Orthonormal basis of the columns outside the span of `beyond`; dependent ones are dropped.
pub fn orthonormal(columns: Vec<Vec<f64>>, beyond: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for column in columns {
        let size = dot(&column, &column);
        let mut left = without(&without(&column, beyond), &basis);
        let rest = dot(&left, &left);
        if rest > 1e-10 * size && rest.is_finite() {
            let per = rest.sqrt().recip();
            left.iter_mut().for_each(|x| *x *= per);
            basis.push(left);
        }
    }
    basis
}
