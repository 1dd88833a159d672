//! Linear regression in information form: the running sums of paper eqs. (20) to (23).

use nalgebra::{Matrix2, SMatrix, SVector};

/// One sample of `target = theta . regressor`, seen through `instrument` (the regressor itself for
/// least squares).
#[derive(Clone, Copy, Debug)]
pub struct Row<const P: usize> {
    pub regressor: [f64; P],
    pub instrument: [f64; P],
    pub target: f64,
}

/// Sums over the samples so far: A = sum zeta phi^T and c = sum zeta z2.
///
/// Paper eqs. (22), (23) propagate G = A^-1 and a^ = A^-1 c; A' = zeta phi^T, c' = zeta z2 is the same
/// equation before the inversion, so that recursive and batch form agree at every sample, and no
/// arbitrary start of G is needed.
#[derive(Clone, Copy, Debug)]
pub struct Information<const P: usize> {
    pub a: SMatrix<f64, P, P>,
    pub c: SVector<f64, P>,
    pub samples: usize,
}

impl<const P: usize> Default for Information<P> {
    fn default() -> Self {
        Self {
            a: SMatrix::zeros(),
            c: SVector::zeros(),
            samples: 0,
        }
    }
}

impl<const P: usize> Information<P> {
    #[inline(always)]
    pub fn add(&mut self, row: &Row<P>) {
        for i in 0..P {
            let z = row.instrument[i];
            self.c[i] += z * row.target;
            for j in 0..P {
                self.a[(i, j)] += z * row.regressor[j];
            }
        }
        self.samples += 1;
    }

    /// A^-1, by scaled rows and columns; nothing where the samples do not determine all unknowns.
    pub fn inverse(&self) -> Option<SMatrix<f64, P, P>> {
        let scale = SVector::<f64, P>::from_fn(|i, _| self.a[(i, i)].abs().sqrt().recip());
        let scaled = SMatrix::<f64, P, P>::from_fn(|i, j| self.a[(i, j)] * scale[i] * scale[j]);
        let inverse = scaled.try_inverse()?;
        let determined = inverse.iter().all(|x| x.abs() < 1e12);
        determined.then(|| SMatrix::from_fn(|i, j| inverse[(i, j)] * scale[i] * scale[j]))
    }

    /// a^ of eq. (21).
    pub fn solve(&self) -> Option<SVector<f64, P>> {
        (self.samples > P).then_some(())?;
        Some(self.inverse()? * self.c)
    }

    /// What the samples say about the first two unknowns once the others are eliminated.
    pub fn on_first_two(&self) -> Option<Matrix2<f64>> {
        let block = self.inverse()?.fixed_view::<2, 2>(0, 0).into_owned();
        block.try_inverse()
    }
}

/// A regression over a whole record.
#[derive(Clone, Debug)]
pub struct Regression<const P: usize> {
    pub theta: SVector<f64, P>,
    /// Covariance of theta that allows for errors correlated over time.
    pub covariance: SMatrix<f64, P, P>,
    /// Mean square of the errors.
    pub variance: f64,
    /// The sums at some samples along the record: (sample, sums).
    pub path: Vec<(usize, Information<P>)>,
}

/// Points kept of the recursive path.
const PATH_POINTS: usize = 300;

/// Regresses over those of `samples` samples at which `row` gives one.
///
/// `lags`: samples over which errors may be correlated (Newey and West, Econometrica 55, 1987, with
/// Bartlett's weights); no more than there are.
pub fn regress<const P: usize>(
    samples: usize,
    lags: usize,
    row: impl Fn(usize) -> Option<Row<P>>,
) -> Option<Regression<P>> {
    let mut information = Information::default();
    let every = samples.div_ceil(PATH_POINTS).max(1);
    let mut path = Vec::with_capacity(PATH_POINTS + 1);
    for start in (0..samples).step_by(every) {
        let end = samples.min(start + every);
        for row in (start..end).filter_map(&row) {
            information.add(&row);
        }
        path.push((end - 1, information));
    }
    let theta = information.solve()?;
    let inverse = information.inverse()?;
    let (meat, squares) = spread(samples, lags.min(samples), &theta, row);
    Some(Regression {
        theta,
        covariance: inverse * meat * inverse.transpose(),
        variance: squares / information.samples as f64,
        path,
    })
}

/// Bartlett-weighted sum of the autocovariances of zeta e, and sum of e^2.
fn spread<const P: usize>(
    samples: usize,
    lags: usize,
    theta: &SVector<f64, P>,
    row: impl Fn(usize) -> Option<Row<P>>,
) -> (SMatrix<f64, P, P>, f64) {
    let width = lags + 1;
    let mut squares = 0.0;
    // With zeros before the first and after the last.
    let mut scores = vec![[0.0; P]; width + samples + lags];
    for (i, score) in scores[width..width + samples].iter_mut().enumerate() {
        if let Some(row) = row(i) {
            let fitted: f64 = (0..P).map(|p| row.regressor[p] * theta[p]).sum();
            let e = row.target - fitted;
            squares += e * e;
            *score = row.instrument.map(|z| z * e);
        }
    }
    // The Bartlett sum is the mean of the squared sums over all windows of lags + 1 samples, the
    // windows that overhang the ends included.
    let mut window = SVector::<f64, P>::zeros();
    let mut meat = SMatrix::<f64, P, P>::zeros();
    for (comes, goes) in scores[width..].iter().zip(&scores) {
        for p in 0..P {
            window[p] += comes[p] - goes[p];
        }
        for p in 0..P {
            for q in 0..=p {
                meat[(p, q)] += window[p] * window[q];
            }
        }
    }
    meat.fill_upper_triangle_with_lower_triangle();
    (meat / width as f64, squares)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use veloid_core::numerics::random::Normal;

    fn rows(n: usize, noise_model: f64, seed: u64) -> Vec<Row<2>> {
        let mut normal = Normal::new(seed);
        let mut e = 0.0;
        let mut x = 0.0;
        (0..n)
            .map(|_| {
                x = noise_model * x + normal.draw();
                e = noise_model * e + normal.draw();
                let regressor = [x, normal.draw()];
                Row {
                    regressor,
                    instrument: regressor,
                    target: 3.0 * regressor[0] - 2.0 * regressor[1] + e,
                }
            })
            .collect()
    }

    /// Eqs. (22), (23) as printed, one sample at a time, from a short batch.
    #[test]
    fn val_recursive_form_of_the_paper_ends_at_the_batch_estimate() {
        let rows = rows(500, 0.5, 3);
        let fit = regress(500, 0, |i| Some(rows[i])).unwrap();
        let mut start = Information::default();
        rows[..10].iter().for_each(|r| start.add(r));
        let (mut g, mut a) = (start.inverse().unwrap(), start.solve().unwrap());
        for r in &rows[10..] {
            let phi = SVector::from(r.regressor);
            let gain = g * phi / (1.0 + (phi.transpose() * g * phi)[0]);
            a += gain * (r.target - phi.dot(&a));
            g -= gain * phi.transpose() * g;
        }
        assert!((a - fit.theta).norm() < 1e-12);
        let (last, end) = fit.path.last().unwrap();
        assert_eq!(*last, 499);
        assert!((end.solve().unwrap() - fit.theta).norm() == 0.0);
        assert!(fit.path.len() <= 301);
    }

    #[test]
    fn window_sums_are_the_bartlett_sum() {
        let (n, lags) = (40, 5);
        let rows = rows(n, 0.6, 9);
        let theta = SVector::from([2.5, -1.0]);
        let (meat, _) = spread(n, lags, &theta, |i| Some(rows[i]));
        let score = |i: usize| {
            let phi = SVector::from(rows[i].regressor);
            phi * (rows[i].target - phi.dot(&theta))
        };
        let mut want = SMatrix::<f64, 2, 2>::zeros();
        for i in 0..n {
            for j in 0..n {
                let lag = i.abs_diff(j);
                if lag <= lags {
                    let weight = 1.0 - lag as f64 / (lags + 1) as f64;
                    want += weight * score(i) * score(j).transpose();
                }
            }
        }
        assert!((meat - want).norm() < 1e-10 * want.norm());
    }

    /// Coloured errors: 95 % intervals cover the truth about as often as they should.
    #[test]
    fn standard_errors_allow_for_colour() {
        let covered = (0..200)
            .filter(|seed| {
                let rows = rows(2000, 0.8, *seed);
                let fit = regress(2000, 40, |i| Some(rows[i])).unwrap();
                (fit.theta[0] - 3.0).abs() < 1.96 * fit.covariance[(0, 0)].sqrt()
            })
            .count();
        assert!((176..=198).contains(&covered), "{covered} of 200");
    }

    /// However short a step is beside the memory.
    #[test]
    fn lags_are_no_more_than_the_samples() {
        let rows = rows(60, 0.5, 4);
        let all = regress(60, 60, |i| Some(rows[i])).unwrap();
        for lags in [61, 3_000_000_000_000, usize::MAX] {
            let fit = regress(60, lags, |i| Some(rows[i])).unwrap();
            assert_eq!(fit.covariance, all.covariance, "{lags}");
        }
    }

    #[test]
    fn unknowns_that_nothing_excites_are_refused() {
        let row = Row {
            regressor: [1.0, 2.0],
            instrument: [1.0, 2.0],
            target: 1.0,
        };
        assert!(regress(50, 0, |_| Some(row)).is_none());
        assert!(regress::<2>(0, 0, |_| Some(row)).is_none());
    }
}
