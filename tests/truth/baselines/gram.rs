//! Least squares on subsets of columns through one table of inner products.

use nalgebra::{DMatrix, DVector};

pub struct Gram {
    products: DMatrix<f64>,
    target: DVector<f64>,
    target_square: f64,
    scale: Vec<f64>,
    pub rows: usize,
}

impl Gram {
    /// Columns are scaled to unit root mean square first.
    pub fn new(columns: &[Vec<f64>], target: &[f64]) -> Self {
        let rows = target.len();
        let rms = |y: &[f64]| {
            (y.iter().map(|v| v * v).sum::<f64>() / rows as f64)
                .sqrt()
                .max(1e-300)
        };
        let scale: Vec<f64> = columns.iter().map(|c| rms(c)).collect();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        let n = columns.len();
        let mut products = DMatrix::zeros(n, n);
        for i in 0..n {
            for j in 0..=i {
                let p = dot(&columns[i], &columns[j]) / (scale[i] * scale[j]);
                products[(i, j)] = p;
                products[(j, i)] = p;
            }
        }
        let with_target = DVector::from_iterator(
            n,
            columns.iter().zip(&scale).map(|(c, s)| dot(c, target) / s),
        );
        Self {
            products,
            target: with_target,
            target_square: dot(target, target),
            scale,
            rows,
        }
    }

    /// Coefficients for unit-rms columns and the residual sum of squares of a subset.
    pub fn fit(&self, subset: &[usize]) -> Option<(Vec<f64>, f64)> {
        let n = subset.len();
        let ridge = 1e-10 * self.rows as f64;
        let matrix = DMatrix::from_fn(n, n, |i, j| {
            self.products[(subset[i], subset[j])] + if i == j { ridge } else { 0.0 }
        });
        let right = DVector::from_fn(n, |i, _| self.target[subset[i]]);
        let solution = matrix.cholesky()?.solve(&right);
        let rss = (self.target_square - solution.dot(&right)).max(1e-300);
        Some((solution.iter().copied().collect(), rss))
    }

    /// Root mean square of the target.
    pub fn target_rms(&self) -> f64 {
        (self.target_square / self.rows as f64).sqrt()
    }

    /// The factor by which a column was divided.
    pub fn scale(&self, column: usize) -> f64 {
        self.scale[column]
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn recovers_coefficients_of_a_subset() {
        let a: Vec<f64> = (0..50).map(|i| (0.3 * i as f64).sin()).collect();
        let b: Vec<f64> = (0..50).map(|i| (0.7 * i as f64).cos()).collect();
        let y: Vec<f64> = a.iter().zip(&b).map(|(a, b)| 2.0 * a - 3.0 * b).collect();
        let gram = Gram::new(&[a, b], &y);
        let (c, rss) = gram.fit(&[0, 1]).unwrap();
        assert!(
            (c[0] / gram.scale(0) - 2.0).abs() < 1e-6 && (c[1] / gram.scale(1) + 3.0).abs() < 1e-6
        );
        assert!(rss < 1e-6);
    }
}
