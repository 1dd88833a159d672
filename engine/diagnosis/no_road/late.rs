//! A delay of one accelerometer against the other.

use nalgebra::{Matrix2, Vector2};

use super::nuisance::Course;
use super::record::Record;
use crate::policy;
use veloid_core::bicycle::Axle;

/// Standard deviation of the speed's relative error, and the least one (s) of a knot.
const SPEED: f64 = 0.01;
const KNOT_S: f64 = 1e-3;

/// A sensor that is late.
#[derive(Clone, Copy, Debug)]
pub struct Late {
    pub axle: Axle,
    pub delay_s: f64,
    pub std_error_s: f64,
}

impl Late {
    /// The delay that the courses share, if it is one both by itself and where the speed may be wrong: what goes with the time since the
    /// other wheel is then the speed's error. That split alone is led astray by noise of the speed.
    pub fn of(record: &Record, courses: &[Course]) -> Option<Self> {
        let mut pairs = Vec::new();
        for (segment, course) in record.segments.iter().zip(courses) {
            pairs.extend(
                course
                    .lags(segment)
                    .into_iter()
                    .zip(course.knots.iter().copied()),
            );
        }
        let count = pairs.len().max(1) as f64;
        let mean = pairs.iter().map(|(_, knot)| knot).sum::<f64>() / count;
        let lag = pairs.iter().map(|(lag, _)| lag.abs()).sum::<f64>() / count;
        let (beside_speed, std_error_s) = split(&pairs)?;
        let both = is_late(mean, SPEED * lag) && is_late(beside_speed, std_error_s);
        let other = record.other();
        (both && mean * beside_speed > 0.0).then_some(Self {
            axle: if mean > 0.0 { other } else { record.lead },
            delay_s: mean.abs(),
            std_error_s: std_error_s.min(SPEED * lag),
        })
    }
}

/// The delay beside a part that goes with the time since the other wheel, and its standard error (s).
fn split(pairs: &[(f64, f64)]) -> Option<(f64, f64)> {
    let mut normal = Matrix2::zeros();
    let mut toward = Vector2::zeros();
    for (lag, knot) in pairs {
        let row = Vector2::new(1.0, *lag);
        normal += row * row.transpose();
        toward += row * *knot;
    }
    normal[(1, 1)] += (KNOT_S / SPEED).powi(2);
    let covariance = normal.try_inverse()?;
    let found = covariance * toward;
    let rest = pairs
        .iter()
        .map(|(lag, knot)| (knot - found[0] - found[1] * lag).powi(2));
    let scatter = (rest.sum::<f64>() / pairs.len().max(1) as f64)
        .sqrt()
        .max(KNOT_S);
    Some((found[0], scatter * covariance[(0, 0)].sqrt()))
}

fn is_late(delay_s: f64, std_error_s: f64) -> bool {
    delay_s.abs() > policy::LATE_S.max(policy::LATE_ERRORS * std_error_s)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_delay_is_said_where_it_is_large_and_sure() {
        let sure = policy::LATE_S / policy::LATE_ERRORS;
        assert!(is_late(1.01 * policy::LATE_S, 0.5 * sure));
        assert!(is_late(-1.01 * policy::LATE_S, 0.5 * sure));
        assert!(!is_late(0.99 * policy::LATE_S, 0.5 * sure));
        assert!(!is_late(2.0 * policy::LATE_S, 2.01 * sure));
    }
}
