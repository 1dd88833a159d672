//! What cannot be known is `None`, never a number that is none.

/// The number, if it is one.
pub fn finite(x: f64) -> Option<f64> {
    x.is_finite().then_some(x)
}

/// The standard error to a variance, which rounding may have made slightly negative.
pub fn std_error(variance: f64) -> Option<f64> {
    finite(variance).map(|v| v.max(0.0).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_variance_that_is_no_number_has_no_root() {
        assert_eq!(std_error(4.0), Some(2.0));
        assert_eq!(std_error(-1e-20), Some(0.0));
        assert_eq!(std_error(f64::NAN), None);
        assert_eq!(std_error(f64::INFINITY), None);
    }
}
