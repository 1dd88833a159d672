//! How even the times of several columns are, of which one is the ride's.

use super::moment::EPOCHS_S;
use super::number::number;
use super::times::{Order, Times};

/// Fewest samples that show how even steps are.
pub const FEWEST_STEPS: usize = 10;
/// Largest difference of the spans of one clock, in decimal digits: its last step may jitter.
const SAME: f64 = 0.005;
/// Differences of steps (in steps) that do not count.
const EVEN: f64 = 0.02;

/// The steps of a column in the sampled rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pace {
    /// The first, 0 of dates, and from it to the last, in the column's unit.
    start: f64,
    span: f64,
    /// Whether the column says when it was recorded, not how long after some start.
    is_dated: bool,
    /// Largest departure of a step from the mean one, in mean steps.
    unevenness: f64,
}

/// That of a column whose cells do not fall; none of others.
pub fn pace(rows: &[Vec<String>], column: usize, order: Order, decimal: u8) -> Option<Pace> {
    let mut times = Times::new(order, None);
    let mut first = None;
    let mut value = |row: &Vec<String>| -> Option<f64> {
        let cell = row.get(column)?;
        match times.read(cell.as_bytes()) {
            Some(moment) => Some(moment.since(*first.get_or_insert(moment))),
            None => Some(number(cell.as_bytes(), decimal)?.value),
        }
    };
    // The last row of the sample may be cut short.
    let sampled = &rows[..rows.len().saturating_sub(1)];
    let values: Vec<f64> = sampled.iter().map(&mut value).collect::<Option<_>>()?;
    let span = values.last()? - values.first()?;
    let mean = span / (values.len() - 1) as f64;
    let steps = values.windows(2).map(|pair| pair[1] - pair[0]);
    let rises = values.len() >= FEWEST_STEPS && span > 0.0 && steps.clone().all(|step| step >= 0.0);
    let start = *values.first()?;
    let is_epoch = |unit: f64| EPOCHS_S.contains(&(unit * start));
    rises.then(|| Pace {
        start,
        span,
        is_dated: first.is_some() || [1.0, 1e-3, 1e-6, 1e-9].into_iter().any(is_epoch),
        unevenness: steps
            .map(|step| (step / mean - 1.0).abs())
            .fold(0.0, f64::max),
    })
}

/// Of several columns of times that show one clock, each in its unit, the one whose steps are most even; none where they may be several
/// clocks. Columns that do not rise are no times.
pub fn steadiest(columns: &[usize], paces: &[Option<Pace>]) -> Option<usize> {
    let paced = columns
        .iter()
        .filter_map(|at| Some((*at, (*paces.get(*at)?)?)));
    let paced: Vec<(usize, Pace)> = paced.collect();
    let first = paced.first()?.1;
    // Times of two sensors in one unit, each since its own start, may be two clocks.
    let are_one = |a: &Pace, b: &Pace| {
        let digits = (a.span / b.span).log10();
        let in_one_unit = digits.round() == 0.0 && a.is_dated == b.is_dated;
        let begin_together = (a.start - b.start).abs() <= EVEN * a.span / FEWEST_STEPS as f64;
        (digits - digits.round()).abs() < SAME && (!in_one_unit || begin_together)
    };
    let is_same = |pace: &Pace| are_one(&first, pace);
    if !paced.iter().all(|(_, pace)| is_same(pace)) {
        return None;
    }
    let least = paced
        .iter()
        .map(|(_, pace)| pace.unevenness)
        .fold(f64::INFINITY, f64::min);
    let even = paced
        .iter()
        .find(|(_, pace)| pace.unevenness <= least + EVEN);
    even.map(|(at, _)| *at)
}
