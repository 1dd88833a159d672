//! What a row of the main table shows, what was demanded of it, and whether so few rides can miss that by chance.

use std::fmt;

use statrs::distribution::{Binomial, DiscreteCDF};

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Demand {
    Nothing,
    /// Shares of the rides.
    AtLeast(f64),
    AtMost(f64),
    Between(f64, f64),
    /// A quantile of an error at most so large.
    Quantile(f64, f64),
    /// A share of a sum over all rides; by chance it is as bad on half of them.
    Removed(f64),
}

#[derive(Clone, Debug, PartialEq)]
pub enum Figure {
    Share {
        of: usize,
        hold: usize,
    },
    /// Each ride's error; it is written with a number of digits, or as a percentage.
    Errors {
        each: Vec<f64>,
        at: f64,
        percent: bool,
    },
    /// What was to be removed and what is left, of each axle.
    Sums(Vec<(f64, f64)>),
}

/// A demanded rate that these rides fall short of, and how likely that is where it is met.
pub struct Short {
    pub hold: usize,
    pub of: usize,
    pub rate: f64,
    pub chance: f64,
}

impl Demand {
    /// The counts that the demand is about, with the least rate at which a ride is to hold.
    fn counts(self, figure: &Figure) -> Vec<(usize, usize, f64)> {
        let over = |each: &mut dyn Iterator<Item = bool>, rate: f64| {
            let flags: Vec<bool> = each.collect();
            let hold = flags.iter().filter(|holds| **holds).count();
            vec![(hold, flags.len(), rate)]
        };
        match (self, figure) {
            (Self::AtLeast(rate), &Figure::Share { of, hold }) => vec![(hold, of, rate)],
            (Self::AtMost(rate), &Figure::Share { of, hold }) => vec![(of - hold, of, 1.0 - rate)],
            (Self::Between(low, high), &Figure::Share { of, hold }) => {
                vec![(hold, of, low), (of - hold, of, 1.0 - high)]
            }
            (Self::Quantile(at, most), Figure::Errors { each, .. }) => {
                over(&mut each.iter().map(|error| *error <= most), at)
            }
            (Self::Removed(share), Figure::Sums(each)) => over(
                &mut each.iter().map(|(b, a)| a <= &((1.0 - share) * b)),
                0.5,
            ),
            _ => Vec::new(),
        }
    }

    /// What falls so far short that rides which meet the demand would do so with less than `doubt`.
    pub fn short(self, figure: &Figure, doubt: f64) -> Option<Short> {
        self.counts(figure)
            .into_iter()
            .find_map(|(hold, of, rate)| {
                let chance = Binomial::new(rate, of as u64).ok()?.cdf(hold as u64);
                (chance < doubt).then_some(Short {
                    hold,
                    of,
                    rate,
                    chance,
                })
            })
    }
}

impl fmt::Display for Demand {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let percent = |share: f64| (10_000.0 * share).round() / 100.0;
        match *self {
            Self::Nothing => Ok(()),
            Self::AtLeast(share) | Self::Removed(share) => write!(f, ">= {} %", percent(share)),
            Self::AtMost(share) => write!(f, "<= {} %", percent(share)),
            Self::Between(low, high) => write!(f, "{}-{} %", percent(low), percent(high)),
            Self::Quantile(_, most) if most < 1.0 => write!(f, "<= {} %", percent(most)),
            Self::Quantile(_, most) => write!(f, "<= {most}"),
        }
    }
}

impl fmt::Display for Figure {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Share { of: 0, .. } => f.write_str("-"),
            Self::Share { of, hold } => {
                write!(
                    f,
                    "{:.1} % ({hold}/{of})",
                    100.0 * *hold as f64 / *of as f64
                )
            }
            Self::Errors { each, at, percent } => match (quantile(each, *at), percent) {
                (None, _) => f.write_str("-"),
                (Some(error), true) => write!(f, "{:.2} %", 100.0 * error),
                (Some(error), false) => write!(f, "{error:.3}"),
            },
            Self::Sums(each) => {
                let sum = each.iter().fold((0.0, 0.0), |s, e| (s.0 + e.0, s.1 + e.1));
                if sum.0 == 0.0 {
                    return f.write_str("-");
                }
                write!(f, "{:.1} %", 100.0 * (1.0 - sum.1 / sum.0))
            }
        }
    }
}

/// The nearest value at a share of the sorted values.
pub fn quantile(values: &[f64], at: f64) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len().checked_sub(1)?;
    sorted.get((last as f64 * at).round() as usize).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn share(hold: usize, of: usize) -> Figure {
        Figure::Share { of, hold }
    }

    /// Whether the least count that is within the bound, and the next one below it, are told apart.
    fn bound_lies_at(demand: Demand, passes: Figure, fails: Figure) {
        assert!(demand.short(&passes, 0.01).is_none(), "{passes:?}");
        assert!(demand.short(&fails, 0.01).is_some(), "{fails:?}");
    }

    /// Expected counts summed apart from this, in Python's whole numbers.
    #[test]
    fn a_row_fails_where_chance_alone_hardly_misses_its_demand_so_far() {
        bound_lies_at(Demand::AtLeast(0.95), share(21, 25), share(20, 25));
        bound_lies_at(Demand::AtLeast(0.95), share(137, 151), share(136, 151));
        bound_lies_at(Demand::AtMost(0.05), share(4, 25), share(5, 25));
        bound_lies_at(Demand::AtMost(0.01), share(2, 25), share(3, 25));
        let coverage = Demand::Between(0.9, 0.98);
        bound_lies_at(coverage, share(125, 149), share(124, 149));
        assert!(coverage.short(&share(149, 149), 0.01).is_none());
        assert!(coverage.short(&share(300, 300), 0.01).is_some());
    }

    #[test]
    fn quantiles_and_sums_are_held_to_their_demands_ride_by_ride() {
        let errors = |large: usize| Figure::Errors {
            each: [vec![0.2; large], vec![0.001; 25 - large]].concat(),
            at: 0.9,
            percent: true,
        };
        bound_lies_at(Demand::Quantile(0.9, 0.05), errors(6), errors(7));
        let sums = |bad: usize| {
            Figure::Sums([vec![(1.0, 0.5); bad], vec![(1.0, 0.05); 25 - bad]].concat())
        };
        bound_lies_at(Demand::Removed(0.9), sums(18), sums(19));
    }

    #[test]
    fn rows_without_rides_or_demand_cannot_fail() {
        assert!(Demand::AtLeast(0.95).short(&share(0, 0), 0.01).is_none());
        assert!(Demand::Nothing.short(&share(0, 9), 0.01).is_none());
    }
}
