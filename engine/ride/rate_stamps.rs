//! Time stamps beside a rate that the user gives: whether they say more than it, less, or something else.

/// Times the rate of the stamps from which on a rate that the user gives is another one.
const ANOTHER_RATE: f64 = 1.2;
/// Parts of a record that are compared, and how far (samples, share of the record) stamps and rate may go apart between them.
const PARTS: usize = 5;
const APART: f64 = 5.0;
const APART_SHARE: f64 = 0.002;

/// Whether many stamps repeat, or they give another rate than the user does.
pub fn are_useless(times: &[f64], scale: f64, rate_hz: f64) -> bool {
    let mut steps: Vec<f64> = times.windows(2).map(|t| scale * (t[1] - t[0])).collect();
    let repeats = steps.iter().filter(|step| **step == 0.0).count();
    steps.sort_by(f64::total_cmp);
    let usual = steps.get(steps.len() / 2).copied().unwrap_or(0.0);
    let apart = (usual * rate_hz).ln().abs();
    100 * repeats > steps.len() || !(apart < ANOTHER_RATE.ln())
}

/// Whether the stamps count samples: whole numbers, most of which are one after another.
pub fn count_samples(times: &[f64]) -> bool {
    let whole = times.iter().all(|t| t.fract() == 0.0);
    let next = times.windows(2).filter(|t| t[1] - t[0] == 1.0).count();
    whole && 2 * next > times.len()
}

/// The time (s) that coarse stamps and that the rows at this rate take, where they go apart: rows are missing, or there are too many.
pub fn contradicted(times: &[f64], rate_hz: f64) -> Option<[f64; 2]> {
    let changes: Vec<(usize, f64)> = (1..times.len())
        .filter(|row| times[*row] > times[row - 1])
        .map(|row| (row, times[row] * rate_hz - row as f64))
        .collect();
    let [first, last] = [changes.first()?, changes.last()?];
    let [stamped_s, rows_s] = [
        times[last.0] - times[first.0],
        (last.0 - first.0) as f64 / rate_hz,
    ];
    // Stamps that give another rate altogether say nothing of single rows.
    let same = (1.0 / ANOTHER_RATE..ANOTHER_RATE).contains(&(stamped_s / rows_s));
    let parts = changes.chunks(changes.len().div_ceil(PARTS));
    let middles = parts.map(|part| {
        let mut off: Vec<f64> = part.iter().map(|(_, off)| *off).collect();
        off.sort_by(f64::total_cmp);
        off[off.len() / 2]
    });
    let (least, most) = middles.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), off| {
        (least.min(off), most.max(off))
    });
    let is_apart = most - least > f64::max(APART, APART_SHARE * times.len() as f64);
    (same && is_apart).then_some([stamped_s, rows_s])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_samples_are_counted() {
        assert!(count_samples(&[3.0, 4.0, 5.0, 9.0, 10.0]));
        assert!(!count_samples(&[0.0, 2.0, 4.0, 6.0]));
        assert!(!count_samples(&[0.0, 0.5, 1.0, 1.5]));
    }

    #[test]
    fn coarse_stamps_show_rows_that_are_missing() {
        let stamps = |missing: usize, digit: f64| -> Vec<f64> {
            let rows = (0..6000).filter(|row| !(2000..2000 + missing).contains(row));
            rows.map(|row| (row as f64 / 200.0 / digit).floor() * digit)
                .collect()
        };
        for digit in [0.01, 1.0] {
            assert_eq!(contradicted(&stamps(0, digit), 200.0), None);
            assert!(
                contradicted(&stamps(30, digit), 200.0)
                    .is_some_and(|[stamped, rows]| stamped > rows)
            );
            // Another rate altogether.
            assert_eq!(contradicted(&stamps(30, digit), 400.0), None);
        }
        let twice: Vec<f64> = (0..6000)
            .map(|row| (row - row / 10) as f64 / 200.0)
            .collect();
        assert!(contradicted(&twice, 200.0).is_some_and(|[stamped, rows]| stamped < rows));
    }
}
