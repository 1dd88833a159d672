//! What a clean ride promises to show, and what comes of an effect of that size.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::outcome::Outcome as Said;
use crate::simulate::effect::{Axle, Effect, Kind};
use crate::trial::bench::Reported;
use crate::trial::share::Share;

/// Effects of which the size is all there is, so that a report that gives it gives the whole effect.
pub const EFFECTS: [Kind; 5] = [
    Kind::CoulombFriction,
    Kind::QuadraticDamping,
    Kind::CubicStiffness,
    Kind::AsymmetricDamping,
    Kind::SensorDelay,
];

/// Probability with which an effect of the size that reports call detectable is promised to show.
const PROMISED: f64 = 0.95;

/// Sizes that a report calls detectable, of ids and axles joined by a space; empty where something is missing already.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Detectable(BTreeMap<String, f64>);

impl Detectable {
    pub fn read(report: &Reported) -> Self {
        let Some(diagnosis) = report.as_ref().ok().map(|report| &report["diagnosis"]) else {
            return Self::default();
        };
        if diagnosis["verdict"] != "nothing_missing" {
            return Self::default();
        }
        let listed = diagnosis["detectable"].as_array().into_iter().flatten();
        let sizes = listed.filter_map(|one| {
            let (id, axle) = (one["id"].as_str()?, one["axle"].as_str()?);
            Some((format!("{id} {axle}"), one["smallest_detectable"].as_f64()?))
        });
        Self(sizes.collect())
    }

    /// The effect `times` as large as detectable.
    pub fn effect(&self, kind: Kind, axle: Axle, times: f64) -> Option<Effect> {
        let size = self.0.get(&format!("{} {}", kind.id(), axle.name()))?;
        Some(Effect::new(kind, axle, &[times * size]))
    }
}

/// What comes of one ride with an effect.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    pub verdict: String,
    /// Whether the axle is said to have something missing.
    pub shown: bool,
    /// Whether this effect is named, alone or in a set.
    pub named: bool,
}

impl Outcome {
    pub fn read(report: &Reported, effect: &Effect) -> Self {
        let said = match report {
            Ok(report) => Said::read(report, 0.0),
            Err(error) => Said::failed(error.clone(), 0.0),
        };
        let alarms = ["named", "named_in_part", "ambiguous", "unnamed"];
        let truth = (effect.kind.id().to_owned(), effect.axle.name().to_owned());
        let axle = usize::from(effect.axle == Axle::Rear);
        Self {
            shown: alarms.contains(&said.verdict.as_str()) && said.mismatch[axle],
            named: alarms[..3].contains(&said.verdict.as_str())
                && said.sets().iter().any(|set| set.contains(&truth)),
            verdict: said.verdict,
        }
    }
}

pub const HEAD: &str = "\
| effect | times the detectable size | rides | without a size | shown | named or in a set | 95 % shown as promised |
|---|---|---|---|---|---|---|
";

/// The row of an effect; `None` of rides that promise no size.
pub fn row(kind: Kind, times: f64, outcomes: &[Option<Outcome>]) -> String {
    let with_size = || outcomes.iter().flatten();
    let shown = Share::of(with_size().map(|o| o.shown));
    let named = Share::of(with_size().map(|o| o.named));
    let promised = match times < 1.0 {
        _ if shown.of == 0 => "",
        true => "",
        false if shown.allows([PROMISED, 1.0]) => "yes",
        false => "no",
    };
    format!(
        "| {} | {times} | {} | {} | {shown} | {named} | {promised} |\n",
        kind.id(),
        outcomes.len(),
        outcomes.len() - shown.of,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{Value, json};

    fn report(verdict: &str, more: Value) -> Reported {
        let mut diagnosis = json!({"verdict": verdict, "where": {"rear": {"mismatch": true}},
            "detectable": [{"id": "coulomb_friction", "axle": "rear", "smallest_detectable": 4.0},
                           {"id": "cubic_stiffness", "axle": "rear", "smallest_detectable": null}]});
        for (key, value) in more.as_object().into_iter().flatten() {
            diagnosis[key] = value.clone();
        }
        Ok(json!({"diagnosis": diagnosis}))
    }

    #[test]
    fn sizes_come_from_rides_that_miss_nothing() {
        let sizes = Detectable::read(&report("nothing_missing", json!({})));
        let effect = sizes.effect(Kind::CoulombFriction, Axle::Rear, 1.5);
        assert_eq!(effect.map(|e| e.values), Some(vec![6.0]));
        assert!(
            sizes
                .effect(Kind::CubicStiffness, Axle::Rear, 1.0)
                .is_none()
        );
        assert_eq!(
            Detectable::read(&report("unnamed", json!({}))),
            Detectable::default()
        );
    }

    #[test]
    fn shown_and_named_are_two_things() {
        let effect = |axle| Effect::new(Kind::CoulombFriction, axle, &[4.0]);
        let read = |report: &Reported, axle| {
            let outcome = Outcome::read(report, &effect(axle));
            (outcome.shown, outcome.named)
        };
        let set = json!({"effects": [{"id": "hysteresis", "axle": "rear"}],
                         "alternatives": [[{"id": "coulomb_friction", "axle": "rear"}]]});
        let tied = report("ambiguous", set.clone());
        assert_eq!(read(&tied, Axle::Rear), (true, true));
        assert_eq!(read(&tied, Axle::Front), (false, false));
        assert_eq!(read(&report("unnamed", set), Axle::Rear), (true, false));
        assert_eq!(read(&Err("no road".to_owned()), Axle::Rear), (false, false));
    }

    #[test]
    fn a_promise_is_kept_where_chance_allows_it() {
        let of = |shown: usize| -> Vec<Option<Outcome>> {
            let one = |i| Outcome {
                shown: i < shown,
                ..Outcome::default()
            };
            (0..40).map(|i| Some(one(i))).chain([None]).collect()
        };
        let said = |shown| row(Kind::SensorDelay, 1.0, &of(shown));
        assert!(said(37).contains("| 41 | 1 | 37 of 40") && said(37).ends_with("| yes |\n"));
        assert!(said(20).ends_with("| no |\n"));
    }
}
