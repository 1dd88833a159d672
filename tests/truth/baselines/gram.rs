//! Least squares on subsets of columns through tables of inner products, one per block of rows.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};

pub struct Gram {
    products: DMatrix<f64>,
    target: DVector<f64>,
    target_square: f64,
    rows: usize,
}

/// Columns with coefficients.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    pub subset: Vec<usize>,
    pub coefficients: Vec<f64>,
}

/// Divides each column by its root mean square, which is returned.
pub fn to_unit(columns: &mut [Vec<f64>]) -> Vec<f64> {
    let unit = |column: &mut Vec<f64>| {
        let scale = dot(column, column) / column.len().max(1) as f64;
        let scale = scale.sqrt().max(1e-300);
        column.iter_mut().for_each(|value| *value /= scale);
        scale
    };
    columns.iter_mut().map(unit).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

impl Gram {
    pub fn new(columns: &[Vec<f64>], target: &[f64], rows: Range<usize>) -> Self {
        let n = columns.len();
        let target = &target[rows.clone()];
        let of = |i: usize| &columns[i][rows.clone()];
        let mut products = DMatrix::zeros(n, n);
        for i in 0..n {
            for j in 0..=i {
                products[(i, j)] = dot(of(i), of(j));
                products[(j, i)] = products[(i, j)];
            }
        }
        Self {
            products,
            target: DVector::from_fn(n, |i, _| dot(of(i), target)),
            target_square: dot(target, target),
            rows: rows.len(),
        }
    }

    /// One table for each of `count` contiguous parts of the rows.
    pub fn blocks(
        columns: &[Vec<f64>],
        target: &[f64],
        rows: Range<usize>,
        count: usize,
    ) -> Vec<Self> {
        let at = |i: usize| rows.start + rows.len() * i / count;
        (0..count)
            .map(|i| Self::new(columns, target, at(i)..at(i + 1)))
            .collect()
    }

    /// All rows but those of one block.
    pub fn without(blocks: &[Self], left_out: Option<usize>) -> Self {
        let n = blocks.first().map_or(0, |block| block.target.len());
        let mut sum = Self {
            products: DMatrix::zeros(n, n),
            target: DVector::zeros(n),
            target_square: 0.0,
            rows: 0,
        };
        for (i, block) in blocks.iter().enumerate() {
            if Some(i) != left_out {
                sum.products += &block.products;
                sum.target += &block.target;
                sum.target_square += block.target_square;
                sum.rows += block.rows;
            }
        }
        sum
    }

    pub fn fit(&self, subset: &[usize]) -> Option<Model> {
        let n = subset.len();
        let ridge = 1e-10 * self.rows as f64;
        let matrix = DMatrix::from_fn(n, n, |i, j| {
            self.products[(subset[i], subset[j])] + if i == j { ridge } else { 0.0 }
        });
        let right = DVector::from_fn(n, |i, _| self.target[subset[i]]);
        let solution = matrix.cholesky()?.solve(&right);
        Some(Model {
            subset: subset.to_vec(),
            coefficients: solution.iter().copied().collect(),
        })
    }

    /// Mean square that a model leaves of the target on these rows.
    pub fn error(&self, model: &Model) -> f64 {
        let terms = || model.subset.iter().zip(&model.coefficients);
        let mut sum = self.target_square;
        for (&i, a) in terms() {
            let with: f64 = terms().map(|(&j, b)| b * self.products[(i, j)]).sum();
            sum += a * (with - 2.0 * self.target[i]);
        }
        sum.max(1e-300) / self.rows.max(1) as f64
    }

    /// Mean square of the target.
    pub fn square(&self) -> f64 {
        self.target_square / self.rows.max(1) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coefficients_of_a_subset_come_from_the_blocks_that_are_left() {
        let a: Vec<f64> = (0..60).map(|i| (0.3 * i as f64).sin()).collect();
        let b: Vec<f64> = (0..60).map(|i| (0.7 * i as f64).cos()).collect();
        let y: Vec<f64> = a.iter().zip(&b).map(|(a, b)| 2.0 * a - 3.0 * b).collect();
        let mut columns = [a, b];
        let scale = to_unit(&mut columns);
        let blocks = Gram::blocks(&columns, &y, 0..60, 5);
        let model = Gram::without(&blocks, Some(2))
            .fit(&[0, 1])
            .expect("fitted");
        assert!((model.coefficients[0] / scale[0] - 2.0).abs() < 1e-6);
        assert!((model.coefficients[1] / scale[1] + 3.0).abs() < 1e-6);
        assert!(blocks[2].error(&model) < 1e-6 && blocks[2].square() > 0.1);
    }
}
