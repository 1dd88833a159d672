//! What a study says of a set of rides, against the truth.

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::outcome::{Name, sorted};
use crate::simulate::vehicle::Bike;
use crate::trial::bench::Reported;
use crate::trial::coverage::{AXLES, Covered};

/// A verdict against the truth.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mark {
    /// Exactly the truth.
    Right,
    /// Among sets that explain the rides as well.
    InSet,
    /// The truth, beside which something is said to be left.
    InPart,
    /// Something is said to be missing, without a name.
    Unnamed,
    /// Said that nothing is missing where something is.
    Missed,
    /// Named what is not there.
    Wrong,
    /// No verdict, or no report.
    #[default]
    Withheld,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    pub mark: Mark,
    /// The verdict, or what is said where there is none.
    pub verdict: String,
    pub names: Vec<Name>,
    pub rides: usize,
    pub left_aside: usize,
    /// Whether the rides are said to differ on the axle whose stiffness changes.
    pub difference: Option<bool>,
    /// k and B of all rides as one, of the axles on which they are the same.
    pub common: Covered,
    /// k and B of each ride.
    pub each: Covered,
}

/// What is concealed in a set.
pub struct Truth {
    pub effect: Option<Name>,
    /// The axle whose stiffness changes.
    pub changed: Option<usize>,
    /// Of each ride, by the name of its file.
    pub bikes: Vec<(String, Bike)>,
}

impl Outcome {
    pub fn read(report: &Reported, truth: &Truth) -> Self {
        let rides = truth.bikes.len();
        let report = match report {
            Ok(report) => report,
            Err(said) => {
                return Self {
                    verdict: said.clone(),
                    rides,
                    ..Self::default()
                };
            }
        };
        let names = affirmed(report);
        let estimate = |axle: &str| &report["axles"][axle]["estimate"];
        Self {
            mark: mark(report, &names, truth),
            verdict: verdict(report).to_owned(),
            names,
            rides,
            left_aside: list(&report["left_aside"]).len(),
            difference: truth.changed.map(|axle| estimate(AXLES[axle]).is_null()),
            common: common(report, truth),
            each: each(report, truth),
        }
    }
}

fn verdict(report: &Value) -> &str {
    report["verdict"].as_str().unwrap_or_default()
}

fn list(value: &Value) -> &[Value] {
    value.as_array().map(Vec::as_slice).unwrap_or_default()
}

fn name(value: &Value) -> Name {
    let text = |v: &Value| v.as_str().unwrap_or_default().to_owned();
    (text(&value["id"]), text(&value["axle"]))
}

/// Effects that the verdict affirms as common to the rides.
fn affirmed(report: &Value) -> Vec<Name> {
    let effects = list(&report["effects"]).iter().map(|e| &e["effect"]);
    sorted(
        effects
            .filter(|e| e["affirmed"] == true)
            .map(name)
            .collect(),
    )
}

fn mark(report: &Value, names: &[Name], truth: &Truth) -> Mark {
    let truth: Vec<Name> = truth.effect.iter().cloned().collect();
    let is_truth = |set: &Vec<Name>| !truth.is_empty() && sorted(set.clone()) == truth;
    match verdict(report) {
        "nothing_missing" if truth.is_empty() => Mark::Right,
        "nothing_missing" => Mark::Missed,
        "unnamed" => Mark::Unnamed,
        "named" if is_truth(&names.to_vec()) => Mark::Right,
        "named_in_part" if is_truth(&names.to_vec()) => Mark::InPart,
        "ambiguous" => {
            let first = list(&report["effects"]).iter().map(|e| name(&e["effect"]));
            let others = list(&report["alternatives"]).iter();
            let others = others.map(|set| list(set).iter().map(name).collect());
            match std::iter::once(first.collect())
                .chain(others)
                .any(|set| is_truth(&set))
            {
                true => Mark::InSet,
                false => Mark::Wrong,
            }
        }
        "named" | "named_in_part" => Mark::Wrong,
        _ => Mark::Withheld,
    }
}

fn common(report: &Value, truth: &Truth) -> Covered {
    let Some((_, bike)) = truth.bikes.first() else {
        return Covered::default();
    };
    let at = |axle: &str| &report["axles"][axle]["estimate"];
    let mut covered = Covered::of_estimates(at, bike);
    if let Some(axle) = truth.changed {
        covered.stiffness.remove(axle);
        covered.damping.remove(axle);
    }
    covered
}

fn each(report: &Value, truth: &Truth) -> Covered {
    let mut all = Covered::default();
    for ride in list(&report["rides"]) {
        let of = |(name, _): &&(String, Bike)| ride["name"] == **name;
        if let Some((_, bike)) = truth.bikes.iter().find(of) {
            all.add(&Covered::of_estimates(|axle| &ride["axles"][axle], bike));
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::Chance;
    use crate::trial::plan;
    use serde_json::json;

    fn truth(effect: Option<&str>, changed: Option<usize>) -> Truth {
        let bike = Bike {
            stiffness_n_m: [1e5, 9e4],
            damping_n_s_m: [300.0, 500.0],
            ..plan::bike([1e5, 2e5], [1.0, 2.0], &mut Chance::new(1, 0))
        };
        Truth {
            effect: effect.map(|id| (id.to_owned(), "rear".to_owned())),
            changed,
            bikes: vec![
                ("a.csv".to_owned(), bike.clone()),
                ("b.csv".to_owned(), bike),
            ],
        }
    }

    fn report(verdict: &str, ids: &[&str]) -> Value {
        let effect = |id: &&str| json!({"effect": {"id": id, "axle": "rear", "affirmed": verdict != "ambiguous"}});
        let effects: Vec<Value> = ids.iter().map(effect).collect();
        json!({"verdict": verdict, "effects": effects, "alternatives": [[{"id": "hysteresis", "axle": "rear"}]]})
    }

    #[test]
    fn verdicts_are_marked_against_the_truth() {
        let marked = |effect, verdict, ids: &[&str]| {
            Outcome::read(&Ok(report(verdict, ids)), &truth(effect, None)).mark
        };
        let friction = Some("coulomb_friction");
        assert_eq!(marked(None, "nothing_missing", &[]), Mark::Right);
        assert_eq!(marked(None, "named", &["hysteresis"]), Mark::Wrong);
        assert_eq!(marked(None, "ambiguous", &["hysteresis"]), Mark::Wrong);
        assert_eq!(marked(friction, "nothing_missing", &[]), Mark::Missed);
        assert_eq!(
            marked(friction, "named", &["coulomb_friction"]),
            Mark::Right
        );
        assert_eq!(marked(friction, "named", &["cubic_stiffness"]), Mark::Wrong);
        assert_eq!(
            marked(friction, "ambiguous", &["coulomb_friction"]),
            Mark::InSet
        );
        assert_eq!(
            marked(Some("hysteresis"), "ambiguous", &["bump_stop"]),
            Mark::InSet
        );
        assert_eq!(
            marked(friction, "named_in_part", &["coulomb_friction"]),
            Mark::InPart
        );
        assert_eq!(marked(friction, "cannot_tell", &[]), Mark::Withheld);
        let refused = Outcome::read(&Err("no road".to_owned()), &truth(None, None));
        assert_eq!((refused.mark, refused.rides), (Mark::Withheld, 2));
    }

    #[test]
    fn a_change_of_stiffness_is_told_by_withholding_the_common_one() {
        let estimate =
            |k: f64| json!({"k_n_m": k, "k_std_n_m": 1e3, "b_n_s_m": 500.0, "b_std_n_s_m": 1.0});
        let mut told = report("nothing_missing", &[]);
        told["axles"] = json!({"front": {"estimate": null}, "rear": {"estimate": estimate(9.1e4)}});
        told["rides"] =
            json!([{"name": "b.csv", "axles": {"front": estimate(1.2e5), "rear": estimate(9e4)}}]);
        let outcome = Outcome::read(&Ok(told), &truth(None, Some(0)));
        assert_eq!(outcome.difference, Some(true));
        assert_eq!(outcome.common.stiffness, [Some(true)]);
        assert_eq!(outcome.each.stiffness, [Some(false), Some(true)]);
    }
}
