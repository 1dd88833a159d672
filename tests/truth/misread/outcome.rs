//! What a binary made of a ride that was misread.

use serde_json::Value;

use super::mistake::Noticed;
use super::record::Recorded;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Noticed and said.
    Found,
    /// Nothing is said of it, but no number either; or the file is refused.
    Withheld,
    /// Nothing is said, and k and B are right.
    Right,
    /// Something else is said, or k or B is wrong.
    Wrong,
}

/// Largest errors of k and B that are right: shares, beside three standard errors.
const RIGHT: [f64; 2] = [0.03, 0.06];

/// Words by which a ride is refused for a mistake.
const SAID: [&str; 2] = ["is the unit of the times right", "its unit seems to be"];

/// The outcome of a ride by its report, or by what was said when it was refused.
pub fn outcome(report: Result<&Value, &str>, ride: &Recorded, noticed: Noticed) -> Outcome {
    let report = match report {
        Ok(report) => report,
        Err(said) if SAID.iter().any(|words| said.contains(words)) => return Outcome::Found,
        Err(_) => return Outcome::Withheld,
    };
    let mistakes = kinds(report);
    let warnings = report["ride"]["warnings"].to_string();
    let shown = shown(report, ride);
    match noticed {
        Noticed::Named(names) if mistakes.iter().any(|kind| names.contains(kind)) => Outcome::Found,
        Noticed::Named(_) if !mistakes.is_empty() => Outcome::Wrong,
        Noticed::Used(words) if warnings.contains(words) && mistakes.is_empty() => match shown {
            Shown::Right | Shown::Nothing => Outcome::Found,
            Shown::Wrong => Outcome::Wrong,
        },
        _ => match shown {
            Shown::Right => Outcome::Right,
            Shown::Nothing => Outcome::Withheld,
            Shown::Wrong => Outcome::Wrong,
        },
    }
}

/// Kinds of the mistakes that a report names.
pub fn kinds(report: &Value) -> Vec<&str> {
    let mistakes = report["mistakes"].as_array();
    let mistakes = mistakes.map(Vec::as_slice).unwrap_or_default();
    mistakes.iter().filter_map(|m| m["kind"].as_str()).collect()
}

enum Shown {
    Right,
    Wrong,
    Nothing,
}

fn shown(report: &Value, ride: &Recorded) -> Shown {
    let mut shown = Shown::Nothing;
    for (axle, name) in ["front", "rear"].into_iter().enumerate() {
        let truth = [ride.stiffness_n_m[axle], ride.damping_n_s_m[axle]];
        for (q, (key, truth)) in ["k", "B"].into_iter().zip(truth).enumerate() {
            let result = &report["result"][name][key];
            let (Some(value), Some(std)) = (result["value"].as_f64(), result["std_error"].as_f64())
            else {
                continue;
            };
            if (value - truth).abs() > (RIGHT[q] * truth).max(3.0 * std) {
                return Shown::Wrong;
            }
            shown = Shown::Right;
        }
    }
    shown
}
