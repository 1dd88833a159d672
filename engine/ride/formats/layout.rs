//! Where a table begins in a text: its header, a row of units below it, and the first row of numbers.

use super::cells::{Separator, is_cell_number, is_two_numbers, is_units, split};

/// Rows above the numbers in which the header is looked for.
const ABOVE: usize = 64;
/// Rows that decide on the separator.
const DECIDE: usize = 48;

/// Rows of the table, counted in the sample.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Layout {
    pub header: Option<usize>,
    pub units: Option<usize>,
    /// First row of numbers; past the end where there is none.
    pub first: usize,
}

/// What the user says of the rows; a header or units that are `Some(None)` are none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Given {
    pub header: Option<Option<usize>>,
    pub units: Option<Option<usize>>,
    pub first: Option<usize>,
}

impl Given {
    /// The first row of numbers where it is given, or below the header that is.
    fn first(&self, rows: &[Vec<String>]) -> Option<usize> {
        let below = |header: usize| {
            let first = (header + 1..rows.len()).find(|at| is_data(&rows[*at]));
            first.unwrap_or(header + 1)
        };
        self.first.or_else(|| self.header.flatten().map(below))
    }
}

/// Whether at least half of the cells that are not blank are numbers or times.
pub fn is_data(row: &[String]) -> bool {
    let there = row.iter().filter(|cell| !cell.is_empty());
    let numbers = row.iter().filter(|cell| is_cell_number(cell)).count();
    numbers > 0 && 2 * numbers >= there.count()
}

const CANDIDATES: [Separator; 5] = [
    Separator::Byte(b';'),
    Separator::Byte(b'\t'),
    Separator::Byte(b'|'),
    Separator::Byte(b','),
    Separator::Blanks,
];

/// The separator that makes a header above rows of numbers, alike in width, and most numbers; of none, one that the first line contains.
pub fn separator_of(lines: &[&str]) -> Separator {
    let last = &lines[lines.len().saturating_sub(DECIDE)..];
    let contained = |separator: &Separator, lines: &[&str]| match separator {
        Separator::Byte(byte) => lines.iter().any(|line| line.as_bytes().contains(byte)),
        Separator::Blanks => true,
    };
    let found = CANDIDATES.into_iter().filter(|one| contained(one, last));
    let found = found.filter_map(|separator| Some((separator, numbers(last, separator)?)));
    let found: Vec<(Separator, (usize, usize))> = found.collect();
    let best = match found[..] {
        [(only, _)] => Some(only),
        // Of equal ones the first.
        _ => (found.into_iter().rev())
            .max_by_key(|(separator, (width, numbers))| {
                (has_header(lines, *separator, *width), *numbers)
            })
            .map(|(separator, _)| separator),
    };
    best.unwrap_or_else(|| {
        let first = &lines[..lines.len().min(1)];
        let mut there = CANDIDATES.into_iter().filter(|one| contained(one, first));
        there.next().unwrap_or(Separator::Blanks)
    })
}

/// How wide the rows of numbers are that a separator makes of some lines, and how many numbers they hold.
fn numbers(lines: &[&str], separator: Separator) -> Option<(usize, usize)> {
    let rows: Vec<Vec<String>> = lines.iter().map(|line| split(line, separator)).collect();
    let is_two = |cell: &String| is_two_numbers(cell, separator);
    if rows.iter().flatten().any(is_two) {
        return None;
    }
    let data = are_data(&rows);
    let width = width(&rows, &data).filter(|width| *width >= least(separator))?;
    let alike = rows
        .iter()
        .zip(&data)
        .filter(|(row, is_data)| **is_data && row.len() == width);
    let numbers = alike
        .flat_map(|(row, _)| row)
        .filter(|cell| is_cell_number(cell))
        .count();
    Some((width, numbers))
}

/// Fewest columns.
fn least(separator: Separator) -> usize {
    if separator == Separator::Blanks { 1 } else { 2 }
}

/// Whether the row above the first row of numbers is as wide.
fn has_header(lines: &[&str], separator: Separator, width: usize) -> bool {
    let rows: Vec<Vec<String>> = lines.iter().map(|line| split(line, separator)).collect();
    let above = first_row(&rows, &are_data(&rows), width).checked_sub(1);
    let above = above.and_then(|above| rows.get(above));
    above.is_none_or(|row| row.len().abs_diff(width) <= 1 && row.len() >= least(separator))
}

fn are_data(rows: &[Vec<String>]) -> Vec<bool> {
    rows.iter().map(|row| is_data(row)).collect()
}

/// Where the longest run of rows of numbers begins; past the end where there is none. A damaged row does not end it.
fn first_row(rows: &[Vec<String>], data: &[bool], width: usize) -> usize {
    let is_row = |at: usize| data[at] && rows[at].len().abs_diff(width) <= 1;
    let at: Vec<usize> = (0..rows.len()).filter(|at| is_row(*at)).collect();
    let runs = at.chunk_by(|a, b| a + 1 == *b);
    let Some(longest) = runs.rev().max_by_key(|run| run.len()) else {
        return rows.len();
    };
    let mut first = longest[0];
    let may_be_header = |row: &[String]| {
        row.len().abs_diff(width) <= 1 && !row.iter().any(|cell| is_cell_number(cell))
    };
    while first > 1 && is_row(first - 2) && !may_be_header(&rows[first - 1]) {
        first -= 2;
        while first > 0 && is_row(first - 1) {
            first -= 1;
        }
    }
    first
}

/// Cells of most rows of numbers.
fn width(rows: &[Vec<String>], data: &[bool]) -> Option<usize> {
    let rows = rows.iter().zip(data).filter(|(_, is_data)| **is_data);
    let widths: Vec<usize> = rows.map(|(row, _)| row.len()).collect();
    let count = |width: usize| widths.iter().filter(|other| **other == width).count();
    widths.iter().copied().max_by_key(|width| count(*width))
}

impl Layout {
    /// Of rows of cells; `is_known` says whether a cell names a channel.
    pub fn of(rows: &[Vec<String>], is_known: &dyn Fn(&str) -> bool, given: Given) -> Self {
        let known = |row: &[String]| row.iter().filter(|cell| is_known(cell)).count();
        let data = are_data(rows);
        let Some(width) = width(rows, &data) else {
            return Self::without_numbers(rows, &known, given);
        };
        let found = given.first(rows);
        let mut first = found.unwrap_or_else(|| first_row(rows, &data, width));
        let header = given
            .header
            .unwrap_or_else(|| Self::header(&rows[..first], width, &known));
        let units_below = |header: usize| (header + 1..first).find(|at| is_units(&rows[*at]));
        let units = given.units.unwrap_or_else(|| header.and_then(units_below));
        let is_next = |units: usize| units + 1 == first;
        if found.is_none()
            && units.is_some_and(is_next)
            && rows.get(first).is_some_and(|row| counts_columns(row))
        {
            first += 1;
        }
        // Units that the user names stand above the numbers.
        let first = first.max(units.map_or(0, |units| units + 1));
        Self {
            header,
            units,
            first,
        }
    }

    /// Where no row holds numbers.
    fn without_numbers(
        rows: &[Vec<String>],
        known: &dyn Fn(&[String]) -> usize,
        given: Given,
    ) -> Self {
        let named = || rows.iter().position(|row| known(row) > 1).unwrap_or(0);
        let header = given.header.unwrap_or_else(|| Some(named()));
        let below = header.map_or(0, |header| header + 1);
        let is_below = || {
            rows.get(below)
                .is_some_and(|row| is_units(row))
                .then_some(below)
        };
        let units = given.units.unwrap_or_else(is_below);
        let first = units.map_or(below, |units| units + 1);
        Self {
            header,
            units,
            first: given.first.unwrap_or(first),
        }
    }

    /// The row of names: the one with most names that are known, or else the row above the units or the numbers.
    fn header(
        above: &[Vec<String>],
        width: usize,
        known: &dyn Fn(&[String]) -> usize,
    ) -> Option<usize> {
        let from = above.len().saturating_sub(ABOVE);
        let last = above.len().checked_sub(1)?;
        // At most a row of sources stands between the units and the numbers.
        let units = (last.saturating_sub(1)..above.len())
            .rev()
            .find(|at| is_units(&above[*at]) && above[*at].len() + 1 >= width);
        let nearest = units.and_then(|at| at.checked_sub(1)).unwrap_or(last);
        let named = (from..above.len()).map(|at| (known(&above[at]), at));
        let best = named
            .filter(|(known, _)| *known > 0)
            .max_by_key(|(known, at)| (*known, *at));
        match best {
            Some((known, at)) if known > 1 || at == nearest => Some(at),
            _ => Some(nearest),
        }
    }
}

/// `1, 2, 3`: a row that counts the columns.
fn counts_columns(row: &[String]) -> bool {
    let counts = (1..)
        .zip(row)
        .all(|(number, cell)| cell.parse() == Ok(number));
    row.len() > 1 && counts
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str, separator: Separator) -> Layout {
        let rows: Vec<Vec<String>> = text.lines().map(|line| split(line, separator)).collect();
        Layout::of(
            &rows,
            &|cell| ["t", "z_f"].contains(&cell),
            Given::default(),
        )
    }

    fn layout(header: usize, units: Option<usize>, first: usize) -> Layout {
        Layout {
            header: Some(header),
            units,
            first,
        }
    }

    const COMMA: Separator = Separator::Byte(b',');

    #[test]
    fn headers_are_found_by_what_stands_below_them() {
        assert_eq!(of("t,z_f\n0,1\n1,2\n", COMMA), layout(0, None, 1));
        assert_eq!(
            of("Logger 7\nat,noon\nt,z_f\n0,1\n1,2\n", COMMA),
            layout(2, None, 3)
        );
        assert_eq!(
            of("Name,Travel\ns,mm\n0,1\n1,2\n", COMMA),
            layout(0, Some(1), 2)
        );
        let aim = "Rate,200\nTime,Front,Rear\ns,mm,mm\n1,2,3\n0,0.1,0.2\n0.1,0.3,0.4\n";
        assert_eq!(of(aim, COMMA), layout(1, Some(2), 4));
        let sources = "time,speed,u\nunix time,m/s,m\n,100: gps,calc\n1,2,3\n2,2,4\n";
        assert_eq!(of(sources, COMMA), layout(0, Some(1), 3));
        let nodes = "Unit,g\nStart,10:00:00\n\nTime,41:ch3\n0,1\n1,2\n2,3\n";
        assert_eq!(of(nodes, COMMA), layout(3, None, 4));
        assert_eq!(
            of("0,1\n1,2\n", COMMA),
            Layout {
                header: None,
                units: None,
                first: 0
            }
        );
    }

    #[test]
    fn separators_make_rows_of_numbers() {
        for (lines, separator) in [
            (["a;b", "0,1;0,2"], Separator::Byte(b';')),
            (["a\tb", "0,1\t0,2"], Separator::Byte(b'\t')),
            (["a,b", "0.1,0.2"], COMMA),
            (["a b", "0,1 0,2"], Separator::Blanks),
            (["a", "0,5"], Separator::Blanks),
            (["a|b", "0,1|0,2"], Separator::Byte(b'|')),
        ] {
            assert_eq!(separator_of(&lines), separator, "{lines:?}");
        }
    }
}
