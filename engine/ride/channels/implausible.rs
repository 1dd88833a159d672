//! Samples that no axle did: a logger's spikes, far outside of everything else that a channel holds.

use crate::channels::channel::Channel;
use crate::channels::table::Spec;
use veloid_core::bicycle::Axle;

/// Most samples in a row that a logger spoils at once.
const LONGEST: usize = 3;
/// Longest (s) such a run: a third of a swing of a bicycle's vertical mode near 11 Hz, in which no axle goes out and
/// comes back.
const LONGEST_S: f64 = 1.0 / 33.0;
/// How far outside the others a displacement lies, in spans of these: an axle that swings cannot leave its range by as
/// much as that is wide and be back within a third of a swing.
const OUTSIDE: f64 = 1.0;
/// The same of road and deflection, where a real bump may be a sample short. The axle then moves by a good part of its
/// height, so that the span is that of whichever moves most.
const OUTSIDE_ROAD: f64 = 10.0;
/// Largest share of implausible samples that is a logger's hiccup.
const MOST: f64 = 0.01;

/// How often a range is widened at most: each time more than doubles it, and sensors span less than 2^60.
const MOST_WIDENED: usize = 60;

/// The implausible samples of one channel.
#[derive(Debug, PartialEq)]
pub struct Implausible {
    /// Which column.
    pub column: usize,
    pub rows: Vec<usize>,
    /// Samples that the channel has.
    pub samples: usize,
}

impl Implausible {
    pub fn too_many(&self) -> bool {
        let most = (MOST * self.samples as f64).max(LONGEST as f64);
        self.rows.len() as f64 > most
    }
}

/// Finds them in columns (SI) of a file of `duration_s`.
pub fn find(columns: &[(Spec, Vec<f64>)], duration_s: f64) -> Vec<Implausible> {
    let found: Vec<Option<Found>> = (columns.iter())
        .map(|(spec, values)| axle(spec.channel).and_then(|_| Found::of(values, duration_s)))
        .collect();
    let widest = |of: Axle| {
        (columns.iter().zip(&found))
            .filter(|((spec, _), _)| axle(spec.channel) == Some(of))
            .filter_map(|(_, found)| found.as_ref().map(|f| f.range.span()))
            .fold(0.0, f64::max)
    };
    let mut out = Vec::new();
    for (column, ((spec, values), found)) in columns.iter().zip(&found).enumerate() {
        let (Some(axle), Some(found)) = (axle(spec.channel), found) else {
            continue;
        };
        let reach = match spec.channel {
            Channel::Displacement(_) => 0.0,
            _ => OUTSIDE_ROAD * widest(axle),
        };
        let rows: Vec<usize> = (found.rows.iter().copied())
            .filter(|row| found.range.is_beyond(values[*row], reach))
            .collect();
        if !rows.is_empty() {
            let samples = found.samples;
            out.push(Implausible {
                column,
                rows,
                samples,
            });
        }
    }
    out
}

/// What lies outside of a channel's range in short runs.
struct Found {
    range: Range,
    rows: Vec<usize>,
    samples: usize,
}

impl Found {
    /// `None` if all samples are equal. Whatever lies outside for longer than a logger's spike is the axle's own, and
    /// widens the range that the others are seen from.
    fn of(values: &[f64], duration_s: f64) -> Option<Self> {
        let mut range = Range::of(values, OUTSIDE)?;
        let rows: Vec<usize> = (0..values.len()).filter(|i| !values[*i].is_nan()).collect();
        let (samples, step_s) = (rows.len(), duration_s / rows.len() as f64);
        let longest = ((LONGEST_S / step_s) as usize).min(LONGEST);
        for _ in 0..MOST_WIDENED {
            let reach = OUTSIDE * range.span();
            let is_out = |row: &usize| range.is_beyond(values[*row], reach);
            let runs = rows.chunk_by(|a, b| is_out(a) && is_out(b));
            let (mut wider, mut short) = (range, Vec::new());
            for run in runs.filter(|run| is_out(&run[0])) {
                if run.len() <= longest {
                    short.extend_from_slice(run);
                } else {
                    run.iter().for_each(|row| wider.take(values[*row]));
                }
            }
            if wider == range {
                return Some(Self {
                    range,
                    rows: short,
                    samples,
                });
            }
            range = wider;
        }
        None
    }
}

fn axle(channel: Channel) -> Option<Axle> {
    match channel {
        Channel::Displacement(axle) | Channel::Road(axle) | Channel::Deflection(axle) => Some(axle),
        _ => None,
    }
}

/// Where a channel's samples lie that hang together.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Range {
    low: f64,
    high: f64,
}

impl Range {
    /// From the middle half outwards as long as the next sample is within `reach` spans; `None` if all are equal.
    fn of(values: &[f64], reach: f64) -> Option<Self> {
        let mut sorted: Vec<f64> = values.iter().copied().filter(|v| !v.is_nan()).collect();
        sorted.sort_unstable_by(f64::total_cmp);
        let n = sorted.len();
        let (mut first, mut last) = (n / 4, (3 * n / 4).min(n.checked_sub(1)?));
        loop {
            let (low, high) = (sorted[first], sorted[last]);
            let below = first
                .checked_sub(1)
                .map_or(f64::INFINITY, |i| low - sorted[i]);
            let above = sorted.get(last + 1).map_or(f64::INFINITY, |v| v - high);
            let near = below.min(above);
            let equal = high <= low;
            if near.is_infinite() || !equal && near > reach * (high - low) {
                return (!equal).then_some(Self { low, high });
            }
            if below <= above {
                first -= 1;
            } else {
                last += 1;
            }
        }
    }

    fn span(&self) -> f64 {
        self.high - self.low
    }

    fn take(&mut self, value: f64) {
        self.low = self.low.min(value);
        self.high = self.high.max(value);
    }

    fn is_beyond(&self, value: f64, reach: f64) -> bool {
        value < self.low - reach || value > self.high + reach
    }
}
