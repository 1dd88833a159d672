//! Scores one method on one ride, and sums rides up to the rows of issue 3's table.

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::outcome::{Estimate, Name, Outcome, sorted};
use crate::refit::known::Known;

/// Plain held-out error over the floor from which an effect counts as shown.
pub const SHOWN: f64 = 1.15;

/// One ride: what was concealed, what is known of it with the key open.
pub struct Case<'a> {
    pub truth: &'a Value,
    pub known: Option<&'a Known>,
}

impl Case<'_> {
    pub fn class(&self) -> &str {
        self.truth["class"].as_str().unwrap_or_default()
    }

    /// Concealed effects, sorted.
    pub fn names(&self) -> Vec<Name> {
        let text = |v: &Value| v.as_str().unwrap_or_default().to_owned();
        let effects = self.truth["effects"].as_array();
        sorted(
            effects
                .into_iter()
                .flatten()
                .map(|e| (text(&e["id"]), text(&e["axle"])))
                .collect(),
        )
    }

    /// Axles on which something is concealed.
    pub fn touched(&self) -> [bool; 2] {
        let on = |axle: &str| {
            let at = |v: &Value| v["axle"] == axle || v["axle"] == "both";
            at(&self.truth["outside"])
                || self.truth["effects"]
                    .as_array()
                    .into_iter()
                    .flatten()
                    .any(at)
        };
        [on("front"), on("rear")]
    }

    pub fn shown(&self) -> bool {
        self.known.is_some_and(|k| k.visibility() >= SHOWN)
    }
}

/// How a method did on one ride, in one word per question.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mark {
    /// Exactly the truth (for a clean ride: nothing; for strange physics: unnamed and located).
    Right,
    /// A set of at most three holds the truth.
    InSet,
    /// A set, or a set of more than three, that does not hold or does not narrow down the truth.
    VagueSet,
    /// The truth and something more.
    Extra,
    /// Some of two effects, or an effect beside which something is said to be left.
    Partial,
    /// Named, and not the truth.
    Wrong,
    /// Said `unnamed` where the library holds it, or unnamed on the wrong axle.
    Unnamed,
    /// Said `nothing_missing`.
    Missed,
    Failed,
}

pub fn mark(case: &Case, outcome: &Outcome) -> Mark {
    let (truth, named) = (case.names(), outcome.names());
    let strange = case.class() == "outside";
    match outcome.verdict.as_str() {
        "nothing_missing" if case.class() == "clean" => Mark::Right,
        "nothing_missing" => Mark::Missed,
        "unnamed" if strange && outcome.mismatch == case.touched() => Mark::Right,
        "unnamed" => Mark::Unnamed,
        "cannot_tell" => Mark::Missed,
        "named" | "named_in_part" if case.class() == "beside" => {
            match named.iter().all(|n| truth.contains(n)) {
                true => Mark::Right,
                false => Mark::Wrong,
            }
        }
        "named_in_part" if !named.is_empty() && named.iter().all(|n| truth.contains(n)) => {
            Mark::Partial
        }
        "named_in_part" => Mark::Wrong,
        "named" | "ambiguous" if case.class() == "clean" || strange => Mark::Wrong,
        "named" if named == truth => Mark::Right,
        "named" if truth.iter().all(|t| named.contains(t)) => Mark::Extra,
        "named" if truth.len() > 1 && truth.iter().any(|t| named.contains(t)) => Mark::Partial,
        "named" => Mark::Wrong,
        "ambiguous" if outcome.sets().len() <= 3 && outcome.sets().contains(&truth) => Mark::InSet,
        "ambiguous" => Mark::VagueSet,
        _ => Mark::Failed,
    }
}

/// Whether the axles that a method points at are those of the truth; `None` when it points at none.
pub fn right_axle(case: &Case, outcome: &Outcome) -> Option<bool> {
    match outcome.verdict.as_str() {
        "named" | "named_in_part" | "ambiguous" if !outcome.effects.is_empty() => {
            let on = |axle: &str| {
                outcome
                    .effects
                    .iter()
                    .any(|e| e.axle == axle || e.axle == "both")
            };
            Some([on("front"), on("rear")] == case.touched())
        }
        "unnamed" => Some(outcome.mismatch == case.touched()),
        _ => None,
    }
}

/// Extended held-out error over the oracle's, root mean square over the touched axles.
pub fn over_oracle(case: &Case, outcome: &Outcome) -> Option<f64> {
    let (known, touched) = (case.known?, case.touched());
    let oracle = known.oracle_m?;
    let mut sums = (0.0, 0.0);
    for axle in (0..2).filter(|&a| touched[a]) {
        sums.0 += outcome.extended_m[axle]?.powi(2);
        sums.1 += oracle[axle].powi(2);
    }
    Some((sums.0 / sums.1).sqrt())
}

/// An estimate against its truth.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ParameterError {
    pub name: String,
    /// Relative to the truth (a gain's to its departure from 1; a phase in turns).
    pub error: f64,
    /// Whether the 95 % interval covers the truth, where a standard error was given.
    pub covered: Option<bool>,
    /// The effect's first, defining parameter.
    pub main: bool,
}

/// Errors of the effects that are both concealed and named. Windows and sides are left out.
pub fn parameter_errors(case: &Case, outcome: &Outcome) -> Vec<ParameterError> {
    let mut errors = Vec::new();
    for effect in case.truth["effects"].as_array().into_iter().flatten() {
        let Some(found) = outcome
            .effects
            .iter()
            .find(|f| effect["id"] == *f.id && effect["axle"] == *f.axle)
        else {
            continue;
        };
        let main = crate::simulate::effect::Kind::from_id(&found.id).map_or("", |k| k.names().1[0]);
        for (name, &(value, std_error)) in &found.parameters {
            let Some(truth) = effect["parameters"][name]
                .as_f64()
                .filter(|_| name != "from" && name != "to")
            else {
                continue;
            };
            let turn = std::f64::consts::TAU;
            let (off, scale) = match name.as_str() {
                "phase" => (
                    (value - truth + 1.5 * turn).rem_euclid(turn) - 0.5 * turn,
                    turn,
                ),
                "gain" => (value - truth, truth - 1.0),
                _ => (value - truth, truth),
            };
            errors.push(ParameterError {
                name: format!("{}.{name}", found.id),
                error: (off / scale).abs(),
                covered: std_error.map(|s| off.abs() <= 1.96 * s),
                main: name == main,
            });
        }
    }
    errors
}

/// k and B against the truth: of the axles that something touches, and of all of a clean ride.
pub fn omission_bias(case: &Case, outcome: &Outcome) -> Vec<OmissionBias> {
    let is_clean = case.class() == "clean";
    let touched = case.touched();
    let mut all = Vec::new();
    for axle in (0..2).filter(|&a| is_clean || touched[a]) {
        let plain = |of: fn(&Known) -> [f64; 2]| case.known.map(|known| of(known)[axle]);
        let truth = |name: &str| case.truth[name][axle].as_f64();
        let k = (plain(|k| k.plain_k), outcome.stiffness[axle]);
        let b = (plain(|k| k.plain_b), outcome.damping[axle]);
        all.extend(bias("k", k, truth("stiffness_n_m")));
        all.extend(bias("b", b, truth("damping_n_s_m")));
    }
    all
}

fn bias(
    name: &str,
    (plain, estimate): (Option<f64>, Option<Estimate>),
    truth: Option<f64>,
) -> Option<OmissionBias> {
    let (truth, (value, std_error)) = (truth?, estimate?);
    let off = |value: f64| (value / truth).max(1e-6).ln().abs();
    Some(OmissionBias {
        name: name.to_owned(),
        before: off(plain.unwrap_or(value)),
        after: off(value),
        covered: std_error.map(|s| (value - truth).abs() <= 1.96 * s),
    })
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OmissionBias {
    pub name: String,
    pub before: f64,
    pub after: f64,
    pub covered: Option<bool>,
}

/// Everything that one method's rows need from one ride.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Scored {
    pub ride: String,
    pub class: String,
    pub truth: Vec<Name>,
    pub outside: Option<String>,
    pub size: u64,
    pub setting: String,
    pub duration_s: f64,
    pub noise: String,
    /// What is unusual of the ride.
    pub circumstance: Option<String>,
    pub visibility: Option<f64>,
    pub shown: bool,
    pub mark: Mark,
    pub right_axle: Option<bool>,
    pub over_oracle: Option<f64>,
    pub parameters: Vec<ParameterError>,
    pub bias: Vec<OmissionBias>,
    pub outcome: Outcome,
}

pub fn score(case: &Case, outcome: &Outcome) -> Scored {
    let text = |v: &Value| v.as_str().map(str::to_owned);
    Scored {
        ride: text(&case.truth["ride"]).unwrap_or_default(),
        class: case.class().to_owned(),
        truth: case.names(),
        outside: text(&case.truth["outside"]["id"]),
        size: case.truth["size"].as_u64().unwrap_or(0),
        setting: text(&case.truth["setting"]).unwrap_or_default(),
        duration_s: case.truth["duration_s"].as_f64().unwrap_or(0.0),
        noise: text(&case.truth["noise"]["kind"]).unwrap_or_default(),
        circumstance: text(&case.truth["circumstance"]),
        visibility: case.known.map(Known::visibility),
        shown: case.shown(),
        mark: mark(case, outcome),
        right_axle: right_axle(case, outcome),
        over_oracle: over_oracle(case, outcome),
        parameters: parameter_errors(case, outcome),
        bias: omission_bias(case, outcome),
        outcome: outcome.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn truth(class: &str, effects: Value) -> Value {
        json!({"ride": "001", "class": class, "effects": effects, "outside": null,
               "stiffness_n_m": [1e5, 9e4], "damping_n_s_m": [300.0, 500.0]})
    }

    fn friction() -> Value {
        json!([{"id": "coulomb_friction", "axle": "front", "parameters": {"friction": 10.0}}])
    }

    fn said(verdict: &str, names: &[(&str, &str)]) -> Outcome {
        let names = names
            .iter()
            .map(|(i, a)| ((*i).to_owned(), (*a).to_owned()))
            .collect();
        Outcome {
            verdict: verdict.to_owned(),
            ..Outcome::named(names)
        }
    }

    fn marked(truth: &Value, outcome: &Outcome) -> Mark {
        mark(&Case { truth, known: None }, outcome)
    }

    #[test]
    fn single_effects() {
        let t = truth("single", friction());
        assert_eq!(
            marked(&t, &said("named", &[("coulomb_friction", "front")])),
            Mark::Right
        );
        assert_eq!(
            marked(&t, &said("named", &[("coulomb_friction", "rear")])),
            Mark::Wrong
        );
        assert_eq!(
            marked(
                &t,
                &said(
                    "named",
                    &[("hysteresis", "front"), ("coulomb_friction", "front")]
                )
            ),
            Mark::Extra
        );
        assert_eq!(marked(&t, &said("nothing_missing", &[])), Mark::Missed);
        assert_eq!(
            marked(&t, &said("unnamed", &[("coulomb_friction", "front")])),
            Mark::Unnamed
        );
        let mut set = said("ambiguous", &[("hysteresis", "front")]);
        assert_eq!(marked(&t, &set), Mark::VagueSet);
        set.alternatives = vec![vec![("coulomb_friction".to_owned(), "front".to_owned())]];
        assert_eq!(marked(&t, &set), Mark::InSet);
        set.alternatives.extend(vec![Vec::new(); 2]);
        assert_eq!(marked(&t, &set), Mark::VagueSet);
    }

    #[test]
    fn clean_pairs_and_strange() {
        assert_eq!(
            marked(&truth("clean", json!([])), &said("nothing_missing", &[])),
            Mark::Right
        );
        assert_eq!(
            marked(&truth("clean", json!([])), &said("unnamed", &[])),
            Mark::Unnamed
        );
        let both = json!([{"id": "sensor_gain", "axle": "rear"}, {"id": "cubic_stiffness", "axle": "front"}]);
        let pair = truth("two", both);
        assert_eq!(
            marked(&pair, &said("named", &[("sensor_gain", "rear")])),
            Mark::Partial
        );
        assert_eq!(
            marked(
                &pair,
                &said(
                    "named",
                    &[("sensor_gain", "rear"), ("cubic_stiffness", "front")]
                )
            ),
            Mark::Right
        );
        let mut strange = truth("outside", json!([]));
        strange["outside"] = json!({"id": "cubic_damping", "axle": "rear"});
        assert_eq!(
            marked(&strange, &said("unnamed", &[("quadratic_damping", "rear")])),
            Mark::Right
        );
        assert_eq!(
            marked(
                &strange,
                &said("unnamed", &[("quadratic_damping", "front")])
            ),
            Mark::Unnamed
        );
        // Beside a rest an effect must still act.
        let part = |effects: &[(&str, &str)]| said("named_in_part", effects);
        assert_eq!(
            marked(&strange, &part(&[("quadratic_damping", "rear")])),
            Mark::Wrong
        );
        assert_eq!(
            marked(&pair, &part(&[("sensor_gain", "rear")])),
            Mark::Partial
        );
        assert_eq!(marked(&pair, &part(&[("bump_stop", "rear")])), Mark::Wrong);
        assert_eq!(marked(&pair, &said("cannot_tell", &[])), Mark::Missed);
        assert_eq!(
            marked(&strange, &said("named", &[("quadratic_damping", "rear")])),
            Mark::Wrong
        );
    }

    #[test]
    fn parameter_error_and_coverage() {
        let t = truth("single", friction());
        let mut outcome = said("named", &[("coulomb_friction", "front")]);
        outcome.effects[0]
            .parameters
            .insert("friction".to_owned(), (10.3, Some(0.1)));
        let errors = parameter_errors(
            &Case {
                truth: &t,
                known: None,
            },
            &outcome,
        );
        assert!((errors[0].error - 0.03).abs() < 1e-12 && errors[0].main);
        assert_eq!(errors[0].covered, Some(false));
    }

    #[test]
    fn the_oracle_ratio_takes_the_touched_axle() {
        let known = Known {
            plain_m: [2e-4, 1e-4],
            plain_k: [1.1e5, 9e4],
            plain_b: [330.0, 500.0],
            floor_m: [1e-4; 2],
            oracle_m: Some([1e-4, 0.0]),
            oracle_values: Vec::new(),
            touched: [true, false],
        };
        let t = truth("single", friction());
        let case = Case {
            truth: &t,
            known: Some(&known),
        };
        let mut outcome = said("named", &[("coulomb_friction", "front")]);
        outcome.extended_m = [Some(1.02e-4), Some(5.0)];
        outcome.stiffness = [Some((1.001e5, Some(100.0))), None];
        assert!(case.shown());
        assert!((over_oracle(&case, &outcome).expect("both known") - 1.02).abs() < 1e-9);
        let bias = omission_bias(&case, &outcome);
        assert_eq!(bias.len(), 1);
        assert!(bias[0].before > 0.09 && bias[0].after < 0.0011 && bias[0].covered == Some(true));
    }
}
