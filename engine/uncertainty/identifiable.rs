//! When an interval says something, and the reason where it does not.

use std::f64::consts::TAU;

use crate::document::format_number::significant;
use crate::report::Estimate;

/// Largest standard error beside the value itself: from about here on the 95 % interval holds zero and twice the value.
const MOST: f64 = 0.5;
/// Rate of an axle (1/s) that counts as not springing or damping at all: slower than a turn in a second, where bicycles
/// have 5 to 15. A value near zero that is known to within this is known, however large its relative error.
const NOTHING: f64 = TAU;

/// The standard error of a parameter that the ride shows, or why it does not. `nothing` is a size (in the parameter's
/// unit) that is as good as zero.
pub(crate) fn identified(
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
                format!("{} {unit}, which counts as none", significant(nothing, 2))
            } else {
                "what it amounts to".to_owned()
            };
            Err(format!(
                "its standard error of {} {unit} is beyond half of {of}",
                significant(error, 2)
            ))
        }
        None => Err("the fit gives it no standard error".to_owned()),
    }
}

/// Why no estimate of a record has an interval.
pub(crate) const UNPLACED: &str =
    "the files that it rests on have clocks of which nobody knows how they go beside each other";
pub(crate) const MISTAKEN: &str = "the record or the bicycle has to be mended first";
/// Why an estimate has no interval where the diagnosis came to no verdict.
pub const NO_VERDICT: &str = "the record carries no verdict on what is missing beside it";

impl Estimate {
    /// The estimate without the intervals that would only pretend, with the reasons.
    pub(crate) fn reportable(self) -> Self {
        let mass = self.mass_kg;
        self.reportable_beside([mass * NOTHING * NOTHING, mass * NOTHING])
    }

    /// The same where k (N/m) and B (N s/m) of these sizes are as good as none.
    pub(crate) fn reportable_beside(self, [k_nothing, b_nothing]: [f64; 2]) -> Self {
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

    /// The estimate without intervals where k/m (1/s^2) or B/m (1/s) is beyond the `most` that any sample could show.
    pub(crate) fn within_reach(self, [most_kappa, most_beta]: [f64; 2]) -> Self {
        if self.mass_kg == 0.0 {
            // A prescribed motion, to which any k and B may answer.
            return self;
        }
        let (kappa, beta) = (self.k_n_m / self.mass_kg, self.b_n_s_m / self.mass_kg);
        if kappa.abs() <= most_kappa && beta.abs() <= most_beta {
            return self;
        }
        let why = format!(
            "k/m = {} 1/s² with B/m = {} 1/s is faster than the samples can tell",
            significant(kappa, 2),
            significant(beta, 2)
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
    pub(crate) fn is_finite(&self) -> bool {
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
        let most = crate::output_error::most(0.01);
        let e = |k: f64| Estimate {
            mass_kg: 20.0,
            ..reportable(k, Some(1e-6 * k))
        };
        let edge = 20.0 * most[0];
        assert!(e(0.999 * edge).within_reach(most).k_std_n_m.is_some());
        let beyond = e(1.001 * edge).within_reach(most);
        assert!(beyond.k_std_n_m.is_none() && beyond.b_not_identifiable.is_some());
        assert!(e(f64::MAX).within_reach(most).k_std_n_m.is_none());
    }

    #[test]
    fn the_reason_says_what_half_of() {
        let why = |value: f64| {
            identified(value, Some(80.0), 144.0, "N s/m")
                .err()
                .unwrap_or_default()
        };
        assert!(
            why(85.0).contains("half of 140 N s/m, which counts as none"),
            "{}",
            why(85.0)
        );
        assert!(
            why(150.0).contains("half of what it amounts to"),
            "{}",
            why(150.0)
        );
    }
}
