//! How a text file is written: separator, decimal sign, header, units row.

use std::borrow::Cow;

use crate::channels::channel::{Channel, heading, with_unit};
use crate::channels::glimpse::Glimpse;
use crate::error::{Problem, ReadError};
use crate::formats::cells::{Separator, is_number, is_numeric, is_two_numbers, is_units, split};
use crate::options::ReadOptions;

/// Data lines looked at before deciding.
const SAMPLE: usize = 200;
const SAMPLE_BYTES: usize = 128 << 10;
/// Letters of a line that messages show.
const SHOWN: usize = 40;
/// Lines of other text that may stand above the header.
const PREAMBLE: usize = 64;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decimal {
    Point,
    Comma,
    /// Only whole numbers so far.
    Undecided,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Dialect {
    pub separator: Separator,
    pub decimal: Decimal,
    /// One per column; blank without a header.
    pub names: Vec<String>,
    pub units: Vec<String>,
    pub header_line: Option<usize>,
    /// Where the rows of numbers begin: offset in the first block, and lines before it.
    pub offset: usize,
    pub lines_before: usize,
    /// Lines of other text above the header.
    pub preamble: usize,
    /// Every column, in order.
    pub glimpses: Vec<Glimpse>,
}

struct Line<'a> {
    text: Cow<'a, str>,
    /// Counted from 1.
    number: usize,
    start: usize,
    end: usize,
}

pub fn is_comment(line: &[u8]) -> bool {
    matches!(line.trim_ascii_start(), [b'#' | b'%', ..])
}

/// Looks at the beginning of a file.
pub fn sniff(head: &[u8], options: &ReadOptions) -> Result<Dialect, ReadError> {
    let (lines, comments) = sample(head, options.limits.line_bytes)?;
    if lines.is_empty() {
        let nothing = head.trim_ascii().is_empty();
        return Err(if nothing {
            Problem::EmptyFile
        } else {
            Problem::HeaderOnly
        }
        .into());
    }
    let preamble = preamble(&lines, options);
    let lines = &lines[preamble..];
    let separator = separator_of(lines);
    let mut dialect = Dialect {
        separator,
        decimal: Decimal::Undecided,
        names: Vec::new(),
        units: Vec::new(),
        header_line: None,
        offset: lines[0].start,
        lines_before: lines[0].number - 1,
        preamble,
        glimpses: Vec::new(),
    };
    let mut rows: Vec<Vec<String>> = lines.iter().map(|l| split(&l.text, separator)).collect();
    let used = if is_numeric(&rows[0]) {
        let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
        dialect.take_names_above(&comments, columns, options);
        0
    } else {
        dialect.take_header(lines, &mut rows)
    };
    let rows = &rows[used..];
    dialect.check(lines, rows, options)?;
    dialect.decimal = decimal_of(rows);
    dialect.glimpses = glimpses(&dialect.names, rows);
    Ok(dialect)
}

fn glimpses(names: &[String], rows: &[Vec<String>]) -> Vec<Glimpse> {
    let column = |index: usize| rows.iter().filter_map(move |row| row.get(index));
    let named = names.iter().enumerate();
    named
        .map(|(index, name)| Glimpse::of_texts(name, column(index).map(String::as_str)))
        .collect()
}

/// Lines of other text above the header.
fn preamble(lines: &[Line<'_>], options: &ReadOptions) -> usize {
    let hits = |line: &Line<'_>| {
        let known = |cell: &String| is_known(cell, options);
        let count = |s: &Separator| split(&line.text, *s).iter().filter(|c| known(c)).count();
        CANDIDATES.iter().map(count).max().unwrap_or(0)
    };
    let first = &lines[0];
    if hits(first) > 0 || is_numeric(&split(&first.text, separator_of(lines))) {
        0
    } else {
        let known = lines.iter().take(PREAMBLE).position(|l| hits(l) > 1);
        known.or_else(|| above_numbers(lines)).unwrap_or(0)
    }
}

/// Whether a cell is the name of a channel, its own or the mapping's.
fn is_known(cell: &str, options: &ReadOptions) -> bool {
    let mapped = (options.map.values()).any(|c| {
        c.parse::<usize>().is_err() && (c == cell || with_unit(c).is_some_and(|c| c.0 == cell))
    });
    mapped || heading(cell).channel.is_some()
}

impl Dialect {
    /// Takes names and units from the rows above the numbers; how many these are.
    fn take_header(&mut self, lines: &[Line<'_>], rows: &mut [Vec<String>]) -> usize {
        self.names = rows[0].clone();
        while self.names.last().is_some_and(String::is_empty) {
            self.names.pop();
        }
        self.header_line = Some(lines[0].number);
        let mut used = 1;
        if rows.get(1).is_some_and(|row| is_units(row)) {
            self.units = std::mem::take(&mut rows[1]);
            used = 2;
        }
        self.offset = lines[used - 1].end;
        self.lines_before = lines[used - 1].number;
        used
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

    /// Refuses what is no table of channels. `rows`: those below the header.
    fn check(
        &self,
        lines: &[Line<'_>],
        rows: &[Vec<String>],
        options: &ReadOptions,
    ) -> Result<(), ReadError> {
        let numbers = |row: &Vec<String>| row.iter().any(|cell| is_number(cell));
        if !rows.is_empty() && !rows.iter().any(numbers) {
            let first: String = lines[0].text.chars().take(SHOWN).collect();
            let rows = rows.len();
            return Err(ReadError::from(Problem::NoTable { first, rows }));
        }
        if self.header_line.is_none() && options.map.is_empty() {
            let known = Channel::known();
            return Err(ReadError::from(Problem::NoHeader { known }).at_line(lines[0].number));
        }
        if self.names.len() > options.limits.columns {
            let too_many = Problem::TooMany {
                what: "columns",
                limit: options.limits.columns,
            };
            return Err(ReadError::from(too_many).at_line(lines[0].number));
        }
        Ok(())
    }
}

/// The first lines that are neither blank nor comments, and the comments above them.
fn sample(head: &[u8], limit: usize) -> Result<(Vec<Line<'_>>, Vec<Line<'_>>), ReadError> {
    let (mut lines, mut comments) = (Vec::new(), Vec::new());
    let (mut start, mut number) = (0, 0);
    while start < head.len() && lines.len() < SAMPLE && (start < SAMPLE_BYTES || lines.len() < 3) {
        let end = memchr::memchr(b'\n', &head[start..]).map_or(head.len(), |i| start + i + 1);
        number += 1;
        if end - start > limit + 2 && !is_comment(&head[start..end]) {
            return Err(ReadError::from(Problem::LineTooLong { limit }).at_line(number));
        }
        let bytes = head[start..end].trim_ascii_end();
        let line = Line {
            text: decode(bytes),
            number,
            start,
            end,
        };
        if is_comment(bytes) {
            if lines.is_empty() && comments.len() < PREAMBLE {
                comments.push(line);
            }
        } else if !bytes.is_empty() {
            lines.push(line);
        }
        start = end;
    }
    Ok((lines, comments))
}

/// UTF-8, or else Latin-1.
pub fn decode(bytes: &[u8]) -> Cow<'_, str> {
    match std::str::from_utf8(bytes) {
        Ok(text) => Cow::Borrowed(text),
        Err(_) => Cow::Owned(bytes.iter().map(|b| *b as char).collect()),
    }
}

const CANDIDATES: [Separator; 4] = [
    Separator::Byte(b';'),
    Separator::Byte(b'\t'),
    Separator::Byte(b','),
    Separator::Blanks,
];

/// The first separator that cuts header and rows into equally many cells.
fn separator_of(lines: &[Line<'_>]) -> Separator {
    let fits = |separator: &Separator| {
        let rows: Vec<Vec<String>> = (lines.iter().take(32))
            .map(|l| split(&l.text, *separator))
            .collect();
        let least = if *separator == Separator::Blanks {
            1
        } else {
            2
        };
        let columns = rows.get(1).unwrap_or(&rows[0]).len();
        let unlike = rows[1..].iter().filter(|r| r.len() != columns).count();
        columns >= least
            && rows[0].len() >= least
            && rows[0].len().abs_diff(columns) <= 1
            && unlike <= rows.len() / 3
            && !rows.iter().any(|r| r.iter().any(|c| is_two_numbers(c)))
    };
    let contained = |separator: &Separator| match separator {
        Separator::Byte(b) => lines[0].text.as_bytes().contains(b),
        Separator::Blanks => true,
    };
    let mut by_cells = CANDIDATES.into_iter().filter(|s| fits(s));
    let mut by_header = CANDIDATES.into_iter().filter(|s| contained(s));
    by_cells
        .next()
        .or_else(|| by_header.next())
        .unwrap_or(Separator::Blanks)
}

/// The line above the first from which on all hold as many numbers, two or more: a header whose names nobody knows.
fn above_numbers(lines: &[Line<'_>]) -> Option<usize> {
    let is_row = |line: &Line<'_>, separator: Separator, columns: usize| {
        let cells = split(&line.text, separator);
        cells.len() == columns && is_numeric(&cells) && cells.iter().any(|c| !c.is_empty())
    };
    CANDIDATES.iter().find_map(|separator| {
        let columns = split(&lines.last()?.text, *separator).len();
        let rows = lines.iter().rev();
        let rows = rows.take_while(|l| is_row(l, *separator, columns)).count();
        let first = lines.len() - rows;
        let fits = columns > 1 && rows > 1 && first > 0;
        (fits && split(&lines[first - 1].text, *separator).len() == columns).then(|| first - 1)
    })
}

fn decimal_of(rows: &[Vec<String>]) -> Decimal {
    // Times of day hold points whatever the decimal sign is.
    let numbers = || (rows.iter().flatten()).filter(|c| is_number(c) && !c.contains(':'));
    let points = numbers().filter(|c| c.contains('.')).count();
    let commas = numbers().filter(|c| c.contains(',')).count();
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
        sniff(
            text.as_bytes(),
            &ReadOptions {
                map,
                ..ReadOptions::default()
            },
        )
    }

    #[test]
    fn names_that_nobody_knows_are_found_below_other_text() {
        let text = "Messung 7\nam Montag\nZeit;Strasse;Rad\n0,00;0,1;0,2\n0,01;0,1;0,3\n";
        let map = [("t", "1"), ("u_f", "2"), ("z_f", "3")];
        let dialect = of(text, &map).unwrap();
        assert_eq!(dialect.names, ["Zeit", "Strasse", "Rad"]);
        assert_eq!((dialect.preamble, dialect.separator), (2, Byte(b';')));
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
        assert_eq!((d.header_line, d.preamble), (Some(3), 2));
        let d = of("t,z_f,\u{e9}\n0,1,2\n", &[]).unwrap();
        assert_eq!(d.names[2], "\u{e9}");
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
