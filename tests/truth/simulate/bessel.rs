//! The modified Bessel function of the second kind, of order one.

/// x K1(x), 1 at x = 0 (Abramowitz and Stegun 9.8.3, 9.8.7 and 9.8.8; errors below 3e-7).
pub fn x_k1(x: f64) -> f64 {
    if x <= 0.0 {
        return 1.0;
    }
    if x < 2.0 {
        let t = (x / 2.0).powi(2);
        let series = [
            1.0,
            0.15443144,
            -0.67278579,
            -0.18156897,
            -0.01919402,
            -0.00110404,
            -0.00004686,
        ];
        return x * (x / 2.0).ln() * i1(x) + polynomial(&series, t);
    }
    let series = [
        1.25331414,
        0.23498619,
        -0.03655620,
        0.01504268,
        -0.00780353,
        0.00325614,
        -0.00068245,
    ];
    x.sqrt() * (-x).exp() * polynomial(&series, 2.0 / x)
}

/// The modified function of the first kind, up to x = 3.75.
fn i1(x: f64) -> f64 {
    let series = [
        0.5, 0.87890594, 0.51498869, 0.15084934, 0.02658733, 0.00301532, 0.00032411,
    ];
    x * polynomial(&series, (x / 3.75).powi(2))
}

/// Coefficients from the lowest power on.
fn polynomial(coefficients: &[f64], x: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_those_of_the_tables() {
        let table = [
            (0.1, 9.8538447809),
            (1.0, 0.6019072302),
            (2.0, 0.1398658818),
            (5.0, 0.0040446134),
        ];
        for (x, k1) in table {
            assert!((x_k1(x) - x * k1).abs() < 4e-7, "{x}: {}", x_k1(x) / x);
        }
        assert!((x_k1(1e-6) - 1.0).abs() < 1e-9 && x_k1(0.0) == 1.0);
        assert_eq!(x_k1(1e4), 0.0);
    }

    #[test]
    fn both_series_meet() {
        assert!((x_k1(2.0 - 1e-9) - x_k1(2.0)).abs() < 4e-7);
    }
}
