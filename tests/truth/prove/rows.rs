//! The rows of the main table: what is asked, what is demanded, and how it is counted.

use super::figure::{Demand, Figure};
use super::score::{Mark, Scored};
use crate::outcome::Name;
use crate::suite::order::Suite;

/// One row of the table: what is asked, what was demanded, and each method's figure.
pub struct Row {
    pub what: &'static str,
    pub demand: Demand,
    pub figure: fn(&[Scored]) -> Figure,
}

const CLEAN: Row = Row {
    what: "clean rides called `nothing_missing`",
    demand: Demand::AtLeast(0.98),
    figure: |s| share(of(s, "clean"), |r| r.mark == Mark::Right),
};

const COVERS_K: Row = Row {
    what: "k of the answer: 95 % interval covers",
    demand: Demand::Between(0.9, 0.98),
    figure: |s| covered(intervals(s, "k")),
};

const COVERS_B: Row = Row {
    what: "B of the answer: 95 % interval covers",
    demand: Demand::Between(0.9, 0.98),
    figure: |s| covered(intervals(s, "b")),
};

const CLEAN_ROWS: [Row; 3] = [CLEAN, COVERS_K, COVERS_B];

const ROWS: [Row; 22] = [
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
        demand: Demand::AtMost(2.0 / 450.0),
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
        demand: Demand::AtLeast(0.93),
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
    COVERS_K,
    COVERS_B,
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

const QUIET: [Row; 3] = [
    Row {
        demand: Demand::AtLeast(0.97),
        ..CLEAN
    },
    COVERS_K,
    COVERS_B,
];

/// Names that a method says act.
fn affirmed(r: &Scored) -> Vec<Name> {
    match r.outcome.verdict.as_str() {
        "named" | "named_in_part" => r.outcome.names(),
        _ => Vec::new(),
    }
}

/// Rides of a class that count: clean ones all, the others where the plain model shows what is concealed.
pub fn of<'a>(scored: &'a [Scored], class: &'a str) -> Box<dyn Iterator<Item = &'a Scored> + 'a> {
    Box::new(
        scored
            .iter()
            .filter(move |r| r.class == class && (class == "clean" || r.shown)),
    )
}

/// Single-effect rides on which the effect was found.
pub fn named(scored: &[Scored]) -> impl Iterator<Item = &Scored> {
    of(scored, "single").filter(|r| matches!(r.mark, Mark::Right | Mark::InSet | Mark::Extra))
}

fn both(r: &Scored) -> bool {
    r.truth.iter().all(|t| r.outcome.names().contains(t))
}

fn share<'a>(rides: impl Iterator<Item = &'a Scored>, holds: impl Fn(&Scored) -> bool) -> Figure {
    covered(rides.map(holds))
}

pub fn errors_of(each: Vec<f64>, at: f64, percent: bool) -> Figure {
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

pub fn covered(flags: impl Iterator<Item = bool>) -> Figure {
    let flags: Vec<bool> = flags.collect();
    Figure::Share {
        of: flags.len(),
        hold: flags.iter().filter(|holds| **holds).count(),
    }
}

/// Whether the intervals of k or B cover the truth, of clean rides and of those whose effect was found.
fn intervals<'a>(scored: &'a [Scored], which: &'a str) -> impl Iterator<Item = bool> + 'a {
    let clean = of(scored, "clean").filter(|r| r.mark == Mark::Right);
    let all = clean.chain(named(scored)).flat_map(|r| &r.bias);
    all.filter(move |b| b.name == which)
        .filter_map(|b| b.covered)
}

/// Summed over rides, so that rides on which the omission hardly biased anything hardly count.
fn removed(scored: &[Scored], which: &str) -> Figure {
    let bias = named(scored)
        .flat_map(|r| &r.bias)
        .filter(|b| b.name == which);
    Figure::Sums(bias.map(|b| (b.before, b.after)).collect())
}

pub fn of_suite(suite: Suite) -> &'static [Row] {
    match suite {
        Suite::Standard => &ROWS,
        Suite::Clean300 => &CLEAN_ROWS,
        Suite::Beside => &BESIDE,
        Suite::Quiet => &QUIET,
        Suite::Strange => &ROWS[11..13],
        Suite::Conditions => &ROWS[..9],
    }
}
