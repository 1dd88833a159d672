//! The table of issue 3 from scored rides, and the tables that explain it.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::score::{Mark, OmissionBias, ParameterError, Scored};

/// One row of the table: what is asked, what was demanded, and each method's figure.
struct Row {
    what: &'static str,
    demand: &'static str,
    figure: fn(&[Scored]) -> String,
}

const CLEAN: Row = Row {
    what: "clean rides called `nothing_missing`",
    demand: ">= 98 %",
    figure: |s| share(of(s, "clean"), |r| r.mark == Mark::Right),
};

const ROWS: [Row; 20] = [
    CLEAN,
    Row {
        what: "single effect: unique and right",
        demand: ">= 95 %",
        figure: |s| share(of(s, "single"), |r| r.mark == Mark::Right),
    },
    Row {
        what: "single effect: in a set of at most 3",
        demand: "<= 5 %",
        figure: |s| share(of(s, "single"), |r| r.mark == Mark::InSet),
    },
    Row {
        what: "single effect: named wrongly and alone",
        demand: "<= 1 %",
        figure: |s| share(of(s, "single"), |r| r.mark == Mark::Wrong),
    },
    Row {
        what: "single effect: right, and something more",
        demand: "",
        figure: |s| share(of(s, "single"), |r| r.mark == Mark::Extra),
    },
    Row {
        what: "single effect: a set without it or of more than 3",
        demand: "",
        figure: |s| share(of(s, "single"), |r| r.mark == Mark::VagueSet),
    },
    Row {
        what: "single effect: called `unnamed`",
        demand: "",
        figure: |s| share(of(s, "single"), |r| r.mark == Mark::Unnamed),
    },
    Row {
        what: "single effect: missed",
        demand: "",
        figure: |s| share(of(s, "single"), |r| r.mark == Mark::Missed),
    },
    Row {
        what: "right axle, of the single-effect rides on which one was given",
        demand: ">= 99 %",
        figure: axle,
    },
    Row {
        what: "two effects: both found",
        demand: ">= 95 %",
        figure: |s| {
            share(of(s, "two"), |r| {
                matches!(r.mark, Mark::Right | Mark::Extra) || (r.mark == Mark::InSet && both(r))
            })
        },
    },
    Row {
        what: "two effects: exactly those",
        demand: ">= 90 %",
        figure: |s| share(of(s, "two"), |r| r.mark == Mark::Right),
    },
    Row {
        what: "not in the library: `unnamed` and located",
        demand: ">= 95 %",
        figure: |s| share(of(s, "outside"), |r| r.mark == Mark::Right),
    },
    Row {
        what: "not in the library: misnamed",
        demand: "",
        figure: |s| share(of(s, "outside"), |r| r.mark == Mark::Wrong),
    },
    Row {
        what: "held-out RMS over the oracle's, single effect: median",
        demand: "<= 1.01",
        figure: |s| quantile(&oracle(s), 0.5, 1.0, 3),
    },
    Row {
        what: "held-out RMS over the oracle's, single effect: 95 % of rides",
        demand: "<= 1.05",
        figure: |s| quantile(&oracle(s), 0.95, 1.0, 3),
    },
    Row {
        what: "the effect's parameter: median error",
        demand: "<= 1.5 %",
        figure: |s| quantile(&errors(s), 0.5, 100.0, 2),
    },
    Row {
        what: "the effect's parameter: error of 90 % of rides",
        demand: "<= 5 %",
        figure: |s| quantile(&errors(s), 0.9, 100.0, 2),
    },
    Row {
        what: "the effect's parameter: 95 % interval covers",
        demand: "90-98 %",
        figure: |s| {
            covered(
                named(s)
                    .flat_map(|r| &r.parameters)
                    .filter(|p| p.main)
                    .filter_map(|p| p.covered),
            )
        },
    },
    Row {
        what: "bias of k from the omission removed",
        demand: ">= 90 %",
        figure: |s| removed(s, "k"),
    },
    Row {
        what: "bias of B from the omission removed",
        demand: ">= 90 %",
        figure: |s| removed(s, "b"),
    },
];

/// Rides of a class that count: clean ones all, the others where the plain model shows what is concealed.
fn of<'a>(scored: &'a [Scored], class: &'a str) -> Box<dyn Iterator<Item = &'a Scored> + 'a> {
    Box::new(
        scored
            .iter()
            .filter(move |r| r.class == class && (class == "clean" || r.shown)),
    )
}

/// Single-effect rides on which the effect was found.
fn named(scored: &[Scored]) -> impl Iterator<Item = &Scored> {
    of(scored, "single").filter(|r| matches!(r.mark, Mark::Right | Mark::InSet | Mark::Extra))
}

fn both(r: &Scored) -> bool {
    r.truth.iter().all(|t| r.outcome.names().contains(t))
}

fn share<'a>(rides: impl Iterator<Item = &'a Scored>, holds: impl Fn(&Scored) -> bool) -> String {
    let all: Vec<&Scored> = rides.collect();
    ratio(all.iter().filter(|r| holds(r)).count(), all.len())
}

fn ratio(count: usize, of: usize) -> String {
    if of == 0 {
        "-".to_owned()
    } else {
        format!("{:.1} % ({count}/{of})", 100.0 * count as f64 / of as f64)
    }
}

fn axle(scored: &[Scored]) -> String {
    let given: Vec<bool> = of(scored, "single").filter_map(|r| r.right_axle).collect();
    ratio(given.iter().filter(|right| **right).count(), given.len())
}

fn oracle(scored: &[Scored]) -> Vec<f64> {
    of(scored, "single").filter_map(|r| r.over_oracle).collect()
}

fn errors(scored: &[Scored]) -> Vec<f64> {
    named(scored)
        .flat_map(|r| &r.parameters)
        .filter(|p| p.main)
        .map(|p| p.error)
        .collect()
}

fn covered(flags: impl Iterator<Item = bool>) -> String {
    let flags: Vec<bool> = flags.collect();
    ratio(flags.iter().filter(|c| **c).count(), flags.len())
}

/// Pooled over rides, so that rides on which the omission hardly biased anything hardly count.
fn removed(scored: &[Scored], which: &str) -> String {
    let bias: Vec<&OmissionBias> = named(scored)
        .flat_map(|r| &r.bias)
        .filter(|b| b.name == which)
        .collect();
    let (before, after): (f64, f64) = bias
        .iter()
        .fold((0.0, 0.0), |s, b| (s.0 + b.before, s.1 + b.after));
    if before == 0.0 {
        "-".to_owned()
    } else {
        format!("{:.1} %", 100.0 * (1.0 - after / before))
    }
}

fn quantile(values: &[f64], at: f64, times: f64, digits: usize) -> String {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    if sorted.is_empty() {
        return "-".to_owned();
    }
    let value = sorted[((sorted.len() - 1) as f64 * at).round() as usize];
    let unit = if times == 100.0 { " %" } else { "" };
    format!("{:.digits$}{unit}", value * times)
}

/// The table of issue 3; one column per method. `clean_only` keeps its first row.
pub fn main_table(methods: &[(&str, &[Scored])], clean_only: bool) -> String {
    let mut text = String::from("| | at least |");
    methods
        .iter()
        .for_each(|(name, _)| text += &format!(" {name} |"));
    text += "\n|---|---|";
    text += &"---|".repeat(methods.len());
    text.push('\n');
    for row in if clean_only { &ROWS[..1] } else { &ROWS[..] } {
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
            quantile(&errors, 0.5, 100.0, 2),
            quantile(&errors, 0.9, 100.0, 2),
            covered(all.iter().filter_map(|p| p.covered)),
        );
    }
    let both = |which: &str| {
        covered(
            named(scored)
                .flat_map(|r| &r.bias)
                .filter(|b| b.name == which)
                .filter_map(|b| b.covered),
        )
    };
    let _ = writeln!(
        text,
        "| k of the extended model | | | | {} |\n| B of the extended model | | | | {} |",
        both("k"),
        both("b")
    );
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::prove::outcome::Outcome;

    fn ride(class: &str, mark: Mark, shown: bool) -> Scored {
        Scored {
            ride: "001".to_owned(),
            class: class.to_owned(),
            truth: Vec::new(),
            outside: None,
            size: 0,
            setting: "road".to_owned(),
            noise: "white".to_owned(),
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
        let table = main_table(&[("veloid", &scored)], false);
        assert!(
            table.contains("| single effect: unique and right | >= 95 % | 50.0 % (1/2) |"),
            "{table}"
        );
        assert!(
            table.contains("| single effect: named wrongly and alone | <= 1 % | 0.0 % (0/2) |"),
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
        assert!(main_table(&[("veloid", &scored)], true).lines().count() == 3);
    }
}
