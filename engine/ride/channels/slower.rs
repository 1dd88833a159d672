//! Slower channels that a logger wrote at the rate of its table: each value repeated, or drawn straight to the next.

use crate::channels::channel::Channel;
use crate::channels::table::Spec;

/// Most samples from one measured value to the next.
const LONGEST: usize = 64;
/// Share of the samples between that must be repeated, or lie on a straight line to within `ROUNDING` of a step between measured values.
const SHARE: f64 = 0.99;
const ROUNDING: f64 = 1e-3;
/// Fewest measured values.
const FEWEST: usize = 20;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum How {
    Held,
    Straight,
}

/// A channel of which every `every`th sample from row `first` on was measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Slower {
    pub how: How,
    pub every: usize,
    pub first: usize,
}

/// Most rows, and fewest, from one value of a speed to the next that was measured, and share of the changes that must lie so.
const SPEED_ROWS: std::ops::RangeInclusive<usize> = 5..=2000;
const SPEED_SHARE: f64 = 0.8;
/// Fewest values of a speed.
const FEWEST_SPEEDS: usize = 8;

/// Finds out whether a channel that an axle rests on, or the speed, is slower than its table.
pub fn find(spec: &Spec, values: &[f64]) -> Option<Slower> {
    if spec.channel == Channel::Speed {
        return held_speed(values);
    }
    let has_motion = matches!(
        spec.channel,
        Channel::Road(_)
            | Channel::Displacement(_)
            | Channel::Deflection(_)
            | Channel::Acceleration(_)
    );
    if !has_motion || values.iter().any(|v| v.is_nan()) {
        return None;
    }
    held(values).or_else(|| straight(values))
}

impl Slower {
    /// Blanks what lies between.
    pub fn leave_measured(self, values: &mut [f64]) {
        for (row, value) in values.iter_mut().enumerate() {
            if row < self.first || !(row - self.first).is_multiple_of(self.every) {
                *value = f64::NAN;
            }
        }
    }
}

/// The commonest distance of these rows, and that of the most of them from a multiple of it.
fn regular(rows: &[usize]) -> Option<(usize, usize)> {
    let distances = || rows.windows(2).map(|r| r[1] - r[0]);
    let mut counts = [0_usize; LONGEST + 1];
    distances()
        .filter(|d| *d <= LONGEST)
        .for_each(|d| counts[d] += 1);
    let every = (2..=LONGEST).max_by_key(|d| counts[*d])?;
    let mut phases = [0_usize; LONGEST];
    rows.iter().for_each(|row| phases[row % every] += 1);
    let first = (0..every).max_by_key(|phase| phases[*phase])?;
    // Two measured values may be alike, or three on a line: distances are then multiples.
    let is_regular = phases[first] as f64 >= SHARE * rows.len() as f64;
    (is_regular && rows.len() >= FEWEST).then_some((every, first))
}

fn held(values: &[f64]) -> Option<Slower> {
    let changes: Vec<usize> = (1..values.len())
        .filter(|row| values[*row] != values[row - 1])
        .collect();
    let (every, first) = regular(&changes)?;
    // A sensor that stands still now and then is not slower.
    let is_often = changes.len() * every * 2 > values.len();
    is_often.then_some(Slower {
        how: How::Held,
        every,
        first,
    })
}

/// A speed that is repeated until the next is measured, once a second or so: many changes may be too small to show.
fn held_speed(values: &[f64]) -> Option<Slower> {
    let changes: Vec<usize> = (1..values.len())
        .filter(|row| values[*row] != values[row - 1])
        .collect();
    let mut distances: Vec<usize> = changes.windows(2).map(|r| r[1] - r[0]).collect();
    distances.sort_unstable();
    let most = distances
        .chunk_by(|a, b| a == b)
        .max_by_key(|run| run.len())?;
    let every = most[0];
    let first = changes[0] % every.max(1);
    let phase = |row: &&usize| {
        let off = (**row + every - first) % every;
        off.min(every - off) * 20 <= every
    };
    let regular = changes.iter().filter(phase).count();
    let is_regular = regular as f64 >= SPEED_SHARE * changes.len() as f64;
    let is_one = SPEED_ROWS.contains(&every) && changes.len() >= FEWEST_SPEEDS && is_regular;
    is_one.then_some(Slower {
        how: How::Held,
        every,
        first,
    })
}

fn straight(values: &[f64]) -> Option<Slower> {
    let inner = 1..values.len().saturating_sub(1);
    let bend = |row: usize| values[row - 1] - 2.0 * values[row] + values[row + 1];
    let most = inner.clone().map(|row| bend(row).abs()).fold(0.0, f64::max);
    let rounding = rounding(values).max(f64::EPSILON * most);
    let corners: Vec<usize> = inner
        .filter(|row| bend(*row).abs() > 4.0 * rounding)
        .collect();
    let (every, first) = regular(&corners)?;
    let is_often = corners.len() * every * 2 > values.len();
    // Steps that are hardly larger than what the file's digits leave are no corners.
    let is_sharp = rounding < ROUNDING * most;
    (is_often && is_sharp).then_some(Slower {
        how: How::Straight,
        every,
        first,
    })
}

/// Half of the last digit that the values were written with, as far as their least difference shows it.
fn rounding(values: &[f64]) -> f64 {
    let largest = values.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    let mut digit = 1e-12;
    while digit < largest {
        let is_multiple = |v: &f64| (v / digit - (v / digit).round()).abs() < 1e-3;
        let coarser = 10.0 * digit;
        let fits_coarser = |v: &f64| (v / coarser - (v / coarser).round()).abs() < 1e-3;
        let some = || values.iter().step_by((values.len() / 500).max(1));
        if some().all(is_multiple) && !some().all(fits_coarser) {
            return 0.5 * digit;
        }
        digit = coarser;
    }
    0.0
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::channels::unit::{Dimension, Unit};
    use veloid_core::bicycle::Axle;

    fn spec() -> Spec {
        Spec {
            number: 1,
            header: "a_r".to_owned(),
            channel: Channel::Acceleration(Axle::Rear),
            unit: Unit::si(Dimension::Acceleration),
            is_guess: false,
        }
    }

    fn motion(count: usize) -> Vec<f64> {
        let at = |i: usize| 3.0 * (0.31 * i as f64).sin() + 2.0 * (0.83 * i as f64).cos();
        (0..count).map(at).collect()
    }

    fn written(values: Vec<f64>, digits: f64) -> Vec<f64> {
        values
            .into_iter()
            .map(|v| (v / digits).round() * digits)
            .collect()
    }

    #[test]
    fn repeated_and_interpolated_channels_are_found() {
        let fast = motion(2000);
        assert_eq!(find(&spec(), &fast), None);
        let held: Vec<f64> = (0..2000).map(|i| fast[i / 4 * 4]).collect();
        let found = find(&spec(), &held).unwrap();
        assert_eq!(
            found,
            Slower {
                how: How::Held,
                every: 4,
                first: 0
            }
        );
        let between = |i: usize| {
            let (at, part) = (i / 4 * 4, (i % 4) as f64 / 4.0);
            fast[at] + part * (fast[(at + 4).min(1999)] - fast[at])
        };
        let straight: Vec<f64> = (0..1990).map(between).collect();
        for values in [straight.clone(), written(straight, 1e-7)] {
            let found = find(&spec(), &values).unwrap();
            assert_eq!(
                found,
                Slower {
                    how: How::Straight,
                    every: 4,
                    first: 0
                }
            );
            let mut kept = values.clone();
            found.leave_measured(&mut kept);
            assert_eq!(kept.iter().filter(|v| !v.is_nan()).count(), 498);
        }
    }

    #[test]
    fn a_speed_once_a_second_is_slower() {
        let speed = |row: usize| 5.0 + (row as f64 / 700.0).sin();
        let of = |values: Vec<f64>| {
            let spec = Spec {
                channel: Channel::Speed,
                ..spec()
            };
            find(&spec, &values).map(|found| (found.every, found.first))
        };
        assert_eq!(
            of((0..4000).map(|row| speed(row / 200 * 200)).collect()),
            Some((200, 0))
        );
        assert_eq!(
            of((0..4000).map(|row| speed((row + 60) / 200 * 200)).collect()),
            Some((200, 140))
        );
        assert_eq!(of((0..4000).map(speed).collect()), None);
        // Rounding makes steps at any time.
        assert_eq!(
            of((0..4000)
                .map(|row| (10.0 * speed(row)).round() / 10.0)
                .collect()),
            None
        );
    }

    #[test]
    fn coarse_or_resting_channels_are_not_slower() {
        assert_eq!(find(&spec(), &written(motion(2000), 0.5)), None);
        let mut resting = vec![0.0; 1000];
        resting.extend(motion(1000));
        assert_eq!(find(&spec(), &resting), None);
        let steps: Vec<f64> = (0..2000).map(|i| f64::from(i / 700)).collect();
        assert_eq!(find(&spec(), &steps), None);
    }
}
