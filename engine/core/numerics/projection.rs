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

/// Inner products of one vector with four as long, each sample of which is read once.
pub fn dots(x: &[f64], ys: [&[f64]; 4]) -> [f64; 4] {
    widest(
        #[inline(always)]
        || {
            let (x, x_rest) = x.as_chunks::<LANES>();
            let [a, b, c, d] = ys.map(|y| y.as_chunks::<LANES>());
            let mut sums = [[0.0; LANES]; 4];
            let each = x.iter().zip(a.0).zip(b.0).zip(c.0).zip(d.0);
            for ((((x, a), b), c), d) in each {
                for lane in 0..LANES {
                    sums[0][lane] += x[lane] * a[lane];
                    sums[1][lane] += x[lane] * b[lane];
                    sums[2][lane] += x[lane] * c[lane];
                    sums[3][lane] += x[lane] * d[lane];
                }
            }
            let rests = [a.1, b.1, c.1, d.1];
            std::array::from_fn(|i| {
                let rest: f64 = x_rest.iter().zip(rests[i]).map(|(x, y)| x * y).sum();
                sums[i].iter().sum::<f64>() + rest
            })
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_inner_products_at_once_are_those_one_by_one() {
        let wave =
            |k: usize| -> Vec<f64> { (0..83).map(|i| (0.3 * (i * k) as f64).sin()).collect() };
        let (x, ys) = (wave(1), [2, 3, 5, 7].map(wave));
        let found = dots(&x, std::array::from_fn(|i| ys[i].as_slice()));
        for (found, y) in found.iter().zip(&ys) {
            assert!((found - dot(&x, y)).abs() < 1e-12);
        }
    }
}
