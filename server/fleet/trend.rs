//! A straight line through a bicycle's history: slow wear, a tyre losing pressure.

use serde::Serialize;
use statrs::distribution::{ContinuousCDF, StudentsT};
use utoipa::ToSchema;

use super::weighted;

const DAY_MS: f64 = 86_400_000.0;
/// Fewest rides that a line is drawn through.
const LEAST: usize = 4;

/// Slope of the weighted least-squares line.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct Trend {
    /// Change per day, in the parameter's unit.
    pub per_day: f64,
    pub std_error: f64,
    /// Chance of so steep a line if nothing changed.
    pub p_value: f64,
}

impl Trend {
    /// `points`: time (epoch ms), value, standard deviation. None where there are too few, or all at
    /// one time. The slope's error comes from the scatter about the line.
    pub fn of(points: &[(i64, f64, f64)]) -> Option<Self> {
        if points.len() < LEAST {
            return None;
        }
        let first = points[0].0;
        let day = |ms: i64| (ms - first) as f64 / DAY_MS;
        let weight = |deviation: f64| deviation.powi(-2);
        let (t, _) = weighted(points.iter().map(|(ms, _, s)| (day(*ms), weight(*s))));
        let (y, _) = weighted(points.iter().map(|(_, value, s)| (*value, weight(*s))));
        let (mut spread, mut product) = (0.0, 0.0);
        for (ms, value, s) in points {
            spread += weight(*s) * (day(*ms) - t).powi(2);
            product += weight(*s) * (day(*ms) - t) * (value - y);
        }
        if spread <= 0.0 {
            return None;
        }
        let slope = product / spread;
        let left = |(ms, value, s): &(i64, f64, f64)| {
            weight(*s) * (value - y - slope * (day(*ms) - t)).powi(2)
        };
        let freedom = (points.len() - 2) as f64;
        let scatter = points.iter().map(left).sum::<f64>() / freedom;
        let std_error = (scatter / spread).sqrt();
        let student = StudentsT::new(0.0, 1.0, freedom).ok()?;
        let p_value = match slope == 0.0 {
            true => 1.0,
            false => 2.0 * student.sf((slope / std_error).abs()),
        };
        Some(Self {
            per_day: slope,
            std_error,
            p_value,
        })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    const DAY: i64 = 86_400_000;

    #[test]
    fn a_steady_loss_is_found_and_scatter_is_not() {
        let noise = [0.4, -0.3, 0.1, -0.5, 0.2, 0.3, -0.2, 0.0];
        let ride = |slope: f64| {
            let point = |(i, e): (usize, &f64)| (i as i64 * DAY, 100.0 + slope * i as f64 + e, 0.4);
            Trend::of(&noise.iter().enumerate().map(point).collect::<Vec<_>>()).unwrap()
        };
        let losing = ride(-2.0);
        assert!((losing.per_day + 2.0).abs() < 3.0 * losing.std_error && losing.p_value < 1e-4);
        assert!(ride(0.0).p_value > 0.05);
    }

    #[test]
    fn too_little_gives_no_line() {
        assert_eq!(Trend::of(&[(0, 1.0, 1.0); 3]), None);
        assert_eq!(Trend::of(&[(7, 1.0, 1.0); 5]), None);
    }
}
