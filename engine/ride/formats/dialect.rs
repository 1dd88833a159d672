//! How a text file is written: separator, decimal sign, header, units row.

use std::borrow::Cow;

use crate::channels::channel::{Channel, heading, with_unit};
use crate::channels::glimpse::{Glimpse, PreviewLine};
use crate::error::{Problem, ReadError};
use crate::formats::cells::{Separator, is_cell_number, split, split_wide};
use crate::formats::head::{Line, SAMPLE, sample};
use crate::formats::labels::Labels;
use crate::formats::layout::{Given, Layout, separator_of};
use crate::formats::number::{Decimal, is_number, with_unit as number_with_unit};
use crate::formats::pace::Pace;
use crate::formats::times::{Order, is_date, is_time, order};
use crate::options::ReadOptions;
use crate::table_layout::TableLayout;

/// Letters of a line that messages show.
const SHOWN: usize = 40;
/// Rows that decide whether a column holds dates.
const DATED_ROWS: usize = 20;
/// Lines that previews show.
const SHOWN_LINES: usize = 24;
/// What serial monitors put between the time of day and the line.
pub const ARROW: &str = " -> ";

#[derive(Clone, Debug, PartialEq)]
pub struct Dialect {
    pub separator: Separator,
    pub decimal: Decimal,
    /// One per column; blank without a header.
    pub names: Vec<String>,
    pub units: Vec<String>,
    pub header_line: Option<usize>,
    units_line: Option<usize>,
    /// Where the rows of numbers begin: offset in the first block, and lines before it.
    pub offset: usize,
    pub lines_before: usize,
    /// Whether a time of day and an arrow precede each line: the arrow then separates like the separator.
    pub has_arrow: bool,
    pub order: Order,
    /// What was assumed, in sentences.
    pub reading: Vec<String>,
    /// Every column, in order.
    pub glimpses: Vec<Glimpse>,
    /// The first lines.
    pub lines: Vec<PreviewLine>,
    pub time_format: Option<String>,
    /// The column of dates, where the times of day stand in another one, and that of milliseconds behind these.
    pub dates: Option<usize>,
    pub milliseconds: Option<usize>,
    /// Per column: the unit behind each number, and whether the cells are times.
    pub units_in_cells: Vec<Option<String>>,
    pub are_times: Vec<bool>,
    pub paces: Vec<Option<Pace>>,
    /// The label and the mark behind it before each number, where the rows hold the names.
    pub labels: Option<Labels>,
    /// Lines below the header, and how the first line begins, where no cell of them is a number.
    no_numbers: Option<(usize, String)>,
}

/// Looks at the beginning of a file.
pub fn sniff(head: &[u8], options: &ReadOptions) -> Result<Dialect, ReadError> {
    let (mut lines, comments) = sample(head, options.limits.line_bytes)?;
    if lines.is_empty() {
        let nothing = head.trim_ascii().is_empty();
        return Err(if nothing {
            Problem::EmptyFile
        } else {
            Problem::HeaderOnly
        }
        .into());
    }
    let has_arrow = lines
        .iter()
        .rev()
        .take(SAMPLE / 2)
        .all(|line| has_arrow(&line.text));
    let texts: Vec<&str> = lines
        .iter()
        .map(|line| behind_arrow(&line.text, has_arrow))
        .collect();
    let said = &options.layout;
    let labels = Labels::of(&texts).filter(|_| said.is_empty() && !has_arrow);
    let separator = match said.separator() {
        Some(b' ') => Separator::Blanks,
        Some(byte) => Separator::Byte(byte),
        None => match &labels {
            Some(labels) => labels.separator,
            None => separator_of(&texts),
        },
    };
    if let Some(labels) = &labels {
        for line in &mut lines {
            if let Some(plain) = labels.without(line.text.as_bytes()) {
                line.text = Cow::Owned(String::from_utf8_lossy(&plain).into_owned());
            }
        }
    }
    if has_arrow {
        for line in &mut lines {
            line.text = Cow::Owned(line.text.replacen(
                ARROW,
                separator.as_char().encode_utf8(&mut [0; 4]),
                1,
            ));
        }
    }
    let rows: Vec<Vec<String>> = lines.iter().map(|l| split(&l.text, separator)).collect();
    let above = (comments.iter()).find(|line| said.header_row == Some(line.number));
    let given = given(said, &lines, above.is_some())?;
    let layout = Layout::of(&rows, &|cell| is_known(cell, options), given);
    let numbers = &rows[layout.first.min(rows.len())..];
    let is_number = |row: &Vec<String>| row.iter().any(|cell| is_cell_number(cell));
    let shown = lines.iter().zip(&rows).take(SHOWN_LINES);
    let mut dialect = Dialect {
        separator,
        decimal: match said.decimal() {
            Some(b',') => Decimal::Comma,
            Some(_) => Decimal::Point,
            None => decimal_of(numbers),
        },
        names: Vec::new(),
        units: Vec::new(),
        header_line: None,
        units_line: None,
        offset: 0,
        lines_before: 0,
        has_arrow,
        order: Order::default(),
        reading: Vec::new(),
        glimpses: Vec::new(),
        lines: shown
            .map(|(line, row)| PreviewLine::new(line.number, row))
            .collect(),
        time_format: said.time_format.clone(),
        dates: None,
        milliseconds: None,
        units_in_cells: Vec::new(),
        are_times: Vec::new(),
        paces: Vec::new(),
        labels: None,
        no_numbers: (lines.len() > 1 && !numbers.iter().any(is_number)).then(|| {
            let first = lines[0].text.chars().take(SHOWN).collect();
            (lines.len() - 1, first)
        }),
    };
    if layout.header.is_none() {
        let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
        match above {
            Some(line) => dialect.take_names_of(line, columns),
            None => dialect.take_names_above(&comments, columns, options),
        }
    }
    dialect.take_header(&layout, &lines, &rows);
    if let Some(labels) = labels {
        dialect.names = labels.names();
        dialect.header_line = Some(lines[0].number);
        dialect.labels = Some(labels);
        (dialect.reading).push("each row holds the names of its values".to_owned());
    }
    if let Some(header) = layout.header {
        dialect.take_row_names(&rows[header], numbers);
    }
    dialect.take_dates(numbers);
    dialect.take_order(numbers);
    dialect.take_columns(numbers);
    dialect.glimpses = glimpses(&dialect.names, numbers);
    Ok(dialect)
}

/// Where the rows stand that the user names by their lines. `is_above`: the header is one of the comments.
fn given(said: &TableLayout, lines: &[Line<'_>], is_above: bool) -> Result<Given, Problem> {
    let expected = "a line of the first 200 that is neither blank nor a comment, the header above the units and these above the numbers";
    let bad = |name, number: usize| Problem::BadOption {
        name,
        value: number.to_string(),
        expected,
    };
    let index = |name, number: usize| {
        let at = lines.iter().position(|line| line.number == number);
        at.ok_or_else(|| bad(name, number))
    };
    let row = |name, number: Option<usize>| match number {
        None => Ok(None),
        Some(0) => Ok(Some(None)),
        Some(number) => index(name, number).map(|at| Some(Some(at))),
    };
    let header_row = said
        .header_row
        .map(|number| if is_above { 0 } else { number });
    let given = Given {
        header: row("layout.header_row", header_row)?,
        units: row("layout.units_row", said.units_row)?,
        first: match said.first_row {
            Some(number) => Some(index("layout.first_row", number)?),
            None => None,
        },
    };
    let rows = [given.header.flatten(), given.units.flatten(), given.first];
    let rows: Vec<usize> = rows.into_iter().flatten().collect();
    match rows.is_sorted_by(|a, b| a < b) {
        true => Ok(given),
        false => Err(bad("layout.header_row", said.header_row.unwrap_or(0))),
    }
}

fn has_arrow(line: &str) -> bool {
    line.split_once(ARROW)
        .is_some_and(|(time, _)| is_time(time.trim()))
}

fn behind_arrow(line: &str, has_arrow: bool) -> &str {
    match line.split_once(ARROW) {
        Some((_, behind)) if has_arrow => behind,
        _ => line,
    }
}

fn glimpses(names: &[String], rows: &[Vec<String>]) -> Vec<Glimpse> {
    let column = |index: usize| rows.iter().filter_map(move |row| row.get(index));
    let named = names.iter().enumerate();
    named
        .map(|(index, name)| Glimpse::of_texts(name, column(index).map(String::as_str)))
        .collect()
}

/// Whether a cell is the name of a channel, its own or the mapping's.
fn is_known(cell: &str, options: &ReadOptions) -> bool {
    let mapped = (options.map.values()).any(|c| {
        c.parse::<usize>().is_err() && (c == cell || with_unit(c).is_some_and(|c| c.0 == cell))
    });
    mapped || options.named.contains_key(heading(cell).name) || heading(cell).channel.is_some()
}

impl Dialect {
    /// Takes names and units from the rows above the numbers.
    fn take_header(&mut self, layout: &Layout, lines: &[Line<'_>], rows: &[Vec<String>]) {
        if let Some(header) = layout.header {
            self.names.clone_from(&rows[header]);
            while self.names.last().is_some_and(String::is_empty) {
                self.names.pop();
            }
            // Between columns of a fixed width names may hold single blanks.
            let width = rows.get(layout.first).map_or(0, Vec::len);
            let wide = split_wide(&lines[header].text);
            if self.separator == Separator::Blanks
                && self.names.len() != width
                && wide.len() == width
            {
                self.names = wide;
            }
            if let Some(first) = self.names.first_mut() {
                // Some loggers set a comment's sign before the names.
                *first = first.trim_start_matches([';', ' ']).to_owned();
            }
            self.header_line = Some(lines[header].number);
            if header > 0 {
                self.reading.push(format!(
                    "{header} lines of other text above the header were skipped"
                ));
            }
        }
        if let Some(units) = layout.units {
            self.units.clone_from(&rows[units]);
            self.units_line = Some(lines[units].number);
            self.reading
                .push(format!("the units stand in line {}", lines[units].number));
        }
        let below = layout.header.into_iter().chain(layout.units).max();
        let skipped = layout.first - below.map_or(layout.first, |below| below + 1);
        if skipped > 0 {
            let from = below.map_or(0, |below| lines[below + 1].number);
            self.reading.push(format!(
                "{skipped} line(s) from line {from} on, above the numbers, were skipped"
            ));
        }
        match layout.first.checked_sub(1) {
            Some(last) => (self.offset, self.lines_before) = (lines[last].end, lines[last].number),
            None => (self.offset, self.lines_before) = (lines[0].start, lines[0].number - 1),
        }
    }

    /// Takes the names of a comment.
    fn take_names_of(&mut self, line: &Line<'_>, columns: usize) {
        let text = line.text.trim_start_matches(['#', '%', ' ', '\t']);
        self.names = split(text, self.separator);
        self.names.resize(columns, String::new());
        self.header_line = Some(line.number);
    }

    /// Takes names from the last comment that holds as many as there are columns.
    fn take_names_above(&mut self, comments: &[Line<'_>], columns: usize, options: &ReadOptions) {
        self.names = vec![String::new(); columns];
        let above = comments.iter().rev().find_map(|line| {
            let text = line.text.trim_start_matches(['#', '%', ' ', '\t']);
            let known = |cell: &String| is_known(cell, options);
            [self.separator, Separator::Blanks, Separator::Byte(b',')]
                .into_iter()
                .map(|s| split(text, s))
                .find(|cells| cells.len() == columns && cells.iter().any(known))
                .map(|cells| (cells, line.number))
        });
        if let Some((names, line)) = above {
            self.names = names;
            self.header_line = Some(line);
        }
    }

    /// Finds a column of dates beside one of times of day; where blanks separate, the two may have one name.
    fn take_dates(&mut self, rows: &[Vec<String>]) {
        let rows = &rows[..rows.len().min(DATED_ROWS)];
        let widest = rows.iter().map(Vec::len).max().unwrap_or(0);
        let all = |column: usize, is: &dyn Fn(&str) -> bool| {
            !rows.is_empty()
                && rows
                    .iter()
                    .all(|row| row.get(column).is_some_and(|cell| is(cell)))
        };
        let found = (0..widest.saturating_sub(1)).find(|column| all(*column, &is_date));
        self.dates = found.filter(|date| (date + 1..widest).any(|column| all(column, &is_time)));
        if let Some(date) = self.dates
            && self.separator == Separator::Blanks
            && self.names.len() + 1 == widest
        {
            self.names.insert(date, "date".to_owned());
            if !self.units.is_empty() {
                self.units.insert(date.min(self.units.len()), String::new());
            }
        }
    }

    /// Finds out whether days or months stand first in dates.
    fn take_order(&mut self, rows: &[Vec<String>]) {
        let dates = self
            .dates
            .map(|column| rows.iter().filter_map(move |row| row.get(column)));
        let beside: Vec<String> = dates
            .into_iter()
            .flatten()
            .map(|date| format!("{date} 00:00"))
            .collect();
        let times = rows.iter().flatten().filter(|cell| cell.contains(':'));
        let (found, open) = order(beside.iter().chain(times).map(String::as_str));
        self.order = found;
        if let Some([day_first, month_first]) = open {
            self.reading.push(format!(
                "the dates may be {day_first} or {month_first}: read as the first, with the day in front; the times within the ride are the same"
            ));
        } else if found == Order::MonthFirst {
            self.reading
                .push("dates are read as month/day/year".to_owned());
        }
    }

    /// Refuses what is no table of channels.
    pub fn check(&self, options: &ReadOptions) -> Result<(), ReadError> {
        if let Some((rows, first)) = self.no_numbers.clone() {
            return Err(Problem::NoTable { first, rows }.into());
        }
        let line = self.lines.first().map_or(1, |line| line.number);
        if self.header_line.is_none() && options.map.is_empty() {
            let known = Channel::known();
            return Err(ReadError::from(Problem::NoHeader { known }).at_line(line));
        }
        if self.names.len() > options.limits.columns {
            let too_many = Problem::TooMany {
                what: "columns",
                limit: options.limits.columns,
            };
            return Err(ReadError::from(too_many).at_line(line));
        }
        Ok(())
    }

    /// How the file is laid out, as the user may say it.
    pub fn layout(&self) -> TableLayout {
        let unit_line = self.units_line.unwrap_or(0);
        TableLayout {
            header_row: Some(self.header_line.unwrap_or(0)),
            units_row: Some(unit_line),
            first_row: Some(self.lines_before + 1),
            separator: Some(self.separator.name()),
            decimal: Some(char::from(self.decimal.sign()).to_string()),
            time_format: self.time_format.clone(),
        }
    }
}

fn decimal_of(rows: &[Vec<String>]) -> Decimal {
    let (mut points, mut commas) = (0, 0);
    for cell in rows.iter().flatten() {
        let signs = [cell.contains('.'), cell.contains(',')];
        // Times of day hold points whatever the decimal sign is.
        if signs == [false, false] || cell.contains(':') {
            continue;
        }
        if is_number(cell) || number_with_unit(cell).is_some_and(|(number, _)| is_number(number)) {
            points += usize::from(signs[0]);
            commas += usize::from(signs[1]);
        }
    }
    match (points, commas) {
        (0, 0) => Decimal::Undecided,
        (p, c) if c > p => Decimal::Comma,
        _ => Decimal::Point,
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use Separator::{Blanks, Byte};

    fn of(text: &str, map: &[(&str, &str)]) -> Result<Dialect, ReadError> {
        let map = map
            .iter()
            .map(|(a, b)| ((*a).into(), (*b).into()))
            .collect();
        let options = ReadOptions {
            map,
            ..ReadOptions::default()
        };
        let dialect = sniff(text.as_bytes(), &options)?;
        dialect.check(&options)?;
        Ok(dialect)
    }

    #[test]
    fn names_that_nobody_knows_are_found_below_other_text() {
        let text = "Messung 7\nam Montag\nZeit;Strasse;Rad\n0,00;0,1;0,2\n0,01;0,1;0,3\n";
        let map = [("t", "1"), ("u_f", "2"), ("z_f", "3")];
        let dialect = of(text, &map).unwrap();
        assert_eq!(dialect.names, ["Zeit", "Strasse", "Rad"]);
        assert_eq!(
            (dialect.header_line, dialect.separator),
            (Some(3), Byte(b';'))
        );
        let words = of("Messung\nZeit;Rad\nfrüh;auf\nspät;ab\n", &map);
        assert!(matches!(
            *words.unwrap_err().problem,
            Problem::NoTable { .. }
        ));
    }

    #[test]
    fn separators_and_decimal_signs() {
        for (text, separator, decimal) in [
            ("t,z_f\n0.1,0.2\n", Byte(b','), Decimal::Point),
            ("t;z_f\n0,1;0,2\n", Byte(b';'), Decimal::Comma),
            ("t;z_f\n0.1;0.2\n", Byte(b';'), Decimal::Point),
            ("t\tz_f\n0,1\t0,2\n", Byte(b'\t'), Decimal::Comma),
            ("t z_f\n0,01 0,02\n", Blanks, Decimal::Comma),
            ("t  z_f\n 0.01   0.02\n", Blanks, Decimal::Point),
            ("t [s]  z_f [mm]\n1 2\n", Blanks, Decimal::Undecided),
            (
                "\"t\",\"z_f\"\n\"0,1\",\"0,2\"\n",
                Byte(b','),
                Decimal::Comma,
            ),
            ("t, z_f\n0.1, 0.2\n", Byte(b','), Decimal::Point),
            ("z_f\n0.5\n", Blanks, Decimal::Point),
            ("z_f\n0,5\n", Blanks, Decimal::Comma),
            ("\"V1\",\"V2\",\n0.1,0.2,\n", Byte(b','), Decimal::Point),
            ("t,z_f,u_f\n0.1,0.2,0.3\n0.2,0.", Byte(b','), Decimal::Point),
        ] {
            let d = of(text, &[("a_f", "1")]).unwrap();
            assert_eq!((d.separator, d.decimal), (separator, decimal), "{text}");
        }
        let d = of("0,01 0,02\n0,02 0,03\n", &[("z_f", "2")]).unwrap();
        assert_eq!((d.separator, d.names.len()), (Blanks, 2));
    }

    #[test]
    fn headers_units_and_comments() {
        let d = of("# made by x\n\nt,z_f\ns,mm\n0,1\n", &[]).unwrap();
        assert_eq!((d.header_line, d.lines_before, d.offset), (Some(3), 4, 24));
        assert_eq!(d.units, ["s", "mm"]);
        let d = of("# t, z_f\n0.1,2\n", &[]).unwrap();
        assert_eq!(
            (d.names.len(), d.header_line, d.lines_before),
            (2, Some(1), 1)
        );
        let d = of("% x v\r\n 0 1 2 3\r\n 0 2 3 4\r\n", &[("t", "2")]).unwrap();
        assert_eq!((d.names, d.header_line), (vec![String::new(); 4], None));
        let d = of("Logger 7\nrider,me\nt,z_f\n0,1\n", &[]).unwrap();
        assert_eq!(d.header_line, Some(3));
        let d = of("t,z_f,\u{e9}\n0,1,2\n", &[]).unwrap();
        assert_eq!(d.names[2], "\u{e9}");
        assert_eq!(
            crate::formats::head::decode(b"z \x96 \xb5m"),
            "z \u{2013} \u{b5}m"
        );
    }

    #[test]
    fn faults() {
        let kind = |text| of(text, &[]).unwrap_err().kind();
        assert_eq!(kind(""), "empty-file");
        assert_eq!(kind(" \n\r\n"), "empty-file");
        assert_eq!(kind("# nothing\n"), "header-only");
        assert_eq!(kind("1,2\n3,4\n"), "no-header");
        let wide = format!("{}\n", vec!["t"; 513].join(","));
        assert_eq!(kind(&wide), "too-many");
    }
}
