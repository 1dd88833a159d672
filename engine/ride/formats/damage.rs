//! Lines of a text file that are left out because they are damaged, and words that stand for missing values.

use crate::error::{Problem, ReadError};

/// Share of the lines that may be damaged.
const MOST: f64 = 0.01;
/// Lines that a note names.
const NAMED: usize = 4;
/// Words for a missing value, in small letters.
const WORDS: &[&str] = &[
    "nan", "na", "n/a", "#n/a", "#na", "null", "none", "nil", "missing", "-", "--", "---", "----",
    "*", "**", "***", "?", "#value!", "#div/0!", "#ref!",
];
/// Longest of these (bytes).
const LONGEST: usize = 8;

/// Lines that were left out.
#[derive(Default)]
pub struct Damage {
    lines: Vec<usize>,
    count: usize,
    /// The first fault, and the data rows before it.
    first: Option<(ReadError, usize)>,
    /// Lines that repeat the header.
    headers: Vec<usize>,
}

impl Damage {
    /// Adds a damaged line, which the fault names.
    pub fn add(&mut self, fault: ReadError, rows_before: usize) {
        self.count += 1;
        if self.lines.len() < NAMED {
            self.lines.extend(fault.line());
        }
        self.first.get_or_insert((fault, rows_before));
    }

    pub fn add_header(&mut self, line: usize) {
        if self.headers.len() < NAMED {
            self.headers.push(line);
        }
    }

    /// Notes of what was left out of `seen` lines; the first fault where that is too much.
    pub fn finish(self, seen: usize, notes: &mut Vec<String>) -> Result<(), ReadError> {
        if !self.headers.is_empty() {
            let lines = listed(&self.headers, self.headers.len());
            notes.push(format!(
                "the header is repeated in line(s) {lines}, which were left out"
            ));
        }
        let Some((fault, rows)) = self.first else {
            return Ok(());
        };
        if self.count as f64 > MOST * seen as f64 {
            return Err(match self.count {
                1 => fault,
                damaged => fault.among(damaged, seen, rows),
            });
        }
        let lines = listed(&self.lines, self.count);
        notes.push(format!(
            "{} damaged line(s) left out ({lines}); the first: {}",
            self.count, fault.problem
        ));
        Ok(())
    }
}

fn listed(lines: &[usize], count: usize) -> String {
    let named: Vec<String> = lines.iter().map(usize::to_string).collect();
    let more = if count > lines.len() { ", ..." } else { "" };
    format!("{}{more}", named.join(", "))
}

/// Words for missing values that were met, and how often.
#[derive(Default)]
pub struct Missing(Vec<(String, usize)>);

impl Missing {
    /// Whether a trimmed cell is such a word; it is counted.
    pub fn is_one(&mut self, cell: &[u8]) -> bool {
        if cell.len() > LONGEST {
            return false;
        }
        let Ok(word) = std::str::from_utf8(cell) else {
            return false;
        };
        if !WORDS.iter().any(|known| known.eq_ignore_ascii_case(word)) {
            return false;
        }
        match self.0.iter_mut().find(|(known, _)| known == word) {
            Some((_, count)) => *count += 1,
            None => self.0.push((word.to_owned(), 1)),
        }
        true
    }

    pub fn finish(self, notes: &mut Vec<String>) {
        let words = self.0.into_iter();
        notes.extend(
            words.map(|(word, count)| format!("{word}: {count} cell(s) are read as missing")),
        );
    }
}

impl ReadError {
    /// The same as the first of several damaged lines.
    fn among(self, damaged: usize, lines: usize, rows: usize) -> Self {
        let first = self.problem.clone();
        Self {
            problem: Box::new(Problem::Damaged {
                first,
                damaged,
                lines,
                rows,
            }),
            ..self
        }
    }
}
