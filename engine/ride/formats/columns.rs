//! What the sampled cells of columns say beyond their numbers: units in the cells, milliseconds beside times, names of rows.

use super::dialect::Dialect;
use super::number::{is_number, with_unit};
use super::pace::{FEWEST_STEPS, pace};
use super::times::is_time;
use crate::channels::channel::{Channel, heading};
use crate::channels::guess::guess;

/// Rows that decide.
const ROWS: usize = 50;

/// Names of a column of milliseconds.
const MILLISECONDS: [&str; 7] = [
    "ms",
    "msec",
    "millis",
    "millisecond",
    "milliseconds",
    "millisekunden",
    "millisecondes",
];

/// The cells of a column that are not blank.
fn cells(rows: &[Vec<String>], column: usize) -> impl Iterator<Item = &str> + Clone {
    rows.iter()
        .filter_map(move |row| row.get(column).map(String::as_str))
        .filter(|cell| !cell.is_empty())
}

/// The unit that stands behind each number of a column.
pub fn unit_in_cells(rows: &[Vec<String>], column: usize) -> Option<String> {
    let mut cells = cells(rows, column);
    let first = with_unit(cells.next()?)?.1;
    let alike = cells.all(|cell| {
        let other = with_unit(cell).map(|(_, unit)| unit);
        other == Some(first) || other.is_none() && !is_number(cell)
    });
    alike.then(|| first.to_owned())
}

/// The column of milliseconds that belongs to the whole seconds of the one before.
pub fn milliseconds(names: &[String], rows: &[Vec<String>]) -> Option<usize> {
    let is_named = |name: &String| MILLISECONDS.contains(&name.trim().to_lowercase().as_str());
    let column = names.iter().position(is_named)?;
    let before = column.checked_sub(1)?;
    let mut numbers = cells(rows, column);
    let is_part =
        |cell: &str| cell.len() <= 3 && cell.parse::<u16>().is_ok_and(|number| number < 1000);
    let has_rows = numbers.clone().nth(1).is_some();
    let is_one = has_rows && numbers.all(is_part);
    (is_one && cells(rows, before).all(ends_in_whole_seconds)).then_some(column)
}

/// Whether a time of day has no fraction of a second.
fn ends_in_whole_seconds(cell: &str) -> bool {
    let behind = cell.rsplit(':').next().unwrap_or_default();
    is_time(cell) && behind.len() == 2 && behind.bytes().all(|b| b.is_ascii_digit())
}

/// Whether the first cells count rows for which the header has no name, as R and pandas write them.
pub fn counts_rows(rows: &[Vec<String>], names: usize) -> bool {
    let count = |row: &Vec<String>| row.first().and_then(|cell| cell.parse::<u64>().ok());
    let is_wide = |row: &Vec<String>| row.len() == names + 1;
    let counts: Option<Vec<u64>> = rows.iter().map(count).collect();
    // A separator at the end of every line is no column.
    let has_last = rows
        .iter()
        .any(|row| row.last().is_some_and(|cell| !cell.is_empty()));
    rows.len() > 2
        && rows.iter().all(is_wide)
        && has_last
        && counts.is_some_and(|counts| counts.windows(2).all(|pair| pair[1] == pair[0] + 1))
}

/// Whether all cells of a column are dates with times of day, or these alone.
pub fn are_times(rows: &[Vec<String>], column: usize) -> bool {
    rows.len() > 1 && cells(rows, column).next().is_some() && cells(rows, column).all(is_time)
}

fn is_time_named(name: &str) -> bool {
    heading(name).channel == Some(Channel::Time)
        || guess(name).is_some_and(|g| g.channel == Channel::Time.name())
}

impl Dialect {
    /// Leaves the column without a name alone in which R and pandas count rows.
    pub(super) fn take_row_names(&mut self, header: &[String], rows: &[Vec<String>]) {
        let is_short = self.names.len() == header.len();
        if !is_short || !counts_rows(&rows[..rows.len().min(ROWS)], self.names.len()) {
            return;
        }
        // Of a last column without a name, a time counts up as rows do.
        let sign = self.decimal.sign();
        let is_shifted = !self.names.first().is_some_and(|name| is_time_named(name))
            || pace(rows, 1, self.order, sign).is_some()
            || are_times(rows, 1);
        if !is_shifted && rows.len() > FEWEST_STEPS {
            return;
        }
        if self.units.len() == self.names.len() {
            self.units.insert(0, String::new());
        }
        self.names.insert(0, String::new());
        self.reading
            .push("the first column has no name, counts the rows and is not read".to_owned());
    }

    /// Takes what the sampled cells say of their columns.
    pub(super) fn take_columns(&mut self, rows: &[Vec<String>]) {
        let columns = 0..self.names.len();
        self.are_times = columns.clone().map(|at| are_times(rows, at)).collect();
        self.units_in_cells = columns.map(|at| unit_in_cells(rows, at)).collect();
        self.milliseconds = milliseconds(&self.names, rows);
        let (order, sign) = (self.order, self.decimal.sign());
        let is_candidate = |at: usize| heading(&self.names[at]).channel.is_none();
        self.paces = (0..self.names.len())
            .map(|at| {
                is_candidate(at)
                    .then(|| pace(rows, at, order, sign))
                    .flatten()
            })
            .collect();
        if self.header_line.is_some()
            && self.names.first().is_some_and(String::is_empty)
            && self.are_times.first() == Some(&true)
            && !self.names.iter().any(|name| is_time_named(name))
        {
            self.names[0] = Channel::Time.name().to_owned();
            self.reading
                .push("the first column has no name and holds times: it is read as t".to_owned());
        }
        for (index, unit) in self.units_in_cells.iter().enumerate() {
            let Some(unit) = unit else { continue };
            if heading(&self.names[index]).unit.is_none() {
                if self.units.len() <= index {
                    self.units.resize(index + 1, String::new());
                }
                if self.units[index].is_empty() {
                    self.units[index].clone_from(unit);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use crate::channels::table::Table;
    use crate::error::ReadError;
    use crate::formats::csv;
    use crate::options::ReadOptions;

    fn read(text: &str) -> Result<Table, ReadError> {
        csv::read(text.as_bytes(), &ReadOptions::default())
    }

    /// Names, units and numbers of the second row.
    fn second(text: &str) -> Vec<(&'static str, f64, f64)> {
        let table = read(text).unwrap();
        let of = |(spec, values): &(crate::channels::table::Spec, Vec<f64>)| {
            (spec.channel.name(), spec.unit.scale, values[1])
        };
        table.columns.iter().map(of).collect()
    }

    #[test]
    fn units_may_stand_in_the_cells() {
        let text =
            "t,z_f,v\n0.000 s,0.1 mm,18 km/h\n0.005 s,-0.2 mm,18.1 km/h\n0.010 s,0 mm,18 km/h\n";
        assert_eq!(
            second(text),
            [
                ("t", 1.0, 0.005),
                ("z_f", 1e-3, -0.2),
                ("v", 1.0 / 3.6, 18.1)
            ]
        );
        let text = "t;z_f\n0s;0,1\n0,005s;0,2\n0,01s;0,3\n";
        assert_eq!(second(text), [("t", 1.0, 0.005), ("z_f", 1.0, 0.2)]);
        for (text, kind) in [
            ("t,z_f [cm]\n0,0.1 mm\n1,0.2 mm\n", "units-differ"),
            ("t,z_f\n0,0.1 kg\n1,0.2 kg\n", "not-a-number"),
            ("t,z_f\n0,0.1 N\n1,0.2 N\n", "unknown-unit"),
            ("t,z_f\n0,0.1 mm\n1,0.2 cm\n", "not-a-number"),
        ] {
            assert_eq!(read(text).unwrap_err().kind(), kind, "{text}");
        }
        let rows: String = (0..300)
            .map(|i| format!("{i},{i}{}\n", if i < 250 { " mm" } else { "" }))
            .collect();
        assert_eq!(
            read(&format!("t,z_f\n{rows}")).unwrap_err().kind(),
            "other-unit"
        );
    }

    #[test]
    fn milliseconds_may_stand_beside_their_seconds() {
        let text = "Datum;Uhrzeit;ms;z_f\n21.05.2026;10:00:00;995;0,1\n21.05.2026;10:00:01;0;0,2\n21.05.2026;10:00:01;5;0,2\n";
        let table = read(text).unwrap();
        let times = &table.columns[0].1;
        assert!((times[1] - times[0] - 0.005).abs() < 1e-9, "{times:?}");
        assert_eq!(table.epoch_s, Some(1_779_357_600.0));
    }

    #[test]
    fn of_two_columns_of_one_clock_the_even_one_is_the_time() {
        let rows = |second: &dyn Fn(i64) -> String| -> String {
            let row = |i: i64| {
                format!(
                    "{},{},0.{i}\n",
                    1_779_357_600_000 + 5 * i + i * i % 4,
                    second(i)
                )
            };
            format!(
                "time,sensor_time_ns,z_f\n{}",
                (0..100).map(row).collect::<String>()
            )
        };
        let one = read(&rows(&|i| (5_000_000_000_000 + 5_000_000 * i).to_string())).unwrap();
        assert_eq!(one.columns[0].0.header, "sensor_time_ns");
        assert_eq!(one.columns[0].0.unit.scale, 1e-9);
        assert!(
            one.reading
                .iter()
                .any(|said| said.starts_with("time may be a second time column"))
        );
        let other = read(&rows(&|i| (5_000_000_000_000 + 7_000_000 * i).to_string())).unwrap();
        assert_eq!(other.columns.len(), 1);
        // Two sensors that were started one after the other.
        let row = |i: i64| format!("{},{},0.{i}\n", 5 * i, 300 + 5 * i);
        let rows: String = (0..100).map(row).collect();
        let two = read(&format!("time_a (ms),time_b (ms),z_f\n{rows}")).unwrap();
        assert_eq!(two.columns.len(), 1);
    }

    #[test]
    fn names_of_rows_are_left_out() {
        for text in [
            "\"t\" \"z_f\"\n\"1\" 0.000 0.1\n\"2\" 0.005 0.2\n\"3\" 0.010 0.3\n",
            "t\tz_f\n1\t0.000\t0.1\n2\t0.005\t0.2\n3\t0.010\t0.3\n",
            "t,z_f\n0,0.000,0.1\n1,0.005,0.2\n2,0.010,0.3\n",
        ] {
            assert_eq!(
                second(text),
                [("t", 1.0, 0.005), ("z_f", 1.0, 0.2)],
                "{text}"
            );
        }
        // Here the separator at the end is no column, or one without a name.
        for text in [
            "t,z_f\n0,0.1,\n1,0.2,\n2,0.3,\n",
            "t,z_f,\n0,0.1,5\n1,0.2,5\n2,0.3,5\n",
        ] {
            let found = read(text).map(|table| table.columns[0].1[1]);
            assert!(found.is_err() || found == Ok(1.0), "{text}");
        }
        // The last column has no name, and the time is no count of rows.
        let rows: String = (0..40).map(|i| format!("{i},{},5\n", i % 7)).collect();
        assert!(read(&format!("t,z_f\n{rows}")).is_err());
    }

    #[test]
    fn a_first_column_of_times_needs_no_name() {
        let text = ",z_f\n2026-05-21 10:00:00.000,0.1\n2026-05-21 10:00:00.005,0.2\n2026-05-21 10:00:00.010,0.2\n";
        let found = second(text);
        assert_eq!((found[0].0, found[1].2), ("t", 0.2));
    }

    #[test]
    fn names_between_columns_of_a_fixed_width_hold_blanks() {
        let text = "Time (s)   Disp front (mm)   Speed (km/h)\n  0.000   0.1   18.0\n  0.005  -0.2   18.1\n  0.010   0.1   18.0\n";
        assert_eq!(
            second(text),
            [
                ("t", 1.0, 0.005),
                ("z_f", 1e-3, -0.2),
                ("v", 1.0 / 3.6, 18.1)
            ]
        );
    }

    #[test]
    fn rows_may_hold_their_names() {
        for text in [
            "t:0.000,z_f:0.1\nt:0.005,z_f:-0.2\nt:0.010,z_f:0.3\n",
            "t:0.000\tz_f:0.1\nt:0.005\tz_f:-0.2\nt:0.010\tz_f:0.3\n",
            "t: 0.000 z_f: 0.1\nt: 0.005 z_f: -0.2\nt: 0.010 z_f: 0.3\n",
            "t=0.000,z_f=0.1\nt=0.005,z_f=-0.2\nt=0.010,z_f=0.3\n",
            "t=0.000,z_f=0.1,\nt=0.005,z_f=-0.2,\nt=0.010,z_f=0.3,\n",
            "t=0.000; z_f = 0.1\nt=0.005; z_f = -0.2\nt=0.010; z_f = 0.3\n",
        ] {
            assert_eq!(
                second(text),
                [("t", 1.0, 0.005), ("z_f", 1.0, -0.2)],
                "{text}"
            );
        }
        let text = "t=0,z_f=0.1\nt=1,z_f=-0.2\nt=2,u_f=0.3\nt=3,z_f=0\n";
        assert!(read(text).is_err());
    }
}
