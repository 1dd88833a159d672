//! The table of issue 3 from scored rides, and the tables that explain it.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::rows::{self, Row, covered, errors_of, named, of};
use super::score::{Mark, OmissionBias, ParameterError, Scored};
use crate::suite::order::Suite;

/// What falls further short of its demand than so few rides do by chance; one line each.
pub fn short(scored: &[Scored], suite: Suite, doubt: f64) -> Vec<String> {
    let line = |row: &Row| {
        let short = row.demand.short(&(row.figure)(scored), doubt)?;
        Some(format!(
            "{}: holds on {} of {}; where {:.0} % do, so few come about with {:.2} %",
            row.what,
            short.hold,
            short.of,
            100.0 * short.rate,
            100.0 * short.chance
        ))
    };
    rows::of_suite(suite).iter().filter_map(line).collect()
}

/// The table of a suite; one column per method.
pub fn main_table(methods: &[(&str, &[Scored])], suite: Suite) -> String {
    let mut text = String::from("| | at least |");
    methods
        .iter()
        .for_each(|(name, _)| text += &format!(" {name} |"));
    text += "\n|---|---|";
    text += &"---|".repeat(methods.len());
    text.push('\n');
    for row in rows::of_suite(suite) {
        let _ = write!(text, "| {} | {} |", row.what, row.demand);
        methods
            .iter()
            .for_each(|(_, scored)| text += &format!(" {} |", (row.figure)(scored)));
        text.push('\n');
    }
    text
}

/// Marks of one method by class, noise kind or effect: what stands behind the shares.
pub fn breakdown(
    scored: &[Scored],
    title: &str,
    key: impl Fn(&Scored) -> Option<String>,
) -> String {
    let mut groups: BTreeMap<String, Vec<&Scored>> = BTreeMap::new();
    for r in scored.iter().filter(|r| r.class == "clean" || r.shown) {
        if let Some(group) = key(r) {
            groups.entry(group).or_default().push(r);
        }
    }
    let mut text = format!(
        "| {title} | rides | right | in a set | right and more | some | vague set | wrong | unnamed | missed | failed |\n"
    );
    text += "|---|---|---|---|---|---|---|---|---|---|---|\n";
    for (group, rides) in groups {
        let _ = write!(text, "| {group} | {} |", rides.len());
        for mark in [
            Mark::Right,
            Mark::InSet,
            Mark::Extra,
            Mark::Partial,
            Mark::VagueSet,
            Mark::Wrong,
            Mark::Unnamed,
            Mark::Missed,
            Mark::Failed,
        ] {
            let count = rides.iter().filter(|r| r.mark == mark).count();
            let _ = write!(
                text,
                " {} |",
                if count == 0 {
                    String::new()
                } else {
                    count.to_string()
                }
            );
        }
        text.push('\n');
    }
    text
}

/// Every ride that counts and was not answered right: truth and answer.
pub fn confusions(scored: &[Scored]) -> String {
    let mut text = String::from(
        "| ride | concealed | size | noise | plain / floor | verdict | named | alternatives |\n|---|---|---|---|---|---|---|---|\n",
    );
    let list = |names: &[(String, String)]| {
        names
            .iter()
            .map(|(id, axle)| format!("{id} {axle}"))
            .collect::<Vec<_>>()
            .join(", ")
    };
    for r in scored
        .iter()
        .filter(|r| (r.class == "clean" || r.shown) && r.mark != Mark::Right)
    {
        let truth = r.outside.clone().unwrap_or_else(|| list(&r.truth));
        let others: Vec<String> = r.outcome.alternatives.iter().map(|set| list(set)).collect();
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {:.2} | {} | {} | {} |",
            r.ride,
            if truth.is_empty() { "nothing" } else { &truth },
            r.size,
            r.noise,
            r.visibility.unwrap_or(f64::NAN),
            r.outcome.verdict,
            list(&r.outcome.names()),
            others.join(" / "),
        );
    }
    text
}

/// Median and 90 % error and coverage of every parameter.
pub fn parameters(scored: &[Scored]) -> String {
    let mut groups: BTreeMap<&str, Vec<&ParameterError>> = BTreeMap::new();
    for p in named(scored).flat_map(|r| &r.parameters) {
        groups.entry(&p.name).or_default().push(p);
    }
    let mut text = String::from(
        "| parameter | rides | median error | 90 % | 95 % interval covers |\n|---|---|---|---|---|\n",
    );
    for (name, all) in groups {
        let errors: Vec<f64> = all.iter().map(|p| p.error).collect();
        let _ = writeln!(
            text,
            "| `{name}` | {} | {} | {} | {} |",
            all.len(),
            errors_of(errors.clone(), 0.5, true),
            errors_of(errors, 0.9, true),
            covered(all.iter().filter_map(|p| p.covered)),
        );
    }
    text
}

/// Coverage of k and B by what is concealed: clean rides first, then each effect that was found.
pub fn coverage(scored: &[Scored]) -> String {
    let mut groups: BTreeMap<String, Vec<&OmissionBias>> = BTreeMap::new();
    let clean = of(scored, "clean").filter(|r| r.mark == Mark::Right);
    for r in clean.chain(named(scored)) {
        let effect = r.truth.first();
        let name = effect.map_or("clean".to_owned(), |(id, _)| format!("with `{id}`"));
        groups.entry(name).or_default().extend(&r.bias);
        if effect.is_some() {
            let all = groups.entry("extended, all".to_owned()).or_default();
            all.extend(&r.bias);
        }
    }
    let mut text = String::from("| model | k: 95 % interval covers | B |\n|---|---|---|\n");
    for (name, all) in groups {
        let cover = |which: &str| {
            let those = all.iter().filter(|b| b.name == which);
            covered(those.filter_map(|b| b.covered))
        };
        let _ = writeln!(text, "| {name} | {} | {} |", cover("k"), cover("b"));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outcome::Outcome;

    fn ride(class: &str, mark: Mark, shown: bool) -> Scored {
        Scored {
            ride: "001".to_owned(),
            class: class.to_owned(),
            truth: Vec::new(),
            outside: None,
            size: 0,
            setting: "road".to_owned(),
            duration_s: 60.0,
            noise: "white".to_owned(),
            circumstance: None,
            visibility: Some(1.5),
            shown,
            mark,
            right_axle: Some(true),
            over_oracle: Some(1.002),
            parameters: Vec::new(),
            bias: vec![OmissionBias {
                name: "k".to_owned(),
                before: 0.2,
                after: 0.01,
                covered: None,
            }],
            outcome: Outcome::default(),
        }
    }

    #[test]
    fn only_shown_rides_count_and_clean_ones_always_do() {
        let scored = vec![
            ride("single", Mark::Right, true),
            ride("single", Mark::Wrong, false),
            ride("single", Mark::Missed, true),
            ride("clean", Mark::Right, false),
        ];
        let table = main_table(&[("veloid", &scored)], Suite::Standard);
        assert!(
            table.contains("| single effect: unique and right | >= 95 % | 50.0 % (1/2) |"),
            "{table}"
        );
        assert!(
            table.contains("| single effect: named wrongly and alone | <= 0.44 % | 0.0 % (0/2) |"),
            "{table}"
        );
        assert!(
            table.contains("| clean rides called `nothing_missing` | >= 98 % | 100.0 % (1/1) |"),
            "{table}"
        );
        assert!(
            table.contains("| bias of k from the omission removed | >= 90 % | 95.0 % |"),
            "{table}"
        );
        assert!(
            main_table(&[("veloid", &scored)], Suite::Clean300)
                .lines()
                .count()
                == 5
        );
    }

    #[test]
    fn each_row_is_held_to_its_own_demand() {
        let right = || vec![ride("single", Mark::Right, true); 20];
        let clean = |missed| {
            let mark = move |i| if i < missed { Mark::Wrong } else { Mark::Right };
            (0..10).map(move |i| ride("clean", mark(i), false))
        };
        let rides = |missed| right().into_iter().chain(clean(missed)).collect::<Vec<_>>();
        assert_eq!(short(&rides(1), Suite::Standard, 0.01), [""; 0]);
        let missed = short(&rides(2), Suite::Standard, 0.01);
        assert_eq!(missed.len(), 0, "{missed:?}");
        let missed = short(&rides(3), Suite::Standard, 0.01);
        assert!(missed[0].starts_with("clean rides called `nothing_missing`: holds on 7 of 10"));
        assert_eq!(missed.len(), 1, "{missed:?}");
        let failed = vec![ride("single", Mark::Failed, true); 20];
        assert!(
            short(&failed, Suite::Standard, 0.01)[0].starts_with("single effect: unique and right")
        );
    }
}
