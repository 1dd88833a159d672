//! What a method said about one ride, read from the report of the contract.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::Value;

/// An effect's id and axle as the report names them.
pub type Name = (String, String);

/// A value and its standard error, where one was given.
pub type Estimate = (f64, Option<f64>);

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Finding {
    pub id: String,
    pub axle: String,
    pub parameters: BTreeMap<String, Estimate>,
}

impl Finding {
    pub fn name(&self) -> Name {
        (self.id.clone(), self.axle.clone())
    }
}

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// A verdict of the contract, or `failed`.
    pub verdict: String,
    pub effects: Vec<Finding>,
    pub alternatives: Vec<Vec<Name>>,
    /// Front, rear.
    pub mismatch: [bool; 2],
    pub extended_m: [Option<f64>; 2],
    pub stiffness: [Option<Estimate>; 2],
    pub damping: [Option<Estimate>; 2],
    pub seconds: f64,
    pub error: Option<String>,
}

const AXLES: [&str; 2] = ["front", "rear"];

impl Outcome {
    pub fn failed(error: String, seconds: f64) -> Self {
        Self {
            verdict: "failed".to_owned(),
            error: Some(error),
            seconds,
            ..Self::default()
        }
    }

    /// Names only, for methods that give nothing else.
    pub fn named(effects: Vec<Name>) -> Self {
        let verdict = if effects.is_empty() {
            "nothing_missing"
        } else {
            "named"
        };
        let mismatch = [0, 1].map(|a| {
            effects
                .iter()
                .any(|(_, axle)| axle == AXLES[a] || axle == "both")
        });
        let effects = effects
            .into_iter()
            .map(|(id, axle)| Finding {
                id,
                axle,
                ..Finding::default()
            })
            .collect();
        Self {
            verdict: verdict.to_owned(),
            effects,
            mismatch,
            ..Self::default()
        }
    }

    pub fn read(report: &Value, seconds: f64) -> Self {
        let diagnosis = &report["diagnosis"];
        let Some(verdict) = diagnosis["verdict"].as_str() else {
            return Self::failed("the report has no diagnosis.verdict".to_owned(), seconds);
        };
        let list = |v: &Value| v.as_array().cloned().unwrap_or_default();
        let name = |v: &Value| (text(&v["id"]), text(&v["axle"]));
        // Where nothing is named, there is no extended model, and the answer is another method's.
        let estimate = |axle: &str, name: &str, value: &str, error: &str| {
            let (of, answer) = (&diagnosis["extended"][axle], &report["result"][axle][name]);
            let extended = of[value].as_f64().map(|v| (v, of[error].as_f64()));
            extended.or_else(|| Some((answer["value"].as_f64()?, answer["std_error"].as_f64())))
        };
        // Beside a rest only those count that the verdict says act.
        let reported = |e: &&Value| verdict != "named_in_part" || e["affirmed"] == true;
        let effects = list(&diagnosis["effects"])
            .iter()
            .filter(reported)
            .map(|e| Finding {
                id: text(&e["id"]),
                axle: text(&e["axle"]),
                parameters: parameters(&e["parameters"]),
            })
            .collect();
        Self {
            verdict: verdict.to_owned(),
            effects,
            alternatives: list(&diagnosis["alternatives"])
                .iter()
                .map(|set| list(set).iter().map(name).collect())
                .collect(),
            mismatch: AXLES.map(|a| diagnosis["where"][a]["mismatch"].as_bool().unwrap_or(false)),
            extended_m: AXLES.map(|a| diagnosis["held_out"][a]["extended_rms_m"].as_f64()),
            stiffness: AXLES.map(|a| estimate(a, "k", "k_n_m", "k_std_n_m")),
            damping: AXLES.map(|a| estimate(a, "B", "b_n_s_m", "b_std_n_s_m")),
            seconds,
            error: None,
        }
    }

    /// The effects named, sorted.
    pub fn names(&self) -> Vec<Name> {
        sorted(self.effects.iter().map(Finding::name).collect())
    }

    /// Every set the report offers, the first included.
    pub fn sets(&self) -> Vec<Vec<Name>> {
        let others = self.alternatives.iter().cloned().map(sorted);
        std::iter::once(self.names()).chain(others).collect()
    }
}

pub fn sorted(mut names: Vec<Name>) -> Vec<Name> {
    names.sort();
    names
}

fn text(value: &Value) -> String {
    value.as_str().unwrap_or_default().to_owned()
}

fn parameters(value: &Value) -> BTreeMap<String, Estimate> {
    let Some(object) = value.as_object() else {
        return BTreeMap::new();
    };
    object
        .iter()
        .filter_map(|(name, p)| {
            Some((
                name.clone(),
                (p["value"].as_f64()?, p["std_error"].as_f64()),
            ))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn reads_the_report_of_the_contract() {
        let report = json!({"diagnosis": {
            "verdict": "ambiguous",
            "effects": [{"id": "coulomb_friction", "axle": "front",
                         "parameters": {"friction": {"value": 12.1, "std_error": 0.4, "unit": "N"}}}],
            "alternatives": [[{"id": "hysteresis", "axle": "front"}]],
            "extended": {"front": {"k_n_m": 1e5, "b_n_s_m": 300.0, "k_std_n_m": 10.0, "b_std_n_s_m": null}},
            "where": {"front": {"mismatch": true}},
            "held_out": {"front": {"extended_rms_m": 1e-4}}}});
        let clean = json!({"diagnosis": {"verdict": "nothing_missing", "extended": null},
                           "result": {"front": {"k": {"value": 9e4, "std_error": 50.0}}}});
        let answered = Outcome::read(&clean, 2.0);
        assert_eq!(answered.stiffness, [Some((9e4, Some(50.0))), None]);
        let outcome = Outcome::read(&report, 2.0);
        assert_eq!(outcome.sets().len(), 2);
        assert_eq!(outcome.effects[0].parameters["friction"], (12.1, Some(0.4)));
        assert_eq!(outcome.mismatch, [true, false]);
        assert_eq!(outcome.extended_m, [Some(1e-4), None]);
        assert_eq!(outcome.damping[0], Some((300.0, None)));
        assert_eq!(Outcome::read(&json!({}), 0.0).verdict, "failed");
    }
}
