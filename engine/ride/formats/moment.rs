//! Times of day as ISO 8601 writes them: `2026-11-23T09:51:10.25+01:00`.

/// An instant: whole seconds since 1970 (UTC) and the rest of a second, in parts that keep all their digits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    pub second: i64,
    pub part: f64,
}

/// Epochs (s) of the years 1990 and 2100: a time stamp between them says when it was taken.
pub const EPOCHS_S: std::ops::Range<f64> = 631_152_000.0..4_102_444_800.0;

impl Moment {
    /// Reads a date and a time with `T` or a blank between; without a zone it is taken as UTC.
    pub fn parse(text: &[u8]) -> Option<Self> {
        let mut text = Cursor(text);
        let year = text.digits(4)?;
        text.one_of(b"-")?;
        let month = text.digits(2).filter(|m| (1..=12).contains(m))?;
        text.one_of(b"-")?;
        let day = text.digits(2).filter(|d| (1..=31).contains(d))?;
        text.one_of(b"Tt ")?;
        let hour = text.digits(2).filter(|h| *h < 24)?;
        text.one_of(b":")?;
        let minute = text.digits(2).filter(|m| *m < 60)?;
        let mut second = 0;
        let mut part = 0.0;
        if text.one_of(b":").is_some() {
            // 60 is a leap second.
            second = text.digits(2).filter(|s| *s <= 60)?;
            part = text.fraction()?;
        }
        let ahead = text.zone()?;
        Some(Self {
            second: 86_400 * days(year, month, day) + 3600 * hour + 60 * minute + second - ahead,
            part,
        })
    }

    pub fn epoch_s(&self) -> f64 {
        self.second as f64 + self.part
    }

    /// Seconds since another one.
    pub fn since(&self, other: Moment) -> f64 {
        (self.second - other.second) as f64 + (self.part - other.part)
    }
}

/// Days from 1970-01-01 to a date of the Gregorian calendar (Hinnant, "chrono-compatible low-level date algorithms", 2013).
fn days(year: i64, month: i64, day: i64) -> i64 {
    let year = if month <= 2 { year - 1 } else { year };
    let of_era = year.rem_euclid(400);
    let of_year = (153 * ((month + 9) % 12) + 2) / 5 + day - 1;
    let of_era = of_era * 365 + of_era / 4 - of_era / 100 + of_year;
    year.div_euclid(400) * 146_097 + of_era - 719_468
}

struct Cursor<'a>(&'a [u8]);

impl Cursor<'_> {
    fn digits(&mut self, count: usize) -> Option<i64> {
        let (digits, rest) = self.0.split_at_checked(count)?;
        if !digits.iter().all(u8::is_ascii_digit) {
            return None;
        }
        self.0 = rest;
        let value = |sum: i64, digit: &u8| 10 * sum + i64::from(digit - b'0');
        Some(digits.iter().fold(0, value))
    }

    fn one_of(&mut self, any: &[u8]) -> Option<u8> {
        let (first, rest) = self.0.split_first()?;
        if !any.contains(first) {
            return None;
        }
        self.0 = rest;
        Some(*first)
    }

    /// What follows a decimal point or comma, if there is one.
    fn fraction(&mut self) -> Option<f64> {
        if self.one_of(b".,").is_none() {
            return Some(0.0);
        }
        let count = self.0.iter().take_while(|b| b.is_ascii_digit()).count();
        let (digits, rest) = self.0.split_at(count);
        self.0 = rest;
        let text = std::str::from_utf8(digits).ok()?;
        format!("0.{text}0").parse().ok()
    }

    /// Seconds that the zone is ahead of UTC; nothing may follow.
    fn zone(&mut self) -> Option<i64> {
        if self.0.is_empty() {
            return Some(0);
        }
        let sign = match self.one_of(b"Zz+-")? {
            b'+' => 1,
            b'-' => -1,
            _ => return self.0.is_empty().then_some(0),
        };
        let hours = self.digits(2).filter(|h| *h < 24)?;
        let _ = self.one_of(b":");
        let minutes = match self.0.is_empty() {
            true => 0,
            false => self.digits(2).filter(|m| *m < 60)?,
        };
        self.0
            .is_empty()
            .then_some(sign * (3600 * hours + 60 * minutes))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn moments_are_seconds_since_1970() {
        let epoch = |text: &str| Moment::parse(text.as_bytes()).map(|m| m.epoch_s());
        for (text, expected) in [
            ("1970-01-01T00:00:00Z", 0.0),
            ("2000-02-29 12:00", 951_825_600.0),
            ("2026-11-23T09:51:10.25", 1_795_427_470.25),
            ("2026-11-23T10:51:10.25+01:00", 1_795_427_470.25),
            ("2026-11-23t04:21:10,25-0530", 1_795_427_470.25),
            ("1969-12-31T23:59:59.5z", -0.5),
            ("2026-11-23T09:51:10.", 1_795_427_470.0),
        ] {
            assert_eq!(epoch(text), Some(expected), "{text}");
        }
        for text in [
            "",
            "2026",
            "2026-11-23",
            "2026-13-01T00:00:00",
            "2026-11-23T24:00:00",
            "2026-11-23T10:00:00 ",
            "2026-11-23T10:00:00+1",
            "2026-11-23T10:00:00+01:0",
            "2026-11-23T10:00:00Zx",
            "+026-11-23T10:00:00",
            "12.5",
        ] {
            assert_eq!(epoch(text), None, "{text}");
        }
    }

    #[test]
    fn no_digit_is_lost_between_moments() {
        let at = |text: &str| Moment::parse(text.as_bytes()).unwrap();
        let first = at("2026-11-23T23:59:59.999999");
        let next = at("2026-11-24T00:00:00.000001");
        assert!((next.since(first) - 2e-6).abs() < 1e-15);
    }
}
