//! The table of issue 3 from scored rides, and the tables that explain it.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::figure::{Demand, Figure};
use super::outcome::Name;
use super::score::{Mark, ParameterError, Scored};
use crate::suite::case::Suite;

/// One row of the table: what is asked, what was demanded, and each method's figure.
struct Row {
    what: &'static str,
    demand: Demand,
    figure: fn(&[Scored]) -> Figure,
}

const CLEAN: Row = Row {
    what: "clean rides called `nothing_missing`",
    demand: Demand::AtLeast(0.98),
    figure: |s| share(of(s, "clean"), |r| r.mark == Mark::Right),
};

const ROWS: [Row; 20] = [
    CLEAN,
    Row {
        what: "single effect: unique and right",
        demand: Demand::AtLeast(0.95),
        figure: |s| share(of(s, "single"), |r| r.mark == Mark::Right),
    },
    Row {
        what: "single effect: in a set of at most 3",
        demand: Demand::AtMost(0.05),
        figure: |s| share(of(s, "single"), |r| r.mark == Mark::InSet),
    },
    Row {
        what: "single effect: named wrongly and alone",
        demand: Demand::AtMost(0.01),
        figure: |s| share(of(s, "single"), |r| r.mark == Mark::Wrong),
    },
    Row {
        what: "single effect: right, and something more",
        demand: Demand::Nothing,
        figure: |s| share(of(s, "single"), |r| r.mark == Mark::Extra),
    },
    Row {
        what: "single effect: a set without it or of more than 3",
        demand: Demand::Nothing,
        figure: |s| share(of(s, "single"), |r| r.mark == Mark::VagueSet),
    },
    Row {
        what: "single effect: called `unnamed`",
        demand: Demand::Nothing,
        figure: |s| share(of(s, "single"), |r| r.mark == Mark::Unnamed),
    },
    Row {
        what: "single effect: missed",
        demand: Demand::Nothing,
        figure: |s| share(of(s, "single"), |r| r.mark == Mark::Missed),
    },
    Row {
        what: "right axle, of the single-effect rides on which one was given",
        demand: Demand::AtLeast(0.99),
        figure: axle,
    },
    Row {
        what: "two effects: both found",
        demand: Demand::AtLeast(0.95),
        figure: |s| {
            share(of(s, "two"), |r| {
                matches!(r.mark, Mark::Right | Mark::Extra) || (r.mark == Mark::InSet && both(r))
            })
        },
    },
    Row {
        what: "two effects: exactly those",
        demand: Demand::AtLeast(0.9),
        figure: |s| share(of(s, "two"), |r| r.mark == Mark::Right),
    },
    Row {
        what: "not in the library: `unnamed` and located",
        demand: Demand::AtLeast(0.95),
        figure: |s| share(of(s, "outside"), |r| r.mark == Mark::Right),
    },
    Row {
        what: "not in the library: misnamed",
        demand: Demand::Nothing,
        figure: |s| share(of(s, "outside"), |r| r.mark == Mark::Wrong),
    },
    Row {
        what: "held-out RMS over the oracle's, single effect: median",
        demand: Demand::Quantile(0.5, 1.01),
        figure: |s| errors_of(oracle(s), 0.5, false),
    },
    Row {
        what: "held-out RMS over the oracle's, single effect: 95 % of rides",
        demand: Demand::Quantile(0.95, 1.05),
        figure: |s| errors_of(oracle(s), 0.95, false),
    },
    Row {
        what: "the effect's parameter: median error",
        demand: Demand::Quantile(0.5, 0.015),
        figure: |s| errors_of(errors(s), 0.5, true),
    },
    Row {
        what: "the effect's parameter: error of 90 % of rides",
        demand: Demand::Quantile(0.9, 0.05),
        figure: |s| errors_of(errors(s), 0.9, true),
    },
    Row {
        what: "the effect's parameter: 95 % interval covers",
        demand: Demand::Between(0.9, 0.98),
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
        demand: Demand::Removed(0.9),
        figure: |s| removed(s, "k"),
    },
    Row {
        what: "bias of B from the omission removed",
        demand: Demand::Removed(0.9),
        figure: |s| removed(s, "b"),
    },
];

const BESIDE: [Row; 2] = [
    Row {
        what: "an effect beside strange physics on the other axle: affirmed",
        demand: Demand::AtLeast(0.8),
        figure: |s| {
            share(of(s, "beside"), |r| {
                r.truth.iter().all(|t| affirmed(r).contains(t))
            })
        },
    },
    Row {
        what: "the same rides: something affirmed that is not there",
        demand: Demand::AtMost(0.03),
        figure: |s| {
            share(of(s, "beside"), |r| {
                affirmed(r).iter().any(|name| !r.truth.contains(name))
            })
        },
    },
];

const QUIET: [Row; 1] = [Row {
    demand: Demand::AtLeast(0.97),
    ..CLEAN
}];

/// Names that a method says act.
fn affirmed(r: &Scored) -> Vec<Name> {
    match r.outcome.verdict.as_str() {
        "named" | "named_in_part" => r.outcome.names(),
        _ => Vec::new(),
    }
}

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

fn share<'a>(rides: impl Iterator<Item = &'a Scored>, holds: impl Fn(&Scored) -> bool) -> Figure {
    covered(rides.map(holds))
}

fn errors_of(each: Vec<f64>, at: f64, percent: bool) -> Figure {
    Figure::Errors { each, at, percent }
}

fn axle(scored: &[Scored]) -> Figure {
    covered(of(scored, "single").filter_map(|r| r.right_axle))
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

fn covered(flags: impl Iterator<Item = bool>) -> Figure {
    let flags: Vec<bool> = flags.collect();
    Figure::Share {
        of: flags.len(),
        hold: flags.iter().filter(|holds| **holds).count(),
    }
}

/// Summed over rides, so that rides on which the omission hardly biased anything hardly count.
fn removed(scored: &[Scored], which: &str) -> Figure {
    let bias = named(scored)
        .flat_map(|r| &r.bias)
        .filter(|b| b.name == which);
    Figure::Sums(bias.map(|b| (b.before, b.after)).collect())
}

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
    rows(suite).iter().filter_map(line).collect()
}

fn rows(suite: Suite) -> &'static [Row] {
    match suite {
        Suite::Standard => &ROWS,
        Suite::Clean300 => &ROWS[..1],
        Suite::Beside => &BESIDE,
        Suite::Quiet => &QUIET,
    }
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
    for row in rows(suite) {
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
    use crate::prove::score::OmissionBias;

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
        assert!(
            main_table(&[("veloid", &scored)], Suite::Clean300)
                .lines()
                .count()
                == 3
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
