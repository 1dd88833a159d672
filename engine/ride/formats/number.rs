//! Numbers as programs write them: with either decimal sign, in groups of three digits apart by a sign, a blank or an apostrophe, with a
//! typographic minus or a Fortran exponent.

use crate::channels::unit::Unit;

/// Longest cell (bytes) that can be a number.
pub const LONGEST: usize = 64;
/// Stands for any blank or apostrophe between groups.
const APART: u8 = b'\'';

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decimal {
    Point,
    Comma,
    /// Only whole numbers so far.
    Undecided,
}

impl Decimal {
    /// The sign; a point while nothing is decided.
    pub fn sign(self) -> u8 {
        match self {
            Self::Comma => b',',
            _ => b'.',
        }
    }
}

/// What a sign between digits of a cell may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Signs {
    /// None, in a number of up to three digits or of more.
    Few,
    Many,
    /// One decimal sign.
    Decimal,
    /// One before the last three digits: a decimal sign or that of a group.
    Either,
    /// Between groups alone.
    Groups,
}

/// A number and what the signs in it are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Number {
    pub value: f64,
    pub signs: Signs,
}

/// The number in a trimmed cell whose decimal sign is `decimal`; `None` where it is none.
pub fn number(cell: &[u8], decimal: u8) -> Option<Number> {
    let mut plain = [0; LONGEST];
    let text = ascii(cell, &mut plain)?;
    let mut joined = [0; LONGEST];
    let text = match text.contains(&APART) {
        true => without_groups(text, &mut joined)?,
        false => text,
    };
    let text = text.strip_prefix(b"+").unwrap_or(text);
    let group = if decimal == b'.' { b',' } else { b'.' };
    let whole = text.strip_prefix(b"-").unwrap_or(text);
    let end = whole
        .iter()
        .position(|b| !b.is_ascii_digit() && !b".,".contains(b));
    let whole = &whole[..end.unwrap_or(whole.len())];
    let has_exponent = text.len() > 1 && text.iter().any(|b| b"eE".contains(b));
    let count = |sign: u8| whole.iter().filter(|b| **b == sign).count();
    let signs = match (count(decimal), count(group)) {
        (0 | 1, 0) if has_exponent => Signs::Decimal,
        (0, 0) if whole.len() <= 3 => Signs::Few,
        (0, 0) => Signs::Many,
        (1, 0) if is_grouped(whole, decimal) => Signs::Either,
        (1, 0) => Signs::Decimal,
        (0, _) if is_grouped(whole, group) => Signs::Groups,
        (1, _) => {
            let at = whole.iter().position(|b| *b == decimal)?;
            is_grouped(&whole[..at], group).then_some(Signs::Decimal)?
        }
        (_, 0) if is_grouped(whole, decimal) => Signs::Groups,
        _ => return None,
    };
    let mut kept = [0; LONGEST];
    let mut length = 0;
    for byte in text {
        let byte = match *byte {
            sign if signs == Signs::Groups && b".,".contains(&sign) => continue,
            sign if sign == group => continue,
            sign if sign == decimal => b'.',
            other => other,
        };
        *kept.get_mut(length)? = byte;
        length += 1;
    }
    let value = fast_float2::parse::<f64, _>(&kept[..length]).ok()?;
    Some(Number { value, signs })
}

/// A number whose groups are apart by a blank or an apostrophe, without these.
fn without_groups<'a>(text: &[u8], joined: &'a mut [u8; LONGEST]) -> Option<&'a [u8]> {
    let (sign, digits) = match text {
        [sign @ (b'+' | b'-'), rest @ ..] => {
            // Some loggers write the sign apart.
            let blanks = rest.iter().take_while(|b| **b == APART).count();
            (Some(*sign), &rest[blanks..])
        }
        _ => (None, text),
    };
    let end = digits
        .iter()
        .position(|b| !b.is_ascii_digit() && *b != APART)
        .unwrap_or(digits.len());
    let (whole, rest) = digits.split_at(end);
    if whole.contains(&APART) && !is_grouped(whole, APART) || rest.contains(&APART) {
        return None;
    }
    let kept = sign.into_iter().chain(digits.iter().copied());
    let mut length = 0;
    for byte in kept.filter(|b| *b != APART) {
        *joined.get_mut(length)? = byte;
        length += 1;
    }
    Some(&joined[..length])
}

/// Whether digits stand in groups of three, the first of which is shorter or as long and does not begin with a zero.
fn is_grouped(digits: &[u8], sign: u8) -> bool {
    let mut groups = digits.split(|b| *b == sign);
    let first = groups.next().unwrap_or_default();
    let is_digits = |group: &[u8]| group.iter().all(u8::is_ascii_digit);
    (1..=3).contains(&first.len())
        && first[0] != b'0'
        && is_digits(first)
        && groups.all(|group| group.len() == 3 && is_digits(group))
}

/// The cell with an ASCII minus, `e` before the exponent, and [`APART`] for what may stand between groups.
fn ascii<'a>(cell: &[u8], plain: &'a mut [u8; LONGEST]) -> Option<&'a [u8]> {
    let mut length = 0;
    let mut rest = cell;
    while let [first, after @ ..] = rest {
        let (byte, after) = match rest {
            [0xe2, 0x88, 0x92, after @ ..] => (b'-', after),
            [b'D' | b'd', ..] if length > 0 => (b'e', after),
            // Narrow and thin blanks, and the typographic apostrophe.
            [0xe2, 0x80, 0xaf | 0x89 | 0x99, after @ ..] => (APART, after),
            // The blank that breaks no line, in UTF-8 and Latin-1, and the apostrophe of Windows-1252.
            [0xc2, 0xa0, after @ ..] => (APART, after),
            [b' ' | b'\'' | 0xa0 | 0x92, ..] => (APART, after),
            _ => (*first, after),
        };
        *plain.get_mut(length)? = byte;
        length += 1;
        rest = after;
    }
    Some(&plain[..length])
}

/// A number and the unit behind it, as in `0.2 mm` or `5s`.
pub fn with_unit(cell: &str) -> Option<(&str, &str)> {
    let bytes = cell.as_bytes();
    let mut end = 0;
    while let Some(byte) = bytes.get(end) {
        let is_exponent = matches!(byte, b'e' | b'E')
            && end > 0
            && matches!(
                bytes.get(end + 1..),
                Some([b'0'..=b'9', ..] | [b'+' | b'-', b'0'..=b'9', ..])
            );
        let is_sign = |at: usize| at == 0 || matches!(bytes[at - 1], b'e' | b'E');
        match byte {
            b'0'..=b'9' | b'.' | b',' => {}
            b'+' | b'-' if is_sign(end) => {}
            _ if is_exponent => {}
            _ => break,
        }
        end += 1;
    }
    let (number, unit) = cell.split_at_checked(end)?;
    let is_one = number.ends_with(|c: char| c.is_ascii_digit()) && is_number(number);
    let unit = unit.trim();
    (is_one && Unit::is_one(unit)).then_some((number, unit))
}

/// Whether a cell is a number with either decimal sign.
pub fn is_number(cell: &str) -> bool {
    let read = |decimal| number(cell.trim().as_bytes(), decimal).is_some();
    read(b'.') || read(b',')
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn numbers_of_many_programs_are_read() {
        for (cell, decimal, value) in [
            ("1.5", b'.', 1.5),
            ("+1,5", b',', 1.5),
            ("\u{2212}0,25", b',', -0.25),
            ("1.25D-03", b'.', 1.25e-3),
            ("-2e3", b'.', -2000.0),
            ("1,234.5", b'.', 1234.5),
            ("1.234.567,5", b',', 1_234_567.5),
            ("1,234,567", b'.', 1_234_567.0),
            ("-1.234.567", b'.', -1_234_567.0),
            ("12,345", b'.', 12_345.0),
            (".5", b'.', 0.5),
            ("5'001.8", b'.', 5001.8),
            ("-6\u{2019}373.8", b'.', -6373.8),
            ("-1 006 373,8", b',', -1_006_373.8),
            ("5\u{a0}001,8", b',', 5001.8),
            ("5\u{202f}001", b',', 5001.0),
            ("-   0.0397", b'.', -0.0397),
        ] {
            assert_eq!(
                number(cell.as_bytes(), decimal).unwrap().value,
                value,
                "{cell}"
            );
        }
    }

    #[test]
    fn text_and_broken_groups_are_refused() {
        for cell in [
            "",
            "-",
            "t",
            "1.2.3",
            "1,23,456.5",
            "0,123.5",
            "12:30",
            "1-2",
            "0,5.5",
            "1 2",
            "01 234",
            "1 2345",
            "1.234 567",
            "1 234 5",
            "'",
            "- ",
        ] {
            assert_eq!(number(cell.as_bytes(), b'.'), None, "{cell}");
        }
        assert_eq!(number(&[b'1'; LONGEST + 1], b'.'), None);
        assert_eq!(number(b"-6\xa0373,8", b',').unwrap().value, -6373.8);
    }

    #[test]
    fn what_a_sign_may_be_is_known() {
        for (cell, signs) in [
            ("812", Signs::Few),
            ("1234", Signs::Many),
            ("1.234", Signs::Either),
            ("0.234", Signs::Decimal),
            ("1.2", Signs::Decimal),
            ("1.234.567", Signs::Groups),
            ("1,234", Signs::Groups),
        ] {
            assert_eq!(
                number(cell.as_bytes(), b'.').unwrap().signs,
                signs,
                "{cell}"
            );
        }
    }

    #[test]
    fn a_unit_may_stand_behind_a_number() {
        for (cell, number, unit) in [
            ("0.2 mm", "0.2", "mm"),
            ("-0,005s", "-0,005", "s"),
            ("8.3e-05 min", "8.3e-05", "min"),
            ("1 m/s^2", "1", "m/s^2"),
            ("18 km/h", "18", "km/h"),
        ] {
            assert_eq!(with_unit(cell), Some((number, unit)), "{cell}");
        }
        for cell in ["mm", "0.2", "1 furlong", "z_f", "s5", "1..2 mm", "5 mm 6"] {
            assert_eq!(with_unit(cell), None, "{cell}");
        }
    }
}
