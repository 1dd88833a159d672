//! Rows of numbers in a text file, in one pass.

use crate::channels::table::{LARGEST, Spec, Table};
use crate::channels::unit::Unit;
use crate::error::{Problem, ReadError};
use crate::formats::cells::Separator;
use crate::formats::dialect::{Decimal, Dialect, is_comment, sniff};
use crate::formats::header::Offered;
use crate::formats::moment::Moment;
use crate::formats::source::{Source, binary};
use crate::formats::{spreadsheet, track};
use crate::options::{Limits, ReadOptions};

/// Longest cell (bytes) that can be a number.
const LONGEST_CELL: usize = 64;
const SKIP: usize = usize::MAX;

/// Reads a text file, packed or not.
pub fn read(bytes: &[u8], options: &ReadOptions) -> Result<Table, ReadError> {
    let mut source = Source::open(bytes, &options.limits)?;
    let most_cells = source.most_cells();
    let packed = source.format();
    let Some(head) = source.next_block()? else {
        return Err(Problem::EmptyFile.into());
    };
    if let Some(what) = binary(head) {
        return Err(Problem::BinaryFile { what }.into());
    }
    let dialect = sniff(head, options)?;
    let recognised = Offered {
        names: &dialect.names,
        units: &dialect.units,
        line: dialect.header_line,
    }
    .recognise(options)?;
    let mut table = Table {
        ignored: recognised.ignored,
        unfound: recognised.unfound,
        warnings: recognised.warnings,
        format: describe(&dialect, packed),
        glimpses: dialect.glimpses.clone(),
        ..Table::default()
    };
    if dialect.preamble > 0 {
        let n = dialect.preamble;
        table.warnings.push(format!(
            "{n} lines of other text above the header were skipped"
        ));
    }
    let mut rows = Rows::new(&dialect, &recognised.specs, options);
    if let Some((cells, bomb)) = most_cells {
        let most = cells / recognised.specs.len().max(1);
        if most < rows.most {
            (rows.most, rows.beyond) = (most, bomb);
        }
    }
    rows.reserve(head.len() - dialect.offset, &head[dialect.offset..]);
    let mut more = rows.feed(&head[dialect.offset..])?;
    while more && let Some(block) = source.next_block()? {
        more = rows.feed(block)?;
    }
    rows.finish(recognised.specs, &mut table)?;
    Ok(table)
}

fn describe(dialect: &Dialect, packed: Option<&str>) -> String {
    let separator = match dialect.separator {
        Separator::Byte(b'\t') => "tab",
        Separator::Byte(b';') => "semicolon",
        Separator::Byte(_) => "comma",
        Separator::Blanks => "blanks",
    };
    let decimal = match dialect.decimal {
        Decimal::Comma => "comma",
        _ => "point",
    };
    match packed {
        Some(spreadsheet::FORMAT) => return "xlsx, first sheet".to_owned(),
        Some(track::FORMAT) => return "GPX or TCX track".to_owned(),
        _ => {}
    }
    let packed = packed.map(|p| format!("{p}, ")).unwrap_or_default();
    format!("{packed}text, separated by {separator}, decimal {decimal}")
}

struct Rows<'a> {
    separator: Separator,
    decimal: Decimal,
    /// Per column of the file: which output column it fills.
    slots: Vec<usize>,
    names: &'a [String],
    /// The output column of the time; a row may then be left out when all its cells are blank.
    time: Option<usize>,
    /// The first time stamp, where they are times of day: what all of them are counted from.
    first: Option<Moment>,
    /// Whether a cell that begins with a number is one.
    plain: bool,
    options: &'a ReadOptions,
    columns: Vec<Vec<f64>>,
    cells: Vec<f64>,
    /// Data rows seen, rows wanted of them, and most rows to keep.
    seen: usize,
    wanted: (usize, usize),
    most: usize,
    beyond: Problem,
    kept: usize,
    line: usize,
    places: crate::channels::table::Places,
    limits: Limits,
    /// A fault that is forgiven if no row follows: the logger died while writing.
    pending: Option<ReadError>,
}

impl<'a> Rows<'a> {
    fn new(dialect: &'a Dialect, specs: &[Spec], options: &'a ReadOptions) -> Self {
        let mut slots = vec![SKIP; dialect.names.len()];
        for (slot, spec) in specs.iter().enumerate() {
            slots[spec.number - 1] = slot;
        }
        Self {
            separator: dialect.separator,
            decimal: dialect.decimal,
            slots,
            names: &dialect.names,
            time: specs
                .iter()
                .position(|s| s.channel == crate::channels::channel::Channel::Time),
            first: None,
            plain: options.missing.is_empty(),
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
    fn reserve(&mut self, bytes: usize, text: &[u8]) {
        let sample = &text[..text.len().min(16 << 10)];
        let lines = memchr::memchr_iter(b'\n', sample).count().max(1);
        let rows = (bytes as f64 * lines as f64 / sample.len().max(1) as f64 * 1.02) as usize + 16;
        for column in &mut self.columns {
            column.reserve(rows.min(self.most));
        }
    }

    /// Takes whole lines; false once no more are wanted.
    fn feed(&mut self, block: &[u8]) -> Result<bool, ReadError> {
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
            if let Some(fault) = self.pending.take() {
                return Err(fault);
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
            match self.row(line) {
                Ok(()) if end.is_none() && self.is_cut_short(block) => {
                    self.pending = Some(Problem::CutShort.into());
                }
                Ok(()) => self.keep()?,
                Err(fault) => self.pending = Some(fault.at_line(self.line)),
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

    /// Fills `cells` from one line.
    fn row(&mut self, line: &[u8]) -> Result<(), ReadError> {
        if line.len() > self.limits.line_bytes {
            let limit = self.limits.line_bytes;
            return Err(Problem::LineTooLong { limit }.into());
        }
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
                && n <= LONGEST_CELL
                && value.abs() <= LARGEST
                && rest.get(n).is_none_or(|b| *b == separator)
            {
                self.cells[slot] = value;
                rest = &rest[n..];
            } else {
                let (cell, n) = cell(rest, separator);
                if slot != SKIP {
                    self.cells[slot] = self.value(cell, slot).map_err(|p| self.blame(index, p))?;
                }
                rest = &rest[n..];
            }
            match rest {
                [_, after @ ..] => rest = after,
                [] if index + 1 < self.slots.len() => return Err(self.ragged(index + 1)),
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
            if slot != SKIP {
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
        if self.time != Some(slot) {
            return self.number(cell);
        }
        match (Moment::parse(cell.trim_ascii()), self.first) {
            (None, None) => self.number(cell),
            (Some(moment), Some(first)) => Ok(moment.since(first)),
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

    /// The number in a cell, NaN where it is blank or a word for a missing value.
    fn number(&mut self, cell: &[u8]) -> Result<f64, Problem> {
        let cell = cell.trim_ascii();
        if cell.is_empty() || self.options.is_missing(cell) {
            return Ok(f64::NAN);
        }
        let mut digits = [0; LONGEST_CELL];
        let Some(digits) = digits.get_mut(..cell.len()) else {
            return Err(Problem::CellTooLong {
                bytes: cell.len(),
                limit: LONGEST_CELL,
            });
        };
        digits.copy_from_slice(cell);
        let point = memchr::memchr(b'.', cell);
        if let Some(comma) = memchr::memchr(b',', cell)
            && self.decimal != Decimal::Point
            && point.is_none()
        {
            self.decimal = Decimal::Comma;
            digits[comma] = b'.';
        }
        let mixed = point.is_some() && self.decimal == Decimal::Comma;
        let digits = digits.strip_prefix(b"+").unwrap_or(digits);
        match fast_float2::parse::<f64, _>(digits) {
            _ if mixed => Err(self.not_a_number(cell)),
            Ok(v) if !v.is_finite() => Err(Problem::NotFinite {
                cell: String::from_utf8_lossy(cell).into_owned(),
            }),
            Ok(v) if v.abs() > LARGEST => Err(Problem::OutOfRange {
                value: v,
                limit: LARGEST,
            }),
            Ok(v) => Ok(v),
            Err(_) => Err(self.not_a_number(cell)),
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

    fn finish(mut self, specs: Vec<Spec>, table: &mut Table) -> Result<(), ReadError> {
        if let Some(fault) = self.pending.take() {
            // A word for a missing value is no half line.
            if matches!(*fault.problem, Problem::NotFinite { .. }) || self.kept == 0 {
                return Err(fault);
            }
            self.seen -= 1;
            table.warnings.push(format!(
                "line {}, the last, is incomplete and was left out ({})",
                self.line, fault.problem
            ));
        }
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
        table.rows = self.kept;
        table.places = self.places;
        table.columns = specs.into_iter().zip(self.columns).collect();
        if let (Some(first), Some(time)) = (self.first, self.time) {
            table.epoch_s = Some(first.epoch_s());
            table.columns[time].0.unit = Unit::time_of_day();
        }
        Ok(())
    }
}

/// The first cell of `rest` without quotes, and how many bytes it takes up.
fn cell(rest: &[u8], separator: u8) -> (&[u8], usize) {
    let blanks = rest.iter().take_while(|b| **b == b' ').count();
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
