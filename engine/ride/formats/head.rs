//! The first lines of a text file.

use std::borrow::Cow;

use encoding_rs::WINDOWS_1252;

use crate::error::{Problem, ReadError};

/// Lines looked at before deciding how a file is written.
pub const SAMPLE: usize = 200;
const SAMPLE_BYTES: usize = 128 << 10;
/// Most lines of a header whose cells hold line ends.
const HEADER_LINES: usize = 64;
const HEADER_BYTES: usize = 8 << 10;
/// Comments above the table that are kept.
const COMMENTS: usize = 64;

pub struct Line<'a> {
    pub text: Cow<'a, str>,
    /// Counted from 1.
    pub number: usize,
    pub start: usize,
    pub end: usize,
}

pub fn is_comment(line: &[u8]) -> bool {
    matches!(line.trim_ascii_start(), [b'#' | b'%', ..])
}

/// The first lines that are neither blank nor comments, and the comments above them.
pub fn sample(head: &[u8], limit: usize) -> Result<(Vec<Line<'_>>, Vec<Line<'_>>), ReadError> {
    let (mut lines, mut comments) = (Vec::new(), Vec::new());
    let (mut start, mut number) = (0, 0);
    while start < head.len() && lines.len() < SAMPLE && (start < SAMPLE_BYTES || lines.len() < 3) {
        let end = memchr::memchr(b'\n', &head[start..]).map_or(head.len(), |i| start + i + 1);
        number += 1;
        if end - start > limit + 2 && !is_comment(&head[start..end]) {
            return Err(ReadError::from(Problem::LineTooLong { limit }).at_line(number));
        }
        let more = lines_in_quotes(&head[start..], end - start);
        let end = (0..more).fold(end, |end, _| {
            memchr::memchr(b'\n', &head[end..]).map_or(head.len(), |i| end + i + 1)
        });
        number += more;
        let bytes = head[start..end].trim_ascii_end();
        let line = Line {
            text: match more {
                0 => decode(bytes),
                _ => Cow::Owned(decode(bytes).replace("\r\n", " ").replace('\n', " ")),
            },
            number,
            start,
            end,
        };
        if is_comment(bytes) {
            if lines.is_empty() && comments.len() < COMMENTS {
                comments.push(line);
            }
        } else if !bytes.is_empty() {
            lines.push(line);
        }
        start = end;
    }
    Ok((lines, comments))
}

/// How many lines follow the first, of so many bytes, until the quotes are closed in which its last cell begins.
fn lines_in_quotes(text: &[u8], first: usize) -> usize {
    let is_open = |line: &[u8], open: bool| {
        let quotes = line.iter().filter(|b| **b == b'"').count();
        open != (quotes % 2 == 1)
    };
    let text = &text[..text.len().min(first + HEADER_BYTES)];
    let line = text[..first].trim_ascii();
    // An inch sign behind a number opens none.
    let begins = line.iter().rposition(|b| *b == b'"');
    let opens = |at: usize| at == 0 || b",;\t|".contains(&line[at - 1]);
    if !is_open(line, false) || !begins.is_some_and(opens) {
        return 0;
    }
    let mut open = true;
    let following = text[first..].split(|b| *b == b'\n').take(HEADER_LINES);
    for (index, line) in following.enumerate() {
        open = is_open(line, open);
        if !open {
            return index + 1;
        }
    }
    0
}

/// UTF-8, or else Windows-1252, which has all letters of Latin-1.
pub fn decode(bytes: &[u8]) -> Cow<'_, str> {
    match std::str::from_utf8(bytes) {
        Ok(text) => Cow::Borrowed(text),
        Err(_) => WINDOWS_1252.decode_without_bom_handling(bytes).0,
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn cells_in_quotes_may_hold_line_ends() {
        let text = b"\"Zeit\r\n[s]\",\"Weg vorne\r\n[mm]\"\r\n0,1\r\n";
        let (lines, _) = sample(text, 1000).unwrap();
        assert_eq!(lines[0].text, "\"Zeit [s]\",\"Weg vorne [mm]\"");
        assert_eq!((lines[1].number, &lines[1].text[..]), (4, "0,1"));
        for text in [&b"a 5\" tyre\n0,1\n0,2\n"[..], b"\"a\n0,1\n0,2\n"] {
            assert_eq!(sample(text, 1000).unwrap().0.len(), 3);
        }
    }
}
