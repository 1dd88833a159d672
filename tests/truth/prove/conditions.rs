//! How rides under unusual circumstances were answered.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::score::{Mark, Scored};

/// Rides by circumstance and class, of those that count; empty where no ride has a circumstance. A clean ride is right when
/// nothing is missing; `cannot tell` is counted apart from what was missed.
pub fn table(scored: &[Scored]) -> String {
    if scored.iter().all(|r| r.circumstance.is_none()) {
        return String::new();
    }
    let mut groups: BTreeMap<String, Vec<&Scored>> = BTreeMap::new();
    for r in scored.iter().filter(|r| r.class == "clean" || r.shown) {
        let circumstance = r.circumstance.as_deref().unwrap_or("as usual");
        let group = format!("{circumstance}, {}", r.class);
        groups.entry(group).or_default().push(r);
    }
    let mut text = String::from(
        "\n### By circumstance\n\n| circumstance, concealed | rides | right | in a set | right and more | some | wrong | cannot tell | otherwise |\n|---|---|---|---|---|---|---|---|---|\n",
    );
    for (group, rides) in groups {
        let _ = writeln!(text, "| {group} | {} | {} |", rides.len(), counts(&rides));
    }
    text
}

/// The cells of a row; `otherwise` is what no other holds.
fn counts(rides: &[&Scored]) -> String {
    let marks = [
        Mark::Right,
        Mark::InSet,
        Mark::Extra,
        Mark::Partial,
        Mark::Wrong,
    ];
    let count = |holds: &dyn Fn(&Scored) -> bool| rides.iter().filter(|r| holds(r)).count();
    let mut cells: Vec<usize> = marks.map(|mark| count(&|r| r.mark == mark)).to_vec();
    cells.push(count(&|r| r.outcome.verdict == "cannot_tell"));
    cells.push(rides.len() - cells.iter().sum::<usize>());
    let shown = |count: &usize| match count {
        0 => String::new(),
        _ => count.to_string(),
    };
    cells.iter().map(shown).collect::<Vec<_>>().join(" | ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outcome::Outcome;
    use crate::prove::score::{Case, score};
    use serde_json::json;

    fn ride(circumstance: &str, verdict: &str) -> Scored {
        let truth = json!({"ride": "001", "class": "clean", "circumstance": circumstance});
        let case = Case {
            truth: &truth,
            known: None,
        };
        let report = json!({"diagnosis": {"verdict": verdict}});
        score(&case, &Outcome::read(&report, 1.0))
    }

    #[test]
    fn cannot_tell_is_counted_apart() {
        let said = ["nothing_missing", "cannot_tell", "named", "unnamed"];
        let text = table(&said.map(|verdict| ride("short", verdict)));
        assert!(
            text.ends_with("| short, clean | 4 | 1 |  |  |  | 1 | 1 | 1 |\n"),
            "{text}"
        );
        assert_eq!(table(&[]), "");
    }
}
