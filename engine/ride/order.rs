//! Rows whose times are not in order: a counter that rolled over, rows that came late, a clock that was set back.

use crate::channels::channel::Channel;
use crate::channels::table::{Spec, Table};

/// Largest share of the rows, and fewest of them, that may come late.
const LATE: f64 = 0.01;
const FEWEST_LATE: usize = 3;
/// Share of the usual step by which rows that came late stand apart from their neighbours at least.
const NEAR: f64 = 0.75;
/// Largest departure of a step from the others, in steps, where all times are those of one stretch.
const EVEN: f64 = 0.25;
/// Bits of counters.
const BITS: [i32; 5] = [8, 16, 24, 31, 32];

/// Puts the rows of a table in the order of their `times` (in the file's unit), or keeps the longest part that is; what was done is a
/// sentence. Times that are not numbers stay as they are.
pub fn put_in_order(table: &mut Table, times: &mut Vec<f64>) -> Option<String> {
    let back: Vec<usize> = (1..times.len())
        .filter(|row| times[*row] < times[row - 1])
        .collect();
    if back.is_empty() || times.iter().any(|t| t.is_nan()) {
        return None;
    }
    if times.windows(2).all(|pair| pair[1] <= pair[0]) {
        let rows: Vec<usize> = (0..times.len()).rev().collect();
        keep(table, times, &rows);
        return Some(
            "the newest row is the first: the rows are read from the last one on".to_owned(),
        );
    }
    let step = usual_step(times);
    if let Some(bits) = unrolled(times, &back, step) {
        return Some(format!(
            "the time's counter of {bits} bits rolled over {} time(s), which was undone",
            back.len()
        ));
    }
    let mut order: Vec<usize> = (0..times.len()).collect();
    order.sort_by(|a, b| times[*a].total_cmp(&times[*b]));
    if came_late(times, &order, step) {
        let late = late(times);
        keep(table, times, &order);
        return Some(format!(
            "{late} row(s) out of order were sorted by their times"
        ));
    }
    if are_even(times, &order) {
        keep(table, times, &order);
        return Some(
            "the rows are in another order than their times, as where they are sorted as text, and were sorted by these".to_owned(),
        );
    }
    let ends = back.iter().copied().chain([times.len()]);
    let begins = [0].into_iter().chain(back.iter().copied());
    let longest = begins.zip(ends).max_by_key(|(from, to)| to - from)?;
    let (from, to) = longest;
    let rows = times.len();
    let at = back[0];
    let said = format!(
        "time goes back from {:?} to {:?} in {} place(s), as where a logger starts again or its clock is set: the longest part between, \
         rows {from}:{to} of {rows}, is read; --rows FROM:TO reads another",
        times[at - 1],
        times[at],
        back.len()
    );
    keep(table, times, &(from..to).collect::<Vec<usize>>());
    Some(said)
}

/// Median of the steps forwards.
fn usual_step(times: &[f64]) -> f64 {
    let mut steps: Vec<f64> = times
        .windows(2)
        .map(|t| t[1] - t[0])
        .filter(|step| *step > 0.0)
        .collect();
    steps.sort_by(f64::total_cmp);
    steps.get(steps.len() / 2).copied().unwrap_or(0.0)
}

/// Undoes the overflow of a counter of whole numbers; its bits.
fn unrolled(times: &mut [f64], back: &[usize], step: f64) -> Option<i32> {
    let is_whole = times.iter().all(|t| t.fract() == 0.0 && *t >= 0.0);
    let fits = |bits: &i32| {
        let period = 2_f64.powi(*bits);
        let next = |row: &usize| times[*row] + period - times[row - 1];
        back.iter()
            .all(|row| (next(row) - step).abs() <= 2.0 * step)
    };
    let bits = BITS
        .into_iter()
        .find(fits)
        .filter(|_| is_whole && step > 0.0)?;
    let mut turns = 0;
    for row in 0..times.len() {
        turns += usize::from(back.binary_search(&row).is_ok());
        times[row] += turns as f64 * 2_f64.powi(bits);
    }
    Some(bits)
}

/// Rows whose times others before them have passed.
fn late(times: &[f64]) -> usize {
    let mut latest = f64::NEG_INFINITY;
    let mut late = 0;
    for time in times {
        late += usize::from(*time < latest);
        latest = latest.max(*time);
    }
    late
}

/// Whether few rows came late and fill the gaps that they left, other than those of a clock that was set back.
fn came_late(times: &[f64], order: &[usize], step: f64) -> bool {
    let most = (LATE * times.len() as f64).max(FEWEST_LATE as f64);
    let near = |a: f64, b: f64| b - a < NEAR * step;
    let repeats = order
        .windows(2)
        .filter(|rows| near(times[rows[0]], times[rows[1]]))
        .count();
    let before = times
        .windows(2)
        .filter(|t| t[1] >= t[0] && near(t[0], t[1]))
        .count();
    late(times) as f64 <= most && repeats <= before
}

/// Whether the times in this order are even and none repeats, as those of one stretch.
fn are_even(times: &[f64], order: &[usize]) -> bool {
    let steps = || order.windows(2).map(|rows| times[rows[1]] - times[rows[0]]);
    let [Some(first), Some(last)] =
        [order.first(), order.last()].map(|row| row.map(|row| times[*row]))
    else {
        return false;
    };
    let step = (last - first) / (order.len().max(2) - 1) as f64;
    step > 0.0 && steps().all(|s| (s - step).abs() <= EVEN * step)
}

/// Leaves out rows that are the ones before once more, if every time that repeats stands in such a row; what was done is a sentence.
pub fn leave_out_twice(table: &mut Table) {
    let time = |(spec, _): &&(Spec, Vec<f64>)| spec.channel == Channel::Time;
    let Some((spec, times)) = table.columns.iter().find(time) else {
        return;
    };
    let is_alike = |a: f64, b: f64| a == b || a.is_nan() && b.is_nan();
    let is_twice = |row: usize| {
        let mut columns = table.columns.iter().map(|(_, values)| values);
        columns.all(|values| is_alike(values[row], values[row - 1]))
    };
    let repeats: Vec<usize> = (1..times.len())
        .filter(|row| times[*row] == times[row - 1])
        .collect();
    if repeats.is_empty()
        || repeats.len() + 1 == times.len()
        || table.columns.len() < 2
        || !repeats.iter().all(|row| is_twice(*row))
    {
        return;
    }
    let said = format!(
        "{} row(s) repeat the one before, with the same {}, and were left out",
        repeats.len(),
        spec.header
    );
    let rows: Vec<usize> = (0..times.len())
        .filter(|row| repeats.binary_search(row).is_err())
        .collect();
    leave(table, &rows);
    table.reading.push(said);
}

/// Leaves these rows, in this order.
fn keep(table: &mut Table, times: &mut Vec<f64>, rows: &[usize]) {
    *times = rows.iter().map(|row| times[*row]).collect();
    leave(table, rows);
}

fn leave(table: &mut Table, rows: &[usize]) {
    let kept = |values: &[f64]| -> Vec<f64> { rows.iter().map(|row| values[*row]).collect() };
    for (_, values) in &mut table.columns {
        *values = kept(values);
    }
    table.rows = rows.len();
    table.places = table.places.of_rows(rows);
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::formats::csv;
    use crate::options::ReadOptions;

    fn put(times: &[f64]) -> (Vec<f64>, String) {
        let (mut table, mut times) = (Table::default(), times.to_vec());
        let said = put_in_order(&mut table, &mut times);
        (times, said.unwrap_or_default())
    }

    #[test]
    fn counters_that_roll_over_go_on() {
        let top = 65_536.0;
        let (times, said) = put(&[top - 10.0, top - 5.0, 0.0, 5.0]);
        assert_eq!(times, [top - 10.0, top - 5.0, top, top + 5.0]);
        assert!(said.contains("16 bits"), "{said}");
    }

    #[test]
    fn rows_that_came_late_are_sorted() {
        let (times, said) = put(&[0.0, 1.0, 4.0, 5.0, 2.0, 3.0, 6.0, 7.0]);
        assert_eq!(times, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
        assert!(said.contains("2 row(s) out of order"), "{said}");
    }

    #[test]
    fn the_longest_part_is_read_where_a_clock_was_set_back() {
        let (times, said) = put(&[0.0, 1.0, 2.0, 3.0, 4.0, 1.5, 2.5, 3.5]);
        assert_eq!(times, [0.0, 1.0, 2.0, 3.0, 4.0]);
        assert!(said.contains("rows 0:5 of 8"), "{said}");
    }

    #[test]
    fn rows_in_another_order_are_sorted_where_all_is_one_stretch() {
        let (times, said) = put(&[4.0, 3.0, 2.0, 2.0, 1.0]);
        assert_eq!(times, [1.0, 2.0, 2.0, 3.0, 4.0]);
        assert!(said.contains("newest"), "{said}");
        let (times, said) = put(&[0.0, 10.0, 11.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0]);
        assert_eq!((times[2], times[11]), (2.0, 11.0));
        assert!(said.contains("sorted as text"), "{said}");
        // A clock that was set back by more than the part before.
        let (times, _) = put(&[20.0, 21.0, 22.0, 23.0, 24.0, 25.0, 1.0, 2.0, 3.0, 4.0]);
        assert_eq!(times.len(), 6);
    }

    #[test]
    fn rows_that_stand_twice_are_read_once() {
        let rows = |text: &str| {
            let text = format!("t,z_f\n{text}");
            let mut table = csv::read(text.as_bytes(), &ReadOptions::default()).unwrap();
            leave_out_twice(&mut table);
            (table.rows, table.columns[1].1.clone())
        };
        assert_eq!(rows("0,1\n0,1\n1,1\n1,1\n2,3\n"), (3, vec![1.0, 1.0, 3.0]));
        // Coarse stamps of different samples.
        assert_eq!(rows("0,1\n0,1\n1,1\n1,2\n").0, 4);
    }

    #[test]
    fn times_in_order_stay() {
        assert_eq!(
            put(&[0.0, 1.0, 1.0, 2.0]),
            (vec![0.0, 1.0, 1.0, 2.0], String::new())
        );
    }
}
