//! Natural cubic spline.

/// A natural cubic spline through increasing abscissae.
#[derive(Clone, Debug, Default)]
pub struct Spline {
    x: Vec<f64>,
    y: Vec<f64>,
    bend: Vec<f64>,
}

impl Spline {
    /// `x` strictly increasing, at least two points.
    pub fn new(x: &[f64], y: &[f64]) -> Self {
        let n = x.len();
        let (mut bend, mut work) = (vec![0.0; n], vec![0.0; n]);
        for i in 1..n.saturating_sub(1) {
            let share = (x[i] - x[i - 1]) / (x[i + 1] - x[i - 1]);
            let pivot = share * bend[i - 1] + 2.0;
            let change =
                (y[i + 1] - y[i]) / (x[i + 1] - x[i]) - (y[i] - y[i - 1]) / (x[i] - x[i - 1]);
            bend[i] = (share - 1.0) / pivot;
            work[i] = (6.0 * change / (x[i + 1] - x[i - 1]) - share * work[i - 1]) / pivot;
        }
        if n > 0 {
            bend[n - 1] = 0.0;
        }
        for i in (0..n.saturating_sub(1)).rev() {
            bend[i] = bend[i] * bend[i + 1] + work[i];
        }
        Self {
            x: x.to_vec(),
            y: y.to_vec(),
            bend,
        }
    }

    /// Value and derivative; constant beyond the ends.
    pub fn at(&self, x: f64) -> (f64, f64) {
        let last = self.x.len() - 1;
        if x <= self.x[0] || x >= self.x[last] {
            let end = if x <= self.x[0] { 0 } else { last };
            return (self.y[end], 0.0);
        }
        let i = self.x.partition_point(|&k| k <= x) - 1;
        let h = self.x[i + 1] - self.x[i];
        let (a, b) = ((self.x[i + 1] - x) / h, (x - self.x[i]) / h);
        let (p, q) = (self.bend[i], self.bend[i + 1]);
        let value = a * self.y[i]
            + b * self.y[i + 1]
            + ((a * a * a - a) * p + (b * b * b - b) * q) * h * h / 6.0;
        let rate = (self.y[i + 1] - self.y[i]) / h
            + ((3.0 * b * b - 1.0) * q - (3.0 * a * a - 1.0) * p) * h / 6.0;
        (value, rate)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn follows_a_sine_and_its_derivative() {
        let x: Vec<f64> = (0..200).map(|i| 0.1 * i as f64).collect();
        let spline = Spline::new(&x, &x.iter().map(|x| x.sin()).collect::<Vec<_>>());
        for i in 0..1000 {
            let at = 1.0 + 0.018 * i as f64;
            let (value, rate) = spline.at(at);
            assert!(
                (value - at.sin()).abs() < 1e-6 && (rate - at.cos()).abs() < 1e-4,
                "at {at}"
            );
        }
    }
}
