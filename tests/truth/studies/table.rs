//! The tables of studies: verdicts and coverage.

use super::outcome::{Mark, Outcome};
use crate::trial::coverage::Covered;
use crate::trial::share::Share;

pub const VERDICTS_HEAD: &str = "\
| sets | of | rides | right | in a set | in part | unnamed | missed | wrongly named | withheld | difference of k reported |
|---|---|---|---|---|---|---|---|---|---|---|
";

pub const COVERAGE_HEAD: &str = "\
| sets | k of all within its 95 % interval | B of all | k of each ride | B of each ride |
|---|---|---|---|---|
";

pub fn verdicts(kind: &str, outcomes: &[Outcome]) -> String {
    let count = |mark: Mark| outcomes.iter().filter(|o| o.mark == mark).count();
    let right = Share::of(outcomes.iter().map(|o| o.mark == Mark::Right));
    let rides: usize = outcomes.iter().map(|o| o.rides).sum();
    let told = Share::of(outcomes.iter().filter_map(|o| o.difference));
    let told = if told.of > 0 {
        told.to_string()
    } else {
        String::new()
    };
    let rest = [
        Mark::InSet,
        Mark::InPart,
        Mark::Unnamed,
        Mark::Missed,
        Mark::Wrong,
        Mark::Withheld,
    ];
    let rest = rest.map(|mark| count(mark).to_string()).join(" | ");
    format!(
        "| {kind} | {} | {rides} | {right} | {rest} | {told} |\n",
        outcomes.len()
    )
}

pub fn coverage(kind: &str, outcomes: &[Outcome]) -> String {
    let (mut common, mut each) = (Covered::default(), Covered::default());
    for outcome in outcomes {
        common.add(&outcome.common);
        each.add(&outcome.each);
    }
    format!("| {kind} | {} | {} |\n", common.cells(), each.cells())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_are_counted_each_in_its_column() {
        let outcome = |mark, difference| Outcome {
            mark,
            difference,
            rides: 3,
            ..Outcome::default()
        };
        let outcomes = [
            outcome(Mark::Right, Some(true)),
            outcome(Mark::Wrong, Some(true)),
            outcome(Mark::Wrong, None),
        ];
        let row = verdicts("x", &outcomes);
        assert!(row.starts_with("| x | 3 | 9 | 1 of 3, 33.3 %"), "{row}");
        assert!(
            row.contains("| 0 | 0 | 0 | 0 | 2 | 0 | 2 of 2, 100.0 %"),
            "{row}"
        );
    }
}
