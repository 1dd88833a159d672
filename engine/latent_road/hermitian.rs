//! Small Hermitian matrices, and the numbers that they are made of.

use nalgebra::Complex;

pub type C = Complex<f64>;
pub const ZERO: C = Complex { re: 0.0, im: 0.0 };

/// The lower half; what is above is its conjugate.
#[derive(Clone, Copy, Debug)]
pub struct Hermitian<const M: usize>(pub [[C; M]; M]);

/// Real numbers whose inner product is the trace of a product of two Hermitian matrices.
pub type Numbers<const M: usize> = [[f64; M]; M];

impl<const M: usize> Hermitian<M> {
    pub const ZERO: Self = Self([[ZERO; M]; M]);

    #[inline(always)]
    fn of(entry: impl Fn(usize, usize) -> C) -> Self {
        let mut out = Self::ZERO;
        for i in 0..M {
            for j in 0..=i {
                out.0[i][j] = entry(i, j);
            }
        }
        out
    }

    /// u a^H + a u^H.
    #[inline(always)]
    pub fn pair(u: &[C; M], a: &[C; M]) -> Self {
        Self::of(|i, j| u[i] * a[j].conj() + a[i] * u[j].conj())
    }

    /// h h^H.
    #[inline(always)]
    pub fn square(h: &[C; M]) -> Self {
        Self::of(|i, j| h[i] * h[j].conj())
    }

    #[inline(always)]
    pub fn scaled(&self, by: f64) -> Self {
        Self::of(|i, j| self.0[i][j] * by)
    }

    #[inline(always)]
    pub fn add(&mut self, other: &Self, factor: f64) {
        for i in 0..M {
            for j in 0..=i {
                self.0[i][j] += other.0[i][j] * factor;
            }
        }
    }

    #[inline(always)]
    pub fn numbers(&self) -> Numbers<M> {
        let mut out = [[0.0; M]; M];
        for i in 0..M {
            out[i][i] = self.0[i][i].re;
            for j in 0..i {
                let x = self.0[i][j] * std::f64::consts::SQRT_2;
                (out[i][j], out[j][i]) = (x.re, x.im);
            }
        }
        out
    }
}

#[inline(always)]
pub fn dot<const M: usize>(a: &Numbers<M>, b: &Numbers<M>) -> f64 {
    let mut sum = 0.0;
    for i in 0..M {
        for j in 0..M {
            sum += a[i][j] * b[i][j];
        }
    }
    sum
}

/// Cholesky factor L of the first `size` rows and columns of a positive definite matrix; what is beyond counts as absent.
pub struct Factor<const M: usize> {
    lower: [[C; M]; M],
    /// One over the diagonal.
    per: [f64; M],
    size: usize,
    pub ln_det: f64,
}

impl<const M: usize> Factor<M> {
    /// Nothing where the matrix is not positive definite.
    #[inline(always)]
    pub fn new(s: &Hermitian<M>, size: usize) -> Option<Self> {
        let size = size.min(M);
        let mut out = Self {
            lower: [[ZERO; M]; M],
            per: [0.0; M],
            size,
            ln_det: 0.0,
        };
        for i in 0..size {
            for j in 0..=i {
                let mut sum = s.0[i][j];
                for k in 0..j {
                    sum -= out.lower[i][k] * out.lower[j][k].conj();
                }
                if i > j {
                    out.lower[i][j] = sum * out.per[j];
                } else if sum.re > 0.0 {
                    out.ln_det += sum.re.ln();
                    out.per[i] = sum.re.sqrt().recip();
                } else {
                    return None;
                }
            }
        }
        Some(out)
    }

    /// L^-1 b.
    #[inline(always)]
    pub fn solve(&self, b: &[C; M]) -> [C; M] {
        let mut y = [ZERO; M];
        for i in 0..self.size {
            let mut sum = b[i];
            for k in 0..i {
                sum -= self.lower[i][k] * y[k];
            }
            y[i] = sum * self.per[i];
        }
        y
    }

    /// L^-1 D L^-H.
    #[inline(always)]
    pub fn whiten(&self, d: &Hermitian<M>) -> Numbers<M> {
        let mut left = [[ZERO; M]; M];
        for j in 0..self.size {
            for i in 0..self.size {
                let mut sum = if i >= j { d.0[i][j] } else { d.0[j][i].conj() };
                for k in 0..i {
                    sum -= self.lower[i][k] * left[k][j];
                }
                left[i][j] = sum * self.per[i];
            }
        }
        let mut both = Hermitian::ZERO;
        for i in 0..self.size {
            for j in 0..=i {
                let mut sum = left[i][j];
                for k in 0..j {
                    sum -= both.0[i][k] * self.lower[j][k].conj();
                }
                both.0[i][j] = sum * self.per[j];
            }
        }
        both.numbers()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn c(re: f64, im: f64) -> C {
        Complex::new(re, im)
    }

    #[test]
    fn whitening_by_its_own_factor_leaves_the_unit() {
        let h = [c(1.0, 0.5), c(-0.3, 2.0), c(0.7, 0.0)];
        let mut s = Hermitian::square(&h);
        for i in 0..3 {
            s.0[i][i] += 0.5 + i as f64;
        }
        let factor = Factor::new(&s, 3).unwrap();
        let unit = factor.whiten(&s);
        for i in 0..3 {
            for j in 0..3 {
                let want = if i == j { 1.0 } else { 0.0 };
                assert!((unit[i][j] - want).abs() < 1e-12, "{unit:?}");
            }
        }
        // tr(S^-1 h h^H) = h^H S^-1 h.
        let y = factor.solve(&h);
        let trace = dot(&factor.whiten(&Hermitian::square(&h)), &unit);
        let want: f64 = y.iter().map(|y| y.norm_sqr()).sum();
        assert!((trace - want).abs() < 1e-12);
        assert!(Factor::new(&Hermitian::<3>::ZERO, 3).is_none());
    }

    #[test]
    fn inner_products_are_traces() {
        let (a, b) = ([c(1.0, 2.0), c(0.5, -1.0)], [c(-0.4, 0.1), c(2.0, 0.3)]);
        let x = Hermitian::square(&a).numbers();
        let y = Hermitian::square(&b).numbers();
        let inner: C = (0..2).map(|i| a[i].conj() * b[i]).sum();
        assert!((dot(&x, &y) - inner.norm_sqr()).abs() < 1e-12);
    }
}
