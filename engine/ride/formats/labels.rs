//! Rows that hold the names of their values, as serial monitors show them: `t:0.01,z_f:0.2` or `t=0.01 z_f=0.2`.

use super::cells::Separator;
use super::number::is_number;
use super::times::is_time;

/// Fewest rows and names.
const FEWEST_ROWS: usize = 3;
const FEWEST_NAMES: usize = 2;

/// The names in each row.
#[derive(Clone, Debug, PartialEq)]
pub struct Labels {
    pub separator: Separator,
    /// What stands between a name and its value.
    mark: u8,
    names: Vec<String>,
}

impl Labels {
    /// Those of all lines but comments and the last, which may be cut short; none where one line has others.
    pub fn of(lines: &[&str]) -> Option<Self> {
        if lines.len() < FEWEST_ROWS {
            return None;
        }
        let separators = [b',', b';', b'\t'].map(Separator::Byte);
        let separators = separators.into_iter().chain([Separator::Blanks]);
        let found = separators.flat_map(|separator| {
            [b':', b'='].map(|mark| Self::of_line(lines[0], separator, mark))
        });
        let labels = found.flatten().next()?;
        let fits = |line: &&str| labels.without(line.as_bytes()).is_some();
        lines[..lines.len() - 1].iter().all(fits).then_some(labels)
    }

    fn of_line(line: &str, separator: Separator, mark: u8) -> Option<Self> {
        let pairs = pairs(line, separator, mark)?;
        let is_name = |name: &str| name.starts_with(|c: char| c.is_alphabetic());
        let is_pair =
            |(name, value): &(&str, &str)| is_name(name) && (is_number(value) || is_time(value));
        (pairs.len() >= FEWEST_NAMES && pairs.iter().all(is_pair)).then(|| Self {
            separator,
            mark,
            names: pairs.iter().map(|(name, _)| (*name).to_owned()).collect(),
        })
    }

    pub fn names(&self) -> Vec<String> {
        self.names.clone()
    }

    /// A line without its names; none where they are others.
    pub fn without(&self, line: &[u8]) -> Option<Vec<u8>> {
        let line = std::str::from_utf8(line).ok()?;
        let pairs = pairs(line, self.separator, self.mark)?;
        let names = pairs.iter().map(|(name, _)| *name);
        if !names.eq(self.names.iter().map(String::as_str)) {
            return None;
        }
        let values: Vec<&str> = pairs.iter().map(|(_, value)| *value).collect();
        let separator = self.separator.as_char().to_string();
        Some(values.join(&separator).into_bytes())
    }
}

/// Names and values of a line; none where a cell is no pair.
fn pairs<'l>(line: &'l str, separator: Separator, mark: u8) -> Option<Vec<(&'l str, &'l str)>> {
    let mark = char::from(mark);
    match separator {
        Separator::Byte(byte) => {
            let line = line.trim().trim_end_matches(char::from(byte));
            let trimmed = |(name, value): (&'l str, &'l str)| (name.trim(), value.trim());
            line.split(char::from(byte))
                .map(|cell| cell.split_once(mark).map(trimmed))
                .collect()
        }
        Separator::Blanks => {
            let mut pairs = Vec::new();
            let mut words = line.split_ascii_whitespace();
            while let Some(word) = words.next() {
                let (name, value) = word.split_once(mark)?;
                // `t: 0.01`, too.
                let value = if value.is_empty() {
                    words.next()?
                } else {
                    value
                };
                pairs.push((name, value));
            }
            Some(pairs)
        }
    }
}
