//! The residual's colour: an autoregressive model e_n = -sum a_j e_{n-j} + w_n, used to whiten
//! residuals and to give standard errors that do not assume white noise.

/// Autoregressive model of a residual.
#[derive(Clone, Debug, PartialEq)]
pub struct NoiseModel {
    /// a_1 .. a_p.
    pub a: Vec<f64>,
    /// Variance of the innovations w.
    pub variance: f64,
}

/// Largest order tried.
const MAX_ORDER: usize = 20;

impl NoiseModel {
    pub fn white(variance: f64) -> Self {
        Self {
            a: Vec::new(),
            variance,
        }
    }

    /// White noise as strong as this.
    pub fn bleached(&self) -> Self {
        Self::white(self.total_variance())
    }

    /// Burg's method, the order by Akaike's criterion; takes `residual` as it is, mean included.
    pub fn fit(residual: &[f64]) -> Self {
        Self::burg(residual, MAX_ORDER.min(residual.len() / 20), true)
    }

    /// Burg's method of the given order.
    pub fn of_order(residual: &[f64], order: usize) -> Self {
        Self::burg(residual, order.min(residual.len() / 4), false)
    }

    fn burg(residual: &[f64], most: usize, by_akaike: bool) -> Self {
        let n = residual.len();
        let mut error = residual.iter().map(|x| x * x).sum::<f64>() / n.max(1) as f64;
        let mut best = Self::white(error);
        if !(error > 0.0) {
            return best;
        }
        let mut best_score = n as f64 * error.ln();
        let (mut forward, mut backward) = (residual.to_vec(), residual.to_vec());
        let mut a: Vec<f64> = Vec::new();
        for order in 1..=most {
            let (mut num, mut den) = (0.0, 0.0);
            for i in order..n {
                num += forward[i] * backward[i - 1];
                den += forward[i] * forward[i] + backward[i - 1] * backward[i - 1];
            }
            if !(den > 0.0) {
                break;
            }
            let k = -2.0 * num / den;
            let old = a.clone();
            for (j, a) in a.iter_mut().enumerate() {
                *a += k * old[order - 2 - j];
            }
            a.push(k);
            for i in (order..n).rev() {
                let (f, b) = (forward[i], backward[i - 1]);
                forward[i] = f + k * b;
                backward[i] = b + k * f;
            }
            error *= 1.0 - k * k;
            if !(error > 0.0) {
                break;
            }
            let score = n as f64 * error.ln() + 2.0 * order as f64;
            if score < best_score || !by_akaike {
                best_score = score;
                best = Self {
                    a: a.clone(),
                    variance: error,
                };
            }
        }
        best
    }

    /// Variance of the coloured noise itself: the innovations' through the model's impulse response.
    pub fn total_variance(&self) -> f64 {
        let mut h: Vec<f64> = vec![1.0];
        let mut sum = 1.0;
        for _ in 0..5000 {
            let next: f64 = -self
                .a
                .iter()
                .zip(h.iter().rev())
                .map(|(a, h)| a * h)
                .sum::<f64>();
            sum += next * next;
            h.push(next);
            if h.len() > 200 && h[h.len() - 20..].iter().all(|x| x.abs() < 1e-8) {
                break;
            }
        }
        self.variance * sum
    }

    /// w_n = e_n + sum a_j e_{n-j}; samples before the first count as zero.
    pub fn whiten(&self, e: &[f64]) -> Vec<f64> {
        (0..e.len())
            .map(|i| {
                let past: f64 = self
                    .a
                    .iter()
                    .zip(e[..i].iter().rev())
                    .map(|(a, e)| a * e)
                    .sum();
                e[i] + past
            })
            .collect()
    }

    /// The transpose of the colouring filter 1/A applied to `x`: runs backwards in time.
    pub fn noise_model_transposed(&self, x: &[f64]) -> Vec<f64> {
        let n = x.len();
        let mut y = x.to_vec();
        for i in (0..n).rev() {
            let later: f64 = self
                .a
                .iter()
                .zip(y[i + 1..].iter())
                .map(|(a, y)| a * y)
                .sum();
            y[i] -= later;
        }
        y
    }

    /// Noise of this colour from white `w` of unit variance.
    pub fn noise_model(&self, w: &[f64]) -> Vec<f64> {
        let s = self.variance.sqrt();
        let mut e: Vec<f64> = Vec::with_capacity(w.len());
        for w in w {
            let past: f64 = self.a.iter().zip(e.iter().rev()).map(|(a, e)| a * e).sum();
            e.push(s * w - past);
        }
        e
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(n: usize) -> Vec<f64> {
        let mut state = 7_u64;
        (0..n)
            .map(|_| {
                (0..12)
                    .map(|_| {
                        state = state
                            .wrapping_mul(6364136223846793005)
                            .wrapping_add(1442695040888963407);
                        (state >> 11) as f64 / (1_u64 << 53) as f64
                    })
                    .sum::<f64>()
                    - 6.0
            })
            .collect()
    }

    #[test]
    fn finds_the_model_that_made_the_noise() {
        let truth = NoiseModel {
            a: vec![-1.2, 0.5],
            variance: 0.04,
        };
        let e = truth.noise_model(&noise(20_000));
        let found = NoiseModel::fit(&e);
        assert!(
            (found.a[0] + 1.2).abs() < 0.03 && (found.a[1] - 0.5).abs() < 0.03,
            "{found:?}"
        );
        assert!((found.variance / 0.04 - 1.0).abs() < 0.05);
        let w = truth.whiten(&e);
        assert!((w.iter().map(|x| x * x).sum::<f64>() / w.len() as f64 / 0.04 - 1.0).abs() < 0.05);
    }

    #[test]
    fn transposed_filter_is_the_transpose() {
        let c = NoiseModel {
            a: vec![-0.9, 0.3],
            variance: 1.0,
        };
        let (x, y) = (noise(50), noise(100)[50..].to_vec());
        let inner = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        assert!(
            (inner(&c.noise_model(&x), &y) - inner(&x, &c.noise_model_transposed(&y))).abs()
                < 1e-10
        );
    }
}
