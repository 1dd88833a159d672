//! What a report says of a ride, against the truth.

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::class::Class;
use super::mark::{Judged, Mark, is_named};
use super::ride::Made;
use crate::outcome::{Name, Outcome as Said};
use crate::trial::bench::Reported;
use crate::trial::coverage::{AXLES, Covered};

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    pub mark: Mark,
    /// Whether one set of effects is said to act.
    pub is_named: bool,
    /// Whether it is on the axle of the truth.
    pub axle: Option<bool>,
    /// The verdict and the sets of effects that it offers.
    pub said: String,
    pub covered: Covered,
    pub key: Value,
}

/// What `cannot_tell` says where the model was fitted and failed: no reason to withhold a verdict.
const FAILED: &str = "no pair of axles on one road follows the accelerations";

impl Outcome {
    pub fn read(report: &Reported, class: Class, made: &Made) -> Self {
        let said = match report {
            Ok(report) => Said::read(report, 0.0),
            Err(error) => Said::failed(error.clone(), 0.0),
        };
        let report = report.as_ref().unwrap_or(&Value::Null);
        let covered = Covered::of_result(report, &made.bike);
        let sentence = report["diagnosis"]["sentence"].as_str().unwrap_or_default();
        let judged = Judged {
            class,
            is_clean: made.names.is_empty() && made.key["outside"].is_null(),
            truth: &made.names,
            has_reason: !sentence.is_empty() && !sentence.contains(FAILED),
        };
        let is_named = is_named(&said);
        Self {
            mark: judged.mark(&said, &covered),
            is_named,
            axle: (is_named && !made.names.is_empty())
                .then(|| axles(&said.names()) == axles(&made.names)),
            said: words(&said),
            covered,
            key: made.key.clone(),
        }
    }
}

fn axles(names: &[Name]) -> [bool; 2] {
    AXLES.map(|axle| names.iter().any(|name| name.1 == axle || name.1 == "both"))
}

/// The verdict with the sets that it offers, or the error.
fn words(said: &Said) -> String {
    if let Some(error) = &said.error {
        return format!("failed: {error}");
    }
    match said.verdict.as_str() {
        "named" | "named_in_part" | "ambiguous" => {
            let sets: Vec<String> = said.sets().iter().map(|set| named(set)).collect();
            format!("{} {}", said.verdict, sets.join(" or "))
        }
        verdict => verdict.to_owned(),
    }
}

/// Effects with their axles, in words.
fn named(names: &[Name]) -> String {
    let one = |(id, axle): &Name| format!("{id} {axle}");
    names.iter().map(one).collect::<Vec<_>>().join(" and ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::no_road::mark::said;

    #[test]
    fn words_are_the_verdict_and_its_sets() {
        let offered = said(
            "ambiguous",
            &[&[("a", "front"), ("b", "rear")], &[("c", "rear")]],
        );
        assert_eq!(words(&offered), "ambiguous a front and b rear or c rear");
        assert_eq!(words(&Said::failed("no".to_owned(), 0.0)), "failed: no");
        assert_eq!(axles(&[("x".to_owned(), "both".to_owned())]), [true, true]);
    }
}
