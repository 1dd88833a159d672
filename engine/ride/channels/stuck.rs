//! Samples that a sensor did not measure: the last value repeated while the axle moves on, and zeros, or the end of its range, in place of values
//! that were lost.

use crate::channels::channel::Channel;
use crate::channels::table::Spec;
use veloid_core::bicycle::Axle;

/// Shortest time (s) and fewest samples for which a sensor that repeats one value is stuck: five swings of an axle at 10 Hz.
const SHORTEST_S: f64 = 0.5;
const FEWEST: usize = 12;
/// How much another channel of the ride must go on moving meanwhile: its steps beside those of the whole record.
const MOVES: f64 = 0.3;
/// And how widely: its standard deviation beside that of the whole record. Of a test that holds still on purpose only noise moves on.
const WIDELY: f64 = 0.1;
/// How many times the usual distance from the mean of its neighbours a value must be, to be none of the motion; and the fewest of such values.
const APART: f64 = 8.0;
const LOST: usize = 3;
/// Change of speed (m/s^2) that no bicycle reaches: gravity.
const FASTEST_M_S2: f64 = 9.8;
/// How far beyond all others the end of a range must lie, in widths of their range.
const BEYOND: f64 = 0.25;
/// Most values in a row that were lost at once.
const IN_A_ROW: usize = 3;

/// Samples of one channel that say nothing.
#[derive(Debug, PartialEq)]
pub struct Stuck {
    /// Which column.
    pub column: usize,
    pub rows: Vec<usize>,
    /// What stands in place of values that were lost (SI); else one value is repeated.
    pub lost: Option<f64>,
}

/// Finds them in columns (SI) of a file of `duration_s`.
pub fn find(columns: &[(Spec, Vec<f64>)], duration_s: f64) -> Vec<Stuck> {
    let tracks: Vec<Track> = (columns.iter())
        .map(|(spec, values)| Track::of(spec.channel, values))
        .collect();
    let mut found = Vec::new();
    for (column, track) in tracks.iter().enumerate() {
        if track.channel == Channel::Speed {
            let rows = track.impossible_stops(duration_s);
            if !rows.is_empty() {
                let lost = Some(0.0);
                found.push(Stuck { column, rows, lost });
            }
        }
        if !track.is_motion() {
            continue;
        }
        let others: Vec<&Track> = (tracks.iter())
            .filter(|other| other.channel != track.channel && track.moves_with(other))
            .collect();
        let mut add = |rows: Vec<usize>, lost: Option<f64>| {
            if !rows.is_empty() {
                found.push(Stuck { column, rows, lost });
            }
        };
        for value in track.marks() {
            add(track.lost(value), Some(value));
        }
        add(track.frozen(&others, duration_s), None);
    }
    found
}

/// The samples of a channel that are there.
struct Track<'a> {
    channel: Channel,
    values: &'a [f64],
    rows: Vec<usize>,
}

impl<'a> Track<'a> {
    fn of(channel: Channel, values: &'a [f64]) -> Self {
        let rows = (0..values.len())
            .filter(|row| !values[*row].is_nan())
            .collect();
        Self {
            channel,
            values,
            rows,
        }
    }

    fn axle(&self) -> Option<Axle> {
        match self.channel {
            Channel::Displacement(axle)
            | Channel::Road(axle)
            | Channel::Deflection(axle)
            | Channel::Acceleration(axle)
            | Channel::Force(axle) => Some(axle),
            _ => None,
        }
    }

    /// Whether it moves as long as anything on the axle does; a road may be flat.
    fn is_motion(&self) -> bool {
        matches!(
            self.channel,
            Channel::Displacement(_) | Channel::Deflection(_) | Channel::Acceleration(_)
        )
    }

    /// Whether the other channel cannot move without this one.
    fn moves_with(&self, other: &Track) -> bool {
        let accelerations = [self, other].map(|t| matches!(t.channel, Channel::Acceleration(_)));
        self.axle() == other.axle() && other.axle().is_some() || accelerations == [true, true]
    }

    /// Root mean square of the steps between the samples from `first` to `last`.
    fn steps(&self, first: usize, last: usize) -> f64 {
        let from = self.rows.partition_point(|row| *row < first);
        let to = self.rows.partition_point(|row| *row <= last);
        let steps = self.rows[from..to].windows(2);
        let squares: f64 = steps
            .clone()
            .map(|r| (self.values[r[1]] - self.values[r[0]]).powi(2))
            .sum();
        (squares / steps.len().max(1) as f64).sqrt()
    }

    /// Standard deviation of the samples from `first` to `last`.
    fn spread(&self, first: usize, last: usize) -> f64 {
        let from = self.rows.partition_point(|row| *row < first);
        let to = self.rows.partition_point(|row| *row <= last);
        let rows = &self.rows[from..to];
        let count = rows.len().max(1) as f64;
        let mean = rows.iter().map(|row| self.values[*row]).sum::<f64>() / count;
        let squares: f64 = rows
            .iter()
            .map(|row| (self.values[*row] - mean).powi(2))
            .sum();
        (squares / count).sqrt()
    }

    /// Rows after the first of runs of one value, while any of the others moves on.
    fn frozen(&self, others: &[&Track], duration_s: f64) -> Vec<usize> {
        let least = (SHORTEST_S / duration_s * self.rows.len() as f64).ceil();
        let least = FEWEST.max(least as usize);
        let runs = self
            .rows
            .chunk_by(|a, b| self.values[*a] == self.values[*b]);
        let runs = runs.filter(|run| run.len() >= least && run.len() < self.rows.len());
        let last = self.values.len().saturating_sub(1);
        let usual: Vec<[f64; 2]> = others
            .iter()
            .map(|other| [other.steps(0, last), other.spread(0, last)])
            .collect();
        let stuck = runs.filter(|run| {
            let (first, last) = (run[0], run[run.len() - 1]);
            let mut moving = others.iter().zip(&usual);
            moving.any(|(other, [steps, spread])| {
                *steps > 0.0
                    && other.steps(first, last) > MOVES * steps
                    && other.spread(first, last) > WIDELY * spread
            })
        });
        stuck.flat_map(|run| run[1..].iter().copied()).collect()
    }

    /// What may stand in place of values that were lost: zero, and the ends of an acceleration's range where they stand apart.
    fn marks(&self) -> Vec<f64> {
        let mut marks = vec![0.0];
        if matches!(self.channel, Channel::Acceleration(_)) {
            let values = || self.rows.iter().map(|row| self.values[*row]);
            let ends = [
                values().fold(f64::INFINITY, f64::min),
                values().fold(f64::NEG_INFINITY, f64::max),
            ];
            let stands_apart = |end: &f64| {
                let others = values().filter(|v| v != end);
                let (least, most) = others
                    .fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), v| {
                        (least.min(v), most.max(v))
                    });
                f64::max(least - end, end - most) > BEYOND * (most - least)
            };
            marks.extend(ends.into_iter().filter(stands_apart));
        }
        marks
    }

    /// Rows of `mark` that lie far from both neighbours; of an end of the range all do, or it was clipped.
    fn lost(&self, mark: f64) -> Vec<usize> {
        let at = |place: usize| self.values[self.rows[place]];
        let is_mark = |place: &usize| at(*place) == mark;
        let count = (0..self.rows.len()).filter(is_mark).count();
        if count < LOST {
            return Vec::new();
        }
        let inner = 1..self.rows.len().saturating_sub(1);
        let mut distances: Vec<f64> = (inner.clone())
            .map(|place| (at(place) - 0.5 * (at(place - 1) + at(place + 1))).abs())
            .collect();
        distances.sort_unstable_by(f64::total_cmp);
        let usual = distances.get(distances.len() / 2).copied().unwrap_or(0.0);
        let places: Vec<usize> = (0..self.rows.len()).collect();
        let runs = places.chunk_by(|a, b| is_mark(a) && is_mark(b));
        let lost = runs
            .filter(|run| is_mark(&run[0]) && run.len() <= IN_A_ROW)
            .filter(|run| {
                let (first, last) = (run[0], run[run.len() - 1]);
                let before = first.checked_sub(1).map(at);
                let after = (last + 1 < places.len()).then(|| at(last + 1));
                let mean = before.zip(after).map(|(a, b)| 0.5 * (a + b));
                mean.is_some_and(|mean| (mean - mark).abs() > APART * usual)
            });
        let rows: Vec<usize> = lost.flatten().map(|place| self.rows[*place]).collect();
        match rows.len() >= LOST && (mark == 0.0 || rows.len() == count) {
            true => rows,
            false => Vec::new(),
        }
    }

    /// Rows in which a speed is zero, or a negative mark, between others that no bicycle brakes from, or comes to, so fast.
    fn impossible_stops(&self, duration_s: f64) -> Vec<usize> {
        let step_s = duration_s / self.values.len().max(2) as f64;
        let runs = self
            .rows
            .chunk_by(|a, b| self.values[*a] <= 0.0 && self.values[*b] <= 0.0);
        let runs: Vec<&[usize]> = runs.collect();
        let jumps = |a: usize, b: usize| {
            let change = (self.values[a] - self.values[b]).abs();
            change > FASTEST_M_S2 * b.abs_diff(a) as f64 * step_s
        };
        let impossible = runs.iter().enumerate().filter(|(place, run)| {
            let (first, last) = (run[0], run[run.len() - 1]);
            let before = place.checked_sub(1).map(|p| runs[p][runs[p].len() - 1]);
            let after = runs.get(place + 1).map(|next| next[0]);
            self.values[first] <= 0.0
                && (before.is_some() || after.is_some())
                && before.is_none_or(|before| jumps(before, first))
                && after.is_none_or(|after| jumps(last, after))
        });
        impossible
            .flat_map(|(_, run)| run.iter().copied())
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::channels::unit::Unit;

    fn spec(channel: Channel) -> Spec {
        Spec {
            number: 1,
            header: channel.name().to_owned(),
            is_guess: false,
            channel,
            unit: Unit {
                name: "m".to_owned(),
                scale: 1.0,
            },
        }
    }

    fn wave(hz: f64) -> Vec<f64> {
        let at = |i: i32| 1e-3 * (std::f64::consts::TAU * hz * f64::from(i) / 100.0).sin() + 2e-3;
        (0..3000).map(at).collect()
    }

    fn found(z: Vec<f64>, u: Vec<f64>) -> Vec<Stuck> {
        let axle = Axle::Front;
        let columns = [
            (spec(Channel::Displacement(axle)), z),
            (spec(Channel::Road(axle)), u),
        ];
        find(&columns, 30.0)
    }

    #[test]
    fn a_value_that_is_repeated_while_the_road_moves_is_no_measurement() {
        let frozen = |samples: usize| {
            let mut z = wave(3.0);
            let value = z[999];
            z[1000..1000 + samples].fill(value);
            z
        };
        let least = (SHORTEST_S * 100.0) as usize;
        assert_eq!(found(wave(3.0), wave(3.3)), []);
        assert_eq!(found(frozen(least - 2), wave(3.3)), []);
        let stuck = found(frozen(least), wave(3.3));
        assert_eq!(stuck.len(), 1);
        assert_eq!(stuck[0].rows, (1000..1000 + least).collect::<Vec<_>>());
        // At rest on a flat road both stand still.
        let mut flat = wave(3.3);
        flat[990..1000 + least].fill(0.5);
        assert_eq!(found(frozen(least), flat), []);
        // A little less motion of the road than is asked for.
        let little = |share: f64| {
            let mut u = wave(3.3);
            let middle = u[1000];
            let inside = 990..1010 + least;
            inside.for_each(|i| u[i] = middle + share * MOVES * (u[i] - middle));
            found(frozen(least), u).len()
        };
        assert_eq!((little(0.5), little(2.0)), (0, 1));
    }

    #[test]
    fn zeros_between_other_values_are_lost_samples() {
        let lost = |rows: &[usize]| {
            let mut z = wave(3.0);
            rows.iter().for_each(|row| z[*row] = 0.0);
            found(z, wave(3.3))
                .iter()
                .map(|s| s.rows.len())
                .sum::<usize>()
        };
        assert_eq!(lost(&[500, 900, 1300, 1301]), 4);
        assert_eq!(lost(&[500, 900][..LOST - 1]), 0);
        assert_eq!(lost(&[500, 501, 502, 503]), 0, "longer than a hiccup");
        // A motion about zero passes through it, however coarsely it is read.
        let z: Vec<f64> = wave(3.0).iter().map(|x| x - 2e-3).collect();
        assert_eq!(found(z.clone(), wave(3.3)), []);
        let coarse = z.iter().map(|x| (x / 1e-4).round() * 1e-4);
        assert_eq!(found(coarse.collect(), wave(3.3)), []);
    }

    #[test]
    fn the_end_of_a_range_far_from_its_neighbours_is_no_measurement() {
        let marked = |rows: &[usize], mark: f64| {
            let mut a = wave(3.0);
            rows.iter().for_each(|row| a[*row] = mark);
            let columns = [(spec(Channel::Acceleration(Axle::Front)), a)];
            find(&columns, 30.0).first().map(|s| (s.rows.len(), s.lost))
        };
        // The others lie from 1 to 3.
        assert_eq!(marked(&[500, 900, 1300], -0.008), Some((3, Some(-0.008))));
        assert_eq!(marked(&[500, 900], -0.008), None);
        assert_eq!(marked(&[500, 900, 1300], 3.6e-3), Some((3, Some(3.6e-3))));
        assert_eq!(marked(&[500, 900, 1300], 3.4e-3), None);
    }

    #[test]
    fn a_speed_that_no_brake_explains_is_no_measurement() {
        let stops = |ramp: usize| {
            let mut v = vec![5.0; 3000];
            v[1000..1500].fill(0.0);
            for i in 0..ramp {
                v[1000 - ramp + i] = 5.0 * (1.0 - i as f64 / ramp as f64);
                v[1500 + i] = 5.0 * i as f64 / ramp as f64;
            }
            find(&[(spec(Channel::Speed), v)], 30.0)
                .first()
                .map_or(0, |s| s.rows.len())
        };
        assert_eq!(stops(1), 501);
        assert_eq!(stops(200), 0);
        let mut late = vec![5.0; 3000];
        late[..300].fill(0.0);
        assert_eq!(
            find(&[(spec(Channel::Speed), late)], 30.0)[0].rows.len(),
            300
        );
        assert_eq!(find(&[(spec(Channel::Speed), vec![0.0; 3000])], 30.0), []);
    }
}
