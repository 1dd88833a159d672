//! Whether intervals of k and B contain the truth.

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::share::Share;
use crate::simulate::vehicle::Bike;

pub const AXLES: [&str; 2] = ["front", "rear"];

/// Standard errors in half a 95 % interval.
const HALF: f64 = 1.96;

/// One answer per axle: whether the interval contains the truth, nothing where none was given.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Covered {
    pub stiffness: Vec<Option<bool>>,
    pub damping: Vec<Option<bool>>,
}

impl Covered {
    /// Of the `result` of one ride's report.
    pub fn of_result(report: &Value, bike: &Bike) -> Self {
        let one = |axle: usize, name: &str, truth: f64| {
            let ends = &report["result"][AXLES[axle]][name]["interval"];
            Some((ends[0].as_f64()?..=ends[1].as_f64()?).contains(&truth))
        };
        Self::each(bike, |axle, [k, b]| [one(axle, "k", k), one(axle, "B", b)])
    }

    /// Of estimates with standard errors; `at` gives the estimate of an axle.
    pub fn of_estimates<'a>(at: impl Fn(&str) -> &'a Value, bike: &Bike) -> Self {
        let one = |estimate: &Value, [value, error]: [&str; 2], truth: f64| {
            let off = estimate[value].as_f64()? - truth;
            Some(off.abs() <= HALF * estimate[error].as_f64()?)
        };
        Self::each(bike, |axle, [k, b]| {
            let estimate = at(AXLES[axle]);
            [
                one(estimate, ["k_n_m", "k_std_n_m"], k),
                one(estimate, ["b_n_s_m", "b_std_n_s_m"], b),
            ]
        })
    }

    fn each(bike: &Bike, one: impl Fn(usize, [f64; 2]) -> [Option<bool>; 2]) -> Self {
        let mut all = Self::default();
        for axle in 0..2 {
            let truth = [bike.stiffness_n_m[axle], bike.damping_n_s_m[axle]];
            let [stiffness, damping] = one(axle, truth);
            all.stiffness.push(stiffness);
            all.damping.push(damping);
        }
        all
    }

    pub fn add(&mut self, other: &Covered) {
        self.stiffness.extend(&other.stiffness);
        self.damping.extend(&other.damping);
    }

    /// Columns of a table: k, B, each with how many intervals were withheld.
    pub fn cells(&self) -> String {
        let cell = |answers: &[Option<bool>]| {
            let given = Share::of(answers.iter().flatten().copied());
            match answers.len() - given.of {
                0 => given.to_string(),
                withheld => format!("{given}; {withheld} withheld"),
            }
        };
        format!("{} | {}", cell(&self.stiffness), cell(&self.damping))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::Chance;
    use crate::trial::plan;
    use serde_json::json;

    #[test]
    fn intervals_and_standard_errors_are_read() {
        let bike = Bike {
            stiffness_n_m: [1e5, 9e4],
            damping_n_s_m: [300.0, 500.0],
            ..plan::bike([1e5, 2e5], [1.0, 2.0], &mut Chance::new(1, 0))
        };
        let report = json!({"result": {
            "front": {"k": {"interval": [9e4, 1.1e5]}, "B": {"interval": [310.0, 320.0]}},
            "rear": {"k": {"interval": null}, "B": {"interval": [500.0, 510.0]}}}});
        let covered = Covered::of_result(&report, &bike);
        assert_eq!(covered.stiffness, [Some(true), None]);
        assert_eq!(covered.damping, [Some(false), Some(true)]);
        let estimate =
            json!({"k_n_m": 1.01e5, "k_std_n_m": 1e3, "b_n_s_m": 300.0, "b_std_n_s_m": null});
        let covered = Covered::of_estimates(|_| &estimate, &bike);
        assert_eq!(covered.stiffness, [Some(true), Some(false)]);
        assert_eq!(covered.damping, [None, None]);
        assert!(covered.cells().contains("2 withheld"));
    }
}
