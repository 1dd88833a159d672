//! When an interval says something, and the reason where it does not.

use std::f64::consts::TAU;

use crate::{Estimate, Parameters};
use veloid_core::document::format_number::significant;

/// Largest standard error beside the value itself: from about here on the 95 % interval holds zero and twice the value.
const MOST: f64 = 0.5;
/// Rate of an axle (1/s) that counts as not springing or damping at all: slower than a turn in a second, where bicycles
/// have 5 to 15. A value near zero that is known to within this is known, however large its relative error.
const NOTHING: f64 = TAU;

/// Fastest motion of an axle (radians a sample) that a record shows: nine tenths of what is turned in half a period. Of 15 rides with
/// roads up to 0.45 of 20 Hz, k of those beyond was off by up to 16 %, more than their intervals allow (`veloid-truth make --suite quiet
/// --seed 5`).
const FASTEST: f64 = 0.9 * std::f64::consts::PI;

/// Rate (1/s) of the faster of both motions of an axle, from its k/m and B/m.
pub fn fastest(kappa: f64, beta: f64) -> f64 {
    let (half, square) = (0.5 * beta.abs(), 0.25 * beta * beta - kappa);
    match square > 0.0 {
        true => half + square.sqrt(),
        false => kappa.sqrt(),
    }
}

/// The standard error of a parameter that the ride shows, or why it does not. `nothing` is a size (in the parameter's
/// unit) that is as good as zero.
pub fn identified(
    value: f64,
    std_error: Option<f64>,
    nothing: f64,
    unit: &str,
) -> Result<f64, String> {
    let most = MOST * value.abs().max(nothing);
    match std_error {
        Some(error) if error <= most => Ok(error),
        Some(error) => {
            let of = if value.abs() < nothing {
                format!("{} {unit}, which counts as zero", significant(nothing, 2))
            } else {
                "its value".to_owned()
            };
            Err(format!(
                "its standard error of {} {unit} is more than half of {of}",
                significant(error, 2)
            ))
        }
        None => Err("the fit gives no standard error".to_owned()),
    }
}

/// Why no estimate of a record has an interval.
pub const UNPLACED: &str = "estimated from files whose clocks have an unknown offset to each other";
pub const MISTAKEN: &str = "fix the record or the bicycle data first";
/// Why an estimate has no interval where the diagnosis came to no verdict.
pub const NO_VERDICT: &str = "no verdict on missing physics";

impl Estimate {
    /// The estimate without the intervals that would only pretend, with the reasons.
    pub fn reportable(self) -> Self {
        let mass = self.mass_kg;
        self.reportable_beside([mass * NOTHING * NOTHING, mass * NOTHING])
    }

    /// The estimate with intervals that bear how far k and B may be off, too.
    pub fn widened(self, by: &Parameters) -> Self {
        Self {
            k_std_n_m: self.k_std_n_m.map(|std| std.hypot(by.k_n_m)),
            b_std_n_s_m: self.b_std_n_s_m.map(|std| std.hypot(by.b_n_s_m)),
            ..self
        }
        .reportable()
    }

    /// The same where k (N/m) and B (N s/m) of these sizes are as good as none.
    pub fn reportable_beside(self, [k_nothing, b_nothing]: [f64; 2]) -> Self {
        let k = identified(self.k_n_m, self.k_std_n_m, k_nothing, "N/m");
        let b = identified(self.b_n_s_m, self.b_std_n_s_m, b_nothing, "N s/m");
        Self {
            k_std_n_m: k.as_ref().ok().copied(),
            b_std_n_s_m: b.as_ref().ok().copied(),
            // A reason that is known already shows more than the missing number.
            k_not_identifiable: self.k_not_identifiable.clone().or(k.err()),
            b_not_identifiable: self.b_not_identifiable.clone().or(b.err()),
            ..self
        }
    }

    /// The estimate without intervals where the axle moves faster than samples so far apart (s) could show.
    pub fn within_reach(self, step_s: f64) -> Self {
        if self.mass_kg == 0.0 {
            // A prescribed motion, to which any k and B may answer.
            return self;
        }
        let (kappa, beta) = (self.k_n_m / self.mass_kg, self.b_n_s_m / self.mass_kg);
        if fastest(kappa, beta) * step_s <= FASTEST {
            return self;
        }
        let why = format!(
            "k/m = {} 1/s² with B/m = {} 1/s is faster than the sampling rate of {} Hz can resolve",
            significant(kappa, 2),
            significant(beta, 2),
            significant(1.0 / step_s, 3)
        );
        self.withheld(&why)
    }

    /// The estimate without intervals, and why.
    pub fn withheld(self, why: &str) -> Self {
        Self {
            k_std_n_m: None,
            b_std_n_s_m: None,
            k_not_identifiable: Some(why.to_owned()),
            b_not_identifiable: Some(why.to_owned()),
            ..self
        }
    }

    /// Whether all that every estimate must have is a number.
    pub fn is_finite(&self) -> bool {
        [self.k_n_m, self.b_n_s_m, self.mass_kg]
            .iter()
            .all(|x| x.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reportable(k: f64, k_std: Option<f64>) -> Estimate {
        Estimate {
            k_n_m: k,
            k_std_n_m: k_std,
            b_n_s_m: 1000.0,
            b_std_n_s_m: Some(10.0),
            mass_kg: 25.0,
            ..Estimate::default()
        }
        .reportable()
    }

    #[test]
    fn an_interval_that_says_nothing_is_not_reported_but_why() {
        let wide = reportable(65_879.0, Some(3e20));
        assert_eq!((wide.k_std_n_m, wide.b_std_n_s_m), (None, Some(10.0)));
        assert!(
            wide.k_not_identifiable
                .unwrap_or_default()
                .contains("3.0e20 N/m")
        );
        assert!(wide.b_not_identifiable.is_none());
        assert!(reportable(65_879.0, None).k_not_identifiable.is_some());
    }

    #[test]
    fn the_bound_is_half_of_the_value() {
        assert_eq!(
            reportable(60e3, Some(0.999 * MOST * 60e3)).k_not_identifiable,
            None
        );
        assert!(
            reportable(60e3, Some(1.001 * MOST * 60e3))
                .k_not_identifiable
                .is_some()
        );
    }

    /// A drive has a mass and a damper, and no spring: that is known well, whatever the relative error.
    #[test]
    fn none_of_it_is_known_too() {
        assert_eq!(reportable(0.5, Some(20.0)).k_std_n_m, Some(20.0));
        let nothing = 25.0 * NOTHING * NOTHING;
        assert_eq!(
            reportable(0.5, Some(1.001 * MOST * nothing)).k_std_n_m,
            None
        );
    }

    #[test]
    fn what_is_faster_than_the_samples_has_no_interval() {
        let e = |k: f64, b: f64| Estimate {
            mass_kg: 20.0,
            b_n_s_m: b,
            ..reportable(k, Some(1e-6 * k))
        };
        let shown = |k: f64, b: f64| e(k, b).within_reach(0.01).k_std_n_m.is_some();
        let edge = 20.0 * (FASTEST / 0.01).powi(2);
        assert!(shown(0.999 * edge, 0.0) && !shown(1.001 * edge, 0.0));
        let beyond = e(1.001 * edge, 0.0).within_reach(0.01);
        assert!(
            beyond
                .b_not_identifiable
                .is_some_and(|why| why.contains("100 Hz"))
        );
        assert!(!shown(f64::MAX, 0.0));
        // Without a spring B/m alone is the rate.
        let edge = 20.0 * FASTEST / 0.01;
        assert!(
            shown(0.0, 0.999 * edge) && !shown(0.0, 1.001 * edge) && !shown(0.0, -1.001 * edge)
        );
    }

    #[test]
    fn the_reason_says_what_half_of() {
        let why = |value: f64| {
            identified(value, Some(80.0), 144.0, "N s/m")
                .err()
                .unwrap_or_default()
        };
        assert!(
            why(85.0).contains("half of 140 N s/m, which counts as zero"),
            "{}",
            why(85.0)
        );
        assert!(why(150.0).contains("half of its value"), "{}", why(150.0));
    }
}
