//! Tails of distributions.

/// Upper tail of the chi-square distribution, by Wilson and Hilferty's cube root.
pub fn chi_square_tail(q: f64, freedom: f64) -> f64 {
    if freedom <= 0.0 {
        return 1.0;
    }
    let v = 2.0 / (9.0 * freedom);
    let x = ((q / freedom).cbrt() - (1.0 - v)) / v.sqrt();
    normal_tail(x)
}

/// Upper tail of the normal distribution (Abramowitz & Stegun 7.1.26, absolute error below 1e-7).
pub fn normal_tail(x: f64) -> f64 {
    let t = 1.0 / (1.0 + 0.327_591_1 * x.abs() / std::f64::consts::SQRT_2);
    let series = t
        * (0.254_829_592
            + t * (-0.284_496_736
                + t * (1.421_413_741 + t * (-1.453_152_027 + t * 1.061_405_429))));
    let tail = 0.5 * series * (-0.5 * x * x).exp();
    if x >= 0.0 { tail } else { 1.0 - tail }
}

/// Mean square about the mean; 0 of nothing.
pub fn variance(values: &[f64]) -> f64 {
    let n = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / n;
    values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n
}
