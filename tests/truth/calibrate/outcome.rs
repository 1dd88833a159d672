//! What a binary says of one clean ride.

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::simulate::vehicle::Bike;
use crate::trial::bench::Reported;
use crate::trial::coverage::{AXLES, Covered};

/// A rate of false alarms that few rides show.
pub const LENIENT: f64 = 0.2;

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// A verdict of the report, or what is said where there is none.
    pub verdict: String,
    /// Probability of the mismatch of each axle.
    pub p_values: [Option<f64>; 2],
    /// Whether something is said to be missing at the usual rate of false alarms; nothing where there is no verdict.
    pub alarm: Option<bool>,
    /// The same at [`LENIENT`].
    pub lenient_alarm: Option<bool>,
    pub covered: Covered,
}

impl Outcome {
    pub fn read(report: &Reported, lenient: &Reported, bike: &Bike) -> Self {
        let lenient_alarm = lenient.as_ref().ok().and_then(alarm);
        let report = match report {
            Ok(report) => report,
            Err(said) => {
                return Self {
                    verdict: said.clone(),
                    lenient_alarm,
                    ..Self::default()
                };
            }
        };
        let place = &report["diagnosis"]["where"];
        Self {
            verdict: verdict(report).to_owned(),
            p_values: AXLES.map(|axle| place[axle]["p_value"].as_f64()),
            alarm: alarm(report),
            lenient_alarm,
            covered: Covered::of_result(report, bike),
        }
    }

    /// The smaller p value of its axles.
    pub fn smallest(&self) -> Option<f64> {
        let given = self.p_values.iter().flatten().copied();
        given.reduce(f64::min)
    }
}

fn verdict(report: &Value) -> &str {
    report["diagnosis"]["verdict"].as_str().unwrap_or_default()
}

fn alarm(report: &Value) -> Option<bool> {
    match verdict(report) {
        "nothing_missing" => Some(false),
        "named" | "named_in_part" | "ambiguous" | "unnamed" => Some(true),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::Chance;
    use crate::trial::plan;
    use serde_json::json;

    #[test]
    fn p_values_and_alarms_are_read() {
        let bike = plan::bike([1e5, 2e5], [1.0, 2.0], &mut Chance::new(1, 0));
        let report = |verdict: &str| {
            Ok(json!({"diagnosis": {"verdict": verdict,
                "where": {"front": {"p_value": 0.3}, "rear": {"p_value": 0.04}}}}))
        };
        let outcome = Outcome::read(&report("nothing_missing"), &report("named"), &bike);
        assert_eq!(outcome.smallest(), Some(0.04));
        assert_eq!(
            (outcome.alarm, outcome.lenient_alarm),
            (Some(false), Some(true))
        );
        let outcome = Outcome::read(&report("cannot_tell"), &Err("no".to_owned()), &bike);
        assert_eq!((outcome.alarm, outcome.lenient_alarm), (None, None));
    }
}
