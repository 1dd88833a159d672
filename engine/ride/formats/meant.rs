//! Numbers of a table that stand for something else: days since 1900 for times, and -999 and the like for missing values.

use veloid_core::document::format_number::significant;

use crate::channels::channel::Channel;
use crate::channels::table::Table;
use crate::channels::unit::Unit;
use crate::formats::moment::EPOCHS_S;
use crate::order::leave_out_twice;

/// Days between the zeros of spreadsheets (30 December 1899) and of MATLAB (the year 0) and 1970, and the seconds of one.
const ZEROS: [(f64, &str); 2] = [
    (25_569.0, "1900, as spreadsheets count them"),
    (719_529.0, "the year 0, as MATLAB's datenum counts them"),
];
const DAY_S: f64 = 86_400.0;
/// Longest mean step (days) of times of day as fractions of a day: in seconds it would be faster than any clock that is read.
const FRACTION_STEP: f64 = 1e-6;
/// Fractions of a day that are times of day, not times since the start.
const FRACTIONS: std::ops::Range<f64> = 0.05..1.0;
/// Longest mean step (s) of a column that cannot be in seconds: no logger is faster.
const FASTEST_S: f64 = 1.0 / 52e3;
/// Numbers that loggers write for missing values: nines, and the ends of 16 bits.
const SENTINELS: [f64; 12] = [
    -999.0, -9999.0, -99_999.0, -999.25, 999.0, 9999.0, 99_999.0, 999_999.0, -32_768.0, 32_767.0,
    65_535.0, -1e30,
];
/// Largest part of a column that may be missing so.
const MOST: f64 = 0.25;

/// Reads days since 1900 as dates and sentinels as missing values, and leaves out rows that stand twice.
pub fn read_as_meant(mut table: Table) -> Table {
    leave_out_twice(&mut table);
    serial_dates(&mut table);
    for (spec, values) in &mut table.columns {
        if spec.channel != Channel::Time
            && let Some((sentinel, count)) = sentinel(values)
        {
            values
                .iter_mut()
                .filter(|v| **v == sentinel)
                .for_each(|v| *v = f64::NAN);
            table.reading.push(format!(
                "{}: {count} values of {sentinel} are read as missing",
                spec.header
            ));
        }
    }
    table
}

/// The number that stands for missing values, and how often: it is further off than all others are apart.
fn sentinel(values: &[f64]) -> Option<(f64, usize)> {
    let known = values.iter().find(|v| SENTINELS.contains(v))?;
    let others = values.iter().filter(|v| *v != known && !v.is_nan());
    let (mut least, mut most, mut count) = (f64::INFINITY, f64::NEG_INFINITY, 0);
    for value in others {
        (least, most, count) = (least.min(*value), most.max(*value), count + 1);
    }
    let sentinels = values.iter().filter(|v| *v == known).count();
    let gap = (least - known).max(known - most);
    let is_apart = most > least && gap > most - least;
    let are_few = (sentinels as f64) < MOST * (sentinels + count) as f64;
    (is_apart && are_few).then_some((*known, sentinels))
}

fn serial_dates(table: &mut Table) {
    let Some((spec, values)) = table
        .columns
        .iter_mut()
        .find(|(spec, _)| spec.channel == Channel::Time)
    else {
        return;
    };
    let ends = values.iter().fold(None, |ends, value| match ends {
        Some((first, _)) => Some((first, *value)),
        None => Some((*value, *value)),
    });
    let Some((first, last)) = ends.filter(|(first, last)| first != last) else {
        return;
    };
    // The newest row may be the first.
    let step = (last - first).abs() * spec.unit.scale / values.len() as f64;
    let lie_in = |range: std::ops::Range<f64>| range.contains(&first) && range.contains(&last);
    let zero = ZEROS.into_iter().find(|(zero, _)| {
        lie_in(EPOCHS_S.start / DAY_S + zero..EPOCHS_S.end / DAY_S + zero) && step < FASTEST_S
    });
    let is_fraction = || lie_in(FRACTIONS) && spec.unit.scale == 1.0 && step < FRACTION_STEP;
    let counted = match zero {
        _ if table.epoch_s.is_some() || spec.unit.name == Unit::time_of_day().name => return,
        Some((zero, counted)) => {
            table.epoch_s = Some((first - zero) * DAY_S);
            format!("days since {counted}")
        }
        None if is_fraction() => "fractions of a day, hence times of day".to_owned(),
        None => return,
    };
    values
        .iter_mut()
        .for_each(|v| *v = (*v - first) * DAY_S / spec.unit.scale);
    table.reading.push(format!(
        "{}: {} and so on are {counted}",
        spec.header,
        significant(first, 9)
    ));
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::formats::csv;
    use crate::options::ReadOptions;

    fn of(text: &str) -> Table {
        read_as_meant(csv::read(text.as_bytes(), &ReadOptions::default()).unwrap())
    }

    fn missing(row: &dyn Fn(i32) -> String) -> usize {
        let rows: String = (0..100).map(row).collect();
        let table = of(&format!("t,z_f\n{rows}"));
        table.columns[1].1.iter().filter(|v| v.is_nan()).count()
    }

    #[test]
    fn sentinels_far_from_all_others_are_missing() {
        let holed = |sentinel: &'static str, wide: f64| {
            missing(&move |i| match i % 20 {
                7 => format!("{i},{sentinel}\n"),
                _ => format!("{i},{}\n", wide * f64::from(i % 9)),
            })
        };
        assert_eq!(holed("-999", 0.1), 5);
        assert_eq!(holed("65535", 100.0), 5);
        // Within reach of the others, or no number that loggers use.
        assert_eq!(holed("-999", 300.0), 0);
        assert_eq!(holed("-997", 0.1), 0);
    }

    #[test]
    fn days_since_1900_are_dates() {
        let days: String = (0..100)
            .map(|i| format!("{:.10},{i}\n", 46_163.5 + f64::from(i) * 0.005 / DAY_S))
            .collect();
        let table = of(&format!("t,z_f\n{days}"));
        assert!((table.columns[0].1[99] - 0.495).abs() < 1e-5);
        // 21 May 2026, noon.
        assert_eq!(table.epoch_s, Some(1_779_364_800.0));
        let seconds: String = (0..100)
            .map(|i| format!("{},{i}\n", 46_163.5 + f64::from(i) * 0.005))
            .collect();
        assert_eq!(of(&format!("t,z_f\n{seconds}")).epoch_s, None);
    }

    #[test]
    fn days_since_the_year_0_and_times_of_day_as_fractions_are_read() {
        let of_days = |first: f64, digits: usize| {
            let day = |i: i32| first + f64::from(i) * 0.005 / DAY_S;
            let rows: String = (0..100)
                .map(|i| format!("{:.digits$},{i}\n", day(i)))
                .collect();
            let table = of(&format!("t,z_f\n{rows}"));
            (table.columns[0].1[99], table.epoch_s)
        };
        let (last, epoch_s) = of_days(740_123.5, 10);
        assert!((last - 0.495).abs() < 1e-4);
        assert_eq!(epoch_s, Some(1_779_364_800.0));
        let (last, epoch_s) = of_days(0.416_666_666_7, 10);
        assert!((last - 0.495).abs() < 1e-4);
        assert_eq!(epoch_s, None);
        // It may be anything that begins at 0.
        assert!(of_days(0.0, 10).0 < 1e-4);
    }
}
