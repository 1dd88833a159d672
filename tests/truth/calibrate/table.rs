//! The tables of a calibration: rates against their names, and coverage.

use super::outcome::{LENIENT, Outcome};
use crate::trial::coverage::Covered;
use crate::trial::share::Share;

const P_VALUES: [f64; 3] = [0.01, 0.05, 0.2];
/// The significance level of `identify` by default.
const USUAL: f64 = 0.01;

pub const RATES_HEAD: &str = "\
| class | rides | verdict withheld | axles: p < 0.01 | p < 0.05 | p < 0.2 | rides: smallest p < 0.01 | p < 0.05 | p < 0.2 \
| alarms at alpha 0.01 | alarms at alpha 0.2 | within a factor of two |
|---|---|---|---|---|---|---|---|---|---|---|---|
";

pub const COVERAGE_HEAD: &str = "\
| class | k within its 95 % interval | B within its 95 % interval |
|---|---|---|
";

/// The row of a class, and whether every rate may be within a factor of two of its name.
pub fn rates(class: &str, outcomes: &[Outcome]) -> String {
    let axles: Vec<f64> = (outcomes.iter().flat_map(|o| o.p_values).flatten()).collect();
    let rides: Vec<f64> = outcomes.iter().filter_map(Outcome::smallest).collect();
    let below = |values: &[f64], p: f64| Share::of(values.iter().map(|value| *value < p));
    let mut named: Vec<(String, f64, Share)> = Vec::new();
    for (what, values) in [("axles", &axles), ("rides", &rides)] {
        named.extend(P_VALUES.map(|p| (format!("{what} p < {p}"), p, below(values, p))));
    }
    for (alpha, alarm) in [
        (USUAL, Share::of(outcomes.iter().filter_map(|o| o.alarm))),
        (
            LENIENT,
            Share::of(outcomes.iter().filter_map(|o| o.lenient_alarm)),
        ),
    ] {
        named.push((format!("alarms at {alpha}"), alpha, alarm));
    }
    let cells: Vec<String> = named
        .iter()
        .map(|(_, _, share)| share.to_string())
        .collect();
    let withheld = outcomes.iter().filter(|o| o.alarm.is_none()).count();
    format!(
        "| {class} | {} | {withheld} | {} | {} |\n",
        outcomes.len(),
        cells.join(" | "),
        judged(&named)
    )
}

/// Yes, or which rates are too large or too small for chance; nothing where there are none.
fn judged(named: &[(String, f64, Share)]) -> String {
    if named.iter().all(|(_, _, share)| share.of == 0) {
        return String::new();
    }
    let off = |(what, rate, share): &(String, f64, Share)| {
        if share.allows([0.5 * rate, 2.0 * rate]) {
            return None;
        }
        let often = share.limits()[0] > 2.0 * rate;
        Some(format!(
            "{what} too {}",
            if often { "often" } else { "rarely" }
        ))
    };
    let off: Vec<String> = named.iter().filter_map(off).collect();
    match off.is_empty() {
        true => "yes".to_owned(),
        false => off.join(", "),
    }
}

pub fn coverage(class: &str, outcomes: &[Outcome]) -> String {
    let mut all = Covered::default();
    outcomes.iter().for_each(|o| all.add(&o.covered));
    format!("| {class} | {} |\n", all.cells())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn outcome(p: f64, alarm: bool) -> Outcome {
        Outcome {
            p_values: [Some(p), None],
            alarm: Some(alarm),
            ..Outcome::default()
        }
    }

    #[test]
    fn rates_that_chance_does_not_explain_are_told() {
        let even: Vec<Outcome> = (0..100)
            .map(|i| outcome((f64::from(i) + 0.5) / 100.0, false))
            .collect();
        assert!(rates("x", &even).ends_with("| yes |\n"));
        assert!(rates("x", &[]).ends_with("|  |\n"));
        let small: Vec<Outcome> = (0..40).map(|_| outcome(0.004, true)).collect();
        let row = rates("x", &small);
        assert!(
            row.contains("axles p < 0.01 too often") && row.contains("alarms at 0.01 too often")
        );
        assert!(row.contains("| 40 of 40, 100.0 %"), "{row}");
        let large: Vec<Outcome> = (0..60).map(|_| outcome(0.9, false)).collect();
        assert!(rates("x", &large).contains("rides p < 0.2 too rarely"));
    }
}
