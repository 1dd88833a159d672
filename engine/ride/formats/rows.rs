//! The rows of numbers of a text file, in one pass.

use crate::channels::channel::Channel;
use crate::channels::table::{LARGEST, Places, Spec, Table};
use crate::channels::unit::Unit;
use crate::error::{Problem, ReadError};
use crate::formats::cells::Separator;
use crate::formats::damage::{Damage, Missing};
use crate::formats::dialect::{ARROW, Dialect};
use crate::formats::grouped::{Found, Grouping};
use crate::formats::head::is_comment;
use crate::formats::labels::Labels;
use crate::formats::moment::Moment;
use crate::formats::number::{Decimal, LONGEST, Number, Signs, number};
use crate::formats::times::Times;
use crate::options::{Limits, ReadOptions};

const SKIP: usize = usize::MAX;

/// Reads lines into columns.
pub struct Rows<'a> {
    separator: Separator,
    decimal: Decimal,
    /// Per column of the file: which output column it fills.
    slots: Vec<usize>,
    names: &'a [String],
    /// The output column of the time; a row may then be left out when all its cells are blank.
    time: Option<usize>,
    times: Times,
    dates: Option<usize>,
    milliseconds: Option<usize>,
    /// Per output column: the unit behind each number.
    units: Vec<Option<&'a str>>,
    labels: Option<&'a Labels>,
    /// The first time stamp and the last, where they are times of day: what all of them are counted from.
    first: Option<Moment>,
    last: Option<Moment>,
    has_arrow: bool,
    groupings: Vec<Grouping>,
    missing: Missing,
    damage: Damage,
    /// Whether a cell that begins with a number is one.
    plain: bool,
    options: &'a ReadOptions,
    columns: Vec<Vec<f64>>,
    cells: Vec<f64>,
    /// Data rows seen, rows wanted of them, and most rows to keep.
    seen: usize,
    wanted: (usize, usize),
    pub most: usize,
    pub beyond: Problem,
    kept: usize,
    line: usize,
    places: Places,
    limits: Limits,
    /// The fault of the last line, and the data rows before it: the logger may have died while writing.
    pending: Option<(ReadError, usize)>,
}

impl<'a> Rows<'a> {
    pub fn new(dialect: &'a Dialect, specs: &[Spec], options: &'a ReadOptions) -> Self {
        let mut slots = vec![SKIP; dialect.names.len()];
        for (slot, spec) in specs.iter().enumerate() {
            slots[spec.number - 1] = slot;
        }
        let time = specs.iter().position(|s| s.channel == Channel::Time);
        let in_cells = |spec: &Spec| dialect.units_in_cells.get(spec.number - 1)?.as_deref();
        let units: Vec<Option<&str>> = specs.iter().map(in_cells).collect();
        let belongs = |at: &usize| {
            slots[*at] == SKIP && *at > 0 && time.is_some_and(|time| slots[at - 1] == time)
        };
        Self {
            separator: dialect.separator,
            decimal: dialect.decimal,
            milliseconds: dialect.milliseconds.filter(belongs),
            labels: dialect.labels.as_ref(),
            slots,
            names: &dialect.names,
            time,
            times: Times::new(dialect.order, dialect.time_format.clone()),
            dates: dialect.dates,
            first: None,
            last: None,
            has_arrow: dialect.has_arrow,
            groupings: vec![Grouping::default(); specs.len()],
            missing: Missing::default(),
            damage: Damage::default(),
            plain: options.missing.is_empty()
                && dialect.time_format.is_none()
                && units.iter().all(Option::is_none),
            units,
            options,
            columns: vec![Vec::new(); specs.len()],
            cells: vec![f64::NAN; specs.len()],
            seen: 0,
            wanted: options.rows.unwrap_or((0, usize::MAX)),
            most: options.limits.rows,
            beyond: Problem::TooMany {
                what: "rows",
                limit: options.limits.rows,
            },
            kept: 0,
            line: dialect.lines_before,
            places: Default::default(),
            limits: options.limits,
            pending: None,
        }
    }

    /// Makes room for as many rows as `bytes` like the first ones of `text` would hold.
    pub fn reserve(&mut self, bytes: usize, text: &[u8]) {
        let sample = &text[..text.len().min(16 << 10)];
        let lines = memchr::memchr_iter(b'\n', sample).count().max(1);
        let rows = (bytes as f64 * lines as f64 / sample.len().max(1) as f64 * 1.02) as usize + 16;
        for column in &mut self.columns {
            column.reserve(rows.min(self.most));
        }
    }

    /// Takes whole lines; false once no more are wanted.
    pub fn feed(&mut self, block: &[u8]) -> Result<bool, ReadError> {
        let mut rest = block;
        while !rest.is_empty() {
            let end = memchr::memchr(b'\n', rest);
            let line = &rest[..end.unwrap_or(rest.len())];
            rest = end.map_or(&[][..], |i| &rest[i + 1..]);
            self.line += 1;
            let line = line.strip_suffix(b"\r").unwrap_or(line);
            let blank = |b: &u8| matches!(b, b' ' | b'\t' | b'\r' | 0x1a);
            match line.first() {
                None => continue,
                Some(b'#' | b'%' | b' ' | b'\t' | b'\r' | 0x1a)
                    if is_comment(line) || line.iter().all(blank) =>
                {
                    continue;
                }
                _ => {}
            }
            if let Some((fault, rows)) = self.pending.take() {
                self.damage.add(fault, rows);
            }
            if self.labels.is_none() && self.is_header(line) {
                self.damage.add_header(self.line);
                continue;
            }
            let row = self.seen;
            self.seen += 1;
            if row < self.wanted.0 {
                continue;
            }
            if row >= self.wanted.1 {
                self.seen = self.wanted.1;
                return Ok(false);
            }
            let read = self.arrowless_row(line).and_then(|()| self.has_time());
            let read = match end.is_none() && self.is_cut_short(block) {
                true => read.and(Err(Problem::CutShort.into())),
                false => read,
            };
            match read {
                Ok(()) => self.keep()?,
                Err(fault) => {
                    self.pending = Some((fault.at_line(self.line), row));
                    self.groupings.iter_mut().for_each(|g| g.forget(self.kept));
                }
            }
        }
        Ok(true)
    }

    /// Whether the file's last line, without a line end, breaks off within its last number: that
    /// is shorter than in each of the lines before.
    fn is_cut_short(&self, block: &[u8]) -> bool {
        let separates = |b: &u8| match self.separator {
            Separator::Byte(separator) => *b == separator,
            Separator::Blanks => b.is_ascii_whitespace(),
        };
        let length = |line: &[u8]| {
            let line = line.trim_ascii_end();
            line.rsplit(separates).next().map_or(0, <[u8]>::len)
        };
        let tail = &block[block.len().saturating_sub(8 << 10)..];
        let mut lines = tail.rsplit(|b| *b == b'\n');
        let last = lines.next().map_or(0, length);
        let before: Vec<usize> = lines.take(50).map(length).collect();
        before.len() > 10 && before.iter().all(|n| last < *n)
    }

    fn keep(&mut self) -> Result<(), ReadError> {
        if self.time.is_some() && self.cells.iter().all(|v| v.is_nan()) {
            return Ok(());
        }
        if self.kept >= self.most {
            return Err(ReadError::from(self.beyond.clone()).at_line(self.line));
        }
        for (column, value) in self.columns.iter_mut().zip(&self.cells) {
            column.push(*value);
        }
        self.places.push(self.kept, self.line);
        self.kept += 1;
        Ok(())
    }

    /// Whether the header stands in the line once more.
    fn is_header(&self, line: &[u8]) -> bool {
        let name = self.names.first().map_or(&[][..], |name| name.as_bytes());
        let line = line.strip_prefix(b"\"").unwrap_or(line);
        let begins = !name.is_empty() && line.starts_with(name) && !name[0].is_ascii_digit();
        begins
            && line[name.len()..]
                .iter()
                .find(|b| **b != b'"')
                .is_none_or(|next| !next.is_ascii_alphanumeric())
    }

    fn has_time(&self) -> Result<(), ReadError> {
        let blank = self.time.filter(|time| self.cells[*time].is_nan());
        let index = blank.and_then(|time| self.slots.iter().position(|slot| *slot == time));
        match index {
            Some(index) if self.cells.iter().any(|v| !v.is_nan()) => {
                Err(self.blame(index, Problem::TimeBlank))
            }
            _ => Ok(()),
        }
    }

    /// Fills `cells` from a line before whose first cell an arrow may stand.
    fn arrowless_row(&mut self, line: &[u8]) -> Result<(), ReadError> {
        let arrow = self
            .has_arrow
            .then(|| memchr::memmem::find(line, ARROW.as_bytes()))
            .flatten();
        let Some(at) = arrow else {
            return self.row(line);
        };
        let behind = &line[at + ARROW.len()..];
        self.row(&[&line[..at], &[self.separator.as_char() as u8], behind].concat())
    }

    /// Fills `cells` from one line.
    fn row(&mut self, line: &[u8]) -> Result<(), ReadError> {
        if line.len() > self.limits.line_bytes {
            let limit = self.limits.line_bytes;
            return Err(Problem::LineTooLong { limit }.into());
        }
        let plain = match self.labels {
            Some(labels) => labels.without(line).ok_or_else(|| Problem::NotANumber {
                cell: String::from_utf8_lossy(&line[..line.len().min(LONGEST)]).into_owned(),
                decimal: "point behind each of its names",
            })?,
            None => Vec::new(),
        };
        let line = if self.labels.is_some() { &plain } else { line };
        match self.separator {
            Separator::Byte(separator) => self.separated_row(line, separator),
            Separator::Blanks => self.blanks_row(line),
        }
    }

    fn separated_row(&mut self, line: &[u8], separator: u8) -> Result<(), ReadError> {
        let mut rest = line;
        for index in 0..self.slots.len() {
            let slot = self.slots[index];
            if slot != SKIP
                && self.plain
                && self.decimal != Decimal::Comma
                && let Ok((value, n)) = fast_float2::parse_partial::<f64, _>(rest)
                && n <= LONGEST
                && value.abs() <= LARGEST
                && rest.get(n).is_none_or(|b| *b == separator)
            {
                self.cells[slot] = value;
                if !self.groupings[slot].is_decided() {
                    let signs = Signs::Decimal;
                    let found = number(&rest[..n], b'.').unwrap_or(Number { value, signs });
                    self.groupings[slot].see(found, self.kept);
                }
                rest = &rest[n..];
            } else {
                let (cell, n) = cell(rest, separator);
                if self.dates == Some(index) {
                    self.times.take_date(cell);
                } else if self.milliseconds == Some(index) {
                    self.add_milliseconds(cell)
                        .map_err(|p| self.blame(index, p))?;
                } else if slot != SKIP {
                    self.cells[slot] = self.value(cell, slot).map_err(|p| self.blame(index, p))?;
                }
                rest = &rest[n..];
            }
            match rest {
                [_, after @ ..] => rest = after,
                [] if self.slots[index + 1..].iter().any(|slot| *slot != SKIP) => {
                    return Err(self.ragged(index + 1));
                }
                [] => return Ok(()),
            }
        }
        // A trailing separator, or several of them.
        let over = rest.iter().filter(|b| **b == separator).count();
        if rest
            .iter()
            .all(|b| *b == separator || b.is_ascii_whitespace())
        {
            return Ok(());
        }
        Err(self.ragged(self.slots.len() + over + 1))
    }

    fn blanks_row(&mut self, line: &[u8]) -> Result<(), ReadError> {
        let mut found = 0;
        for cell in line
            .split(u8::is_ascii_whitespace)
            .filter(|c| !c.is_empty())
        {
            let slot = self.slots.get(found).copied().unwrap_or(SKIP);
            if self.dates == Some(found) {
                self.times.take_date(cell);
            } else if self.milliseconds == Some(found) {
                self.add_milliseconds(cell)
                    .map_err(|p| self.blame(found, p))?;
            } else if slot != SKIP {
                let cell = cell.strip_prefix(b"\"").unwrap_or(cell);
                let cell = cell.strip_suffix(b"\"").unwrap_or(cell);
                self.cells[slot] = self.value(cell, slot).map_err(|p| self.blame(found, p))?;
            }
            found += 1;
        }
        if found == self.slots.len() {
            Ok(())
        } else {
            Err(self.ragged(found))
        }
    }

    fn ragged(&self, found: usize) -> ReadError {
        let expected = self.slots.len();
        Problem::RaggedRow { found, expected }.into()
    }

    fn blame(&self, index: usize, problem: Problem) -> ReadError {
        ReadError::from(problem).in_column(index + 1, &self.names[index])
    }

    /// What a cell of an output column holds.
    fn value(&mut self, cell: &[u8], slot: usize) -> Result<f64, Problem> {
        let cell = match self.units[slot] {
            Some(unit) => self.without_unit(cell, unit)?,
            None => cell,
        };
        if self.time != Some(slot) {
            return self.number(cell, slot);
        }
        match (self.times.read(cell.trim_ascii()), self.first) {
            (None, None) => self.number(cell, slot),
            (Some(moment), Some(first)) if moment.is_dated == first.is_dated => {
                let moment = moment.after(self.last.unwrap_or(first));
                self.last = Some(moment);
                Ok(moment.since(first))
            }
            (Some(moment), None) if self.kept == 0 => {
                self.first = Some(moment);
                self.plain = false;
                Ok(0.0)
            }
            _ => Err(Problem::OtherTime {
                cell: String::from_utf8_lossy(cell).into_owned(),
            }),
        }
    }

    /// A cell without its unit; one that is no number stays.
    fn without_unit<'c>(&self, cell: &'c [u8], unit: &str) -> Result<&'c [u8], Problem> {
        let cell = cell.trim_ascii();
        match cell.strip_suffix(unit.as_bytes()) {
            Some(number) => Ok(number.trim_ascii_end()),
            None if number(cell, self.decimal.sign()).is_some() => Err(Problem::OtherUnit {
                cell: String::from_utf8_lossy(cell).into_owned(),
                unit: unit.to_owned(),
            }),
            None => Ok(cell),
        }
    }

    /// Adds the milliseconds in a column of their own to the time before.
    fn add_milliseconds(&mut self, cell: &[u8]) -> Result<(), Problem> {
        let text = String::from_utf8_lossy(cell);
        let part = text.trim().parse::<u16>().ok().filter(|part| *part < 1000);
        let (Some(part), Some(time)) = (part, self.time) else {
            return Err(Problem::OtherTime {
                cell: text.into_owned(),
            });
        };
        self.cells[time] += 1e-3 * f64::from(part);
        Ok(())
    }

    /// The number in a cell, NaN where it is blank or a word for a missing value.
    fn number(&mut self, cell: &[u8], slot: usize) -> Result<f64, Problem> {
        let cell = cell.trim_ascii();
        if cell.is_empty() || self.options.is_missing(cell) {
            return Ok(f64::NAN);
        }
        if cell.len() > LONGEST {
            return Err(Problem::CellTooLong {
                bytes: cell.len(),
                limit: LONGEST,
            });
        }
        let has = |sign: u8| memchr::memchr(sign, cell).is_some();
        if self.decimal == Decimal::Undecided && has(b',') && !has(b'.') {
            self.decimal = Decimal::Comma;
        }
        // Where commas separate, the comma between two numbers may be lost.
        let is_two = self.separator == Separator::Byte(b',') && has(b' ') && !is_apart(cell);
        let found = number(cell, self.decimal.sign()).filter(|_| !is_two);
        let is_finite = found.is_some_and(|found| found.value.is_finite());
        if !is_finite && self.missing.is_one(cell) {
            return Ok(f64::NAN);
        }
        let found = found.ok_or_else(|| self.not_a_number(cell))?;
        self.groupings[slot].see(found, self.kept);
        match found.value {
            v if !v.is_finite() => Err(Problem::NotFinite {
                cell: String::from_utf8_lossy(cell).into_owned(),
            }),
            v if v.abs() > LARGEST => Err(Problem::OutOfRange {
                value: v,
                limit: LARGEST,
            }),
            v => Ok(v),
        }
    }

    fn not_a_number(&self, cell: &[u8]) -> Problem {
        Problem::NotANumber {
            cell: String::from_utf8_lossy(cell).into_owned(),
            decimal: match self.decimal {
                Decimal::Comma => "comma",
                _ => "point",
            },
        }
    }

    pub fn finish(mut self, specs: Vec<Spec>, table: &mut Table) -> Result<(), ReadError> {
        match self.pending.take() {
            // Then it is not the last line alone.
            Some((fault, rows)) if self.kept == 0 => self.damage.add(fault, rows),
            Some((fault, _)) => {
                self.seen -= 1;
                table.warnings.push(format!(
                    "line {}, the last, is incomplete and was left out ({})",
                    fault.line().unwrap_or(self.line),
                    fault.problem
                ));
            }
            None => {}
        }
        std::mem::take(&mut self.damage).finish(self.seen, &mut table.reading)?;
        std::mem::take(&mut self.missing).finish(&mut table.reading);
        if self.seen == 0 {
            return Err(Problem::HeaderOnly.into());
        }
        let (from, to) = self.wanted;
        if from >= self.seen {
            return Err(Problem::BadRows {
                from,
                to,
                rows: self.seen,
            }
            .into());
        }
        if to != usize::MAX && to > self.seen {
            table.warnings.push(format!(
                "rows {from}:{to} were requested, but the file ends after {}",
                self.seen
            ));
        }
        if let Some(at) = self.milliseconds {
            let [time, part] = [&self.names[at - 1], &self.names[at]];
            table.reading.push(format!(
                "the times are those of {time} and the milliseconds of {part}"
            ));
        }
        self.join_groups(&specs, &mut table.reading)?;
        table.rows = self.kept;
        table.places = self.places;
        table.columns = specs.into_iter().zip(self.columns).collect();
        if let (Some(first), Some(time)) = (self.first, self.time) {
            table.epoch_s = first.is_dated.then(|| first.epoch_s());
            table.columns[time].0.unit = Unit::time_of_day();
        }
        Ok(())
    }

    /// Makes whole numbers of those whose signs stand between thousands.
    fn join_groups(&mut self, specs: &[Spec], reading: &mut Vec<String>) -> Result<(), ReadError> {
        let found: Vec<Found> = self.groupings.iter().map(Grouping::found).collect();
        // What one column leaves open the others say.
        let elsewhere = found.contains(&Found::Groups) && !found.contains(&Found::Decimal);
        for (slot, spec) in specs.iter().enumerate() {
            match found[slot] {
                Found::Both => return Err(spec.blame(Problem::MixedSigns)),
                Found::Groups => {}
                Found::Open if elsewhere && self.groupings[slot].is_open() => {}
                _ => continue,
            }
            self.groupings[slot].join(&mut self.columns[slot]);
            reading.push(format!(
                "{}: the signs between digits are read as those of thousands",
                spec.header
            ));
        }
        Ok(())
    }
}

/// Whether blanks stand only behind the sign, as in `-   0.0397`.
fn is_apart(cell: &[u8]) -> bool {
    matches!(cell, [b'+' | b'-', rest @ ..] if !rest.trim_ascii_start().contains(&b' '))
}

/// The first cell of `rest` without quotes, and how many bytes it takes up.
fn cell(rest: &[u8], separator: u8) -> (&[u8], usize) {
    let mut blanks = rest.iter().take_while(|b| **b == b' ').count();
    if rest[blanks..].starts_with(b"=\"") {
        blanks += 1;
    }
    if rest.get(blanks) == Some(&b'"') {
        let inside = &rest[blanks + 1..];
        if let Some(close) = memchr::memchr(b'"', inside) {
            let after = blanks + close + 2;
            let n = memchr::memchr(separator, &rest[after..]).map_or(rest.len(), |i| after + i);
            return (&inside[..close], n);
        }
    }
    let n = memchr::memchr(separator, rest).unwrap_or(rest.len());
    (&rest[..n], n)
}
