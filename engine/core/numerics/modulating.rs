//! A window that is zero with its first derivatives at both ends: what is multiplied by it and integrated by parts needs no
//! derivative of the record (modulating functions: Shinbrot 1957, Trans. ASME 79:587-603).

use nalgebra::{SMatrix, SVector};

/// (1 - s^2)^4 and its first two derivatives by s, for s from -1 to 1.
pub fn window(s: f64) -> [f64; 3] {
    let q = 1.0 - s * s;
    [
        q.powi(4),
        -8.0 * s * q.powi(3),
        -8.0 * q.powi(3) + 48.0 * s * s * q * q,
    ]
}

/// Windows of one width, each half over the one before. Time is counted in samples.
pub struct Windows {
    half: usize,
    shape: Vec<[f64; 3]>,
}

impl Windows {
    /// Windows of `half` samples to both sides of their middle.
    pub fn new(half: usize) -> Self {
        let reach = half as f64;
        let shape = (0..2 * half + 1)
            .map(|j| window(j as f64 / reach - 1.0))
            .map(|[phi, slope, curve]| [phi, -slope / reach, curve / (reach * reach)])
            .collect();
        Self { half, shape }
    }

    /// First samples of the windows in which every sample is valid.
    pub fn places(&self, valid: &[bool]) -> Vec<usize> {
        let width = self.shape.len();
        (0..valid.len().saturating_sub(width))
            .step_by(self.half)
            .filter(|first| valid[*first..first + width].iter().all(|v| *v))
            .collect()
    }

    /// What the window from sample `first` on sees of a record, of its rate and of its second derivative.
    pub fn see(&self, record: &[f64], first: usize) -> [f64; 3] {
        let mut sums = [0.0; 3];
        for (shape, x) in self.shape.iter().zip(&record[first..]) {
            for (sum, weight) in sums.iter_mut().zip(shape) {
                *sum += weight * x;
            }
        }
        sums
    }

    /// What every window sees of a constant 1.
    pub fn one(&self) -> f64 {
        self.shape.iter().map(|[phi, ..]| phi).sum()
    }
}

/// A regression on some columns.
pub struct Regression<const N: usize> {
    /// Squares that it leaves of the rows that were not fitted.
    pub left: f64,
    /// Coefficient of each column; zero of those that were not asked.
    pub by: [f64; N],
}

/// Regresses the last number of each row on those in some `columns`, over the first `fitted` rows.
pub fn regress<const N: usize>(
    rows: &[[f64; N]],
    fitted: usize,
    columns: &[usize],
) -> Option<Regression<N>> {
    let size = |q: usize| rows.iter().map(|r| r[q] * r[q]).sum::<f64>().sqrt();
    let sizes: [f64; N] = std::array::from_fn(size);
    let used = |q: usize| columns.contains(&q) && sizes[q] > 0.0;
    let mut matrix = SMatrix::<f64, N, N>::identity();
    let mut target = SVector::<f64, N>::zeros();
    for p in (0..N).filter(|q| used(*q)) {
        let of = |row: &[f64; N], q: usize| row[q] / sizes[q];
        target[p] = rows[..fitted].iter().map(|r| of(r, p) * r[N - 1]).sum();
        for q in (0..N).filter(|q| used(*q)) {
            matrix[(p, q)] = rows[..fitted].iter().map(|r| of(r, p) * of(r, q)).sum();
        }
    }
    let solution = matrix.cholesky()?.solve(&target);
    let by: [f64; N] = std::array::from_fn(|q| if used(q) { solution[q] / sizes[q] } else { 0.0 });
    let error = |r: &[f64; N]| r[N - 1] - (0..N).map(|q| by[q] * r[q]).sum::<f64>();
    let left: f64 = rows[fitted..].iter().map(|r| error(r).powi(2)).sum();
    left.is_finite().then_some(Regression { left, by })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_windows_derivatives_are_its_own() {
        let h = 1e-5;
        for s in [-0.8, -0.3, 0.0, 0.45, 0.9] {
            let ([_, slope, curve], [a, da, _], [b, db, _]) =
                (window(s), window(s - h), window(s + h));
            assert!((slope - (b - a) / (2.0 * h)).abs() < 1e-8);
            assert!((curve - (db - da) / (2.0 * h)).abs() < 1e-7);
        }
        assert_eq!(window(1.0), [0.0, 0.0, 0.0]);
    }
}
