//! Times as loggers write them: dates with times of day in the usual orders, times of day alone, and counts since 1970.

use jiff::civil::Date;
use jiff::fmt::strtime::BrokenDownTime;

use super::moment::{EPOCHS_S, Moment, time_of_day};
use super::usual_time::{duration, usual};

/// A year before is one of two digits.
const FIRST_YEAR: i16 = 1900;
/// Longest time (bytes), with the name of its zone.
const LONGEST: usize = 80;

const YEAR_FIRST: &[&str] = &["%Y-%m-%d", "%Y/%m/%d", "%Y.%m.%d", "%Y%m%d", "%Y-%j"];
const NAMED_MONTH: &[&str] = &["%d-%b-%Y", "%d %b %Y", "%b %d, %Y", "%d-%b-%y"];
const DAY_FIRST: &[&str] = &["%d.%m.%Y", "%d/%m/%Y", "%d-%m-%Y", "%d.%m.%y", "%d/%m/%y"];
const MONTH_FIRST: &[&str] = &["%m/%d/%Y", "%m-%d-%Y", "%m/%d/%y"];

/// How the dates of a column are ordered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Order {
    #[default]
    DayFirst,
    MonthFirst,
}

/// Reads the times of one column.
#[derive(Clone, Debug, Default)]
pub struct Times {
    order: Order,
    /// The last date and its text: it is the same in most rows.
    last: Option<(String, Date)>,
    /// The format that the user gives.
    format: Option<String>,
    /// The date in a column of its own.
    beside: Option<Date>,
}

impl Times {
    pub fn new(order: Order, format: Option<String>) -> Self {
        Self {
            order,
            last: None,
            format,
            beside: None,
        }
    }

    /// The moment that a trimmed cell gives; `None` where it is a number or no time.
    pub fn read(&mut self, cell: &[u8]) -> Option<Moment> {
        if let Some(format) = &self.format
            && let Some(moment) = formatted(std::str::from_utf8(cell).ok()?, format)
        {
            return Some(moment);
        }
        if let Some(moment) = count(cell) {
            return Some(moment);
        }
        let has = |at: usize, marks: &[u8]| cell.get(at).is_some_and(|b| marks.contains(b));
        let is_unusual = || has(4, b"-") && has(10, b"_T") || !cell.is_ascii();
        let looks_like_one = cell.contains(&b':') || has(8, b"Tt") || is_unusual();
        if !looks_like_one || cell.len() > LONGEST {
            return None;
        }
        let text = std::str::from_utf8(cell).ok()?;
        (self.calendar(text))
            .or_else(|| self.calendar(&usual(text)?))
            .or_else(|| duration(text))
    }

    /// A date with a time of day, or this alone.
    fn calendar(&mut self, text: &str) -> Option<Moment> {
        let (date, time) = split(text);
        let (time, ahead_s) = without_zone(time)?;
        let time = time_of_day(time)?;
        match date {
            Some(date) => Moment::dated(self.date(date)?, time, ahead_s),
            None => match self.beside {
                Some(date) => Moment::dated(date, time, ahead_s),
                None => Some(Moment::of_day(time)),
            },
        }
    }

    /// Takes the date in a column before the time of day.
    pub fn take_date(&mut self, cell: &[u8]) {
        let text = std::str::from_utf8(cell).unwrap_or_default().trim();
        self.beside = self.date(text);
    }

    fn date(&mut self, text: &str) -> Option<Date> {
        if let Some((known, date)) = &self.last
            && known == text
        {
            return Some(*date);
        }
        let date = date(text, self.order)?;
        self.last = Some((text.to_owned(), date));
        Some(date)
    }
}

fn date(text: &str, order: Order) -> Option<Date> {
    let (first, second) = match order {
        Order::DayFirst => (DAY_FIRST, MONTH_FIRST),
        Order::MonthFirst => (MONTH_FIRST, DAY_FIRST),
    };
    let patterns = [YEAR_FIRST, NAMED_MONTH, first, second];
    let mut patterns = patterns.into_iter().flatten();
    patterns.find_map(|pattern| {
        let is_short = pattern.ends_with("%y");
        let is_wide = text
            .rsplit(['.', '/', '-'])
            .next()
            .is_some_and(|year| year.len() == 4);
        Date::strptime(pattern, text)
            .ok()
            .filter(|date| !(is_short && is_wide) && date.year() >= FIRST_YEAR)
    })
}

/// A time in the user's format; one without a time of day is none.
fn formatted(text: &str, format: &str) -> Option<Moment> {
    let parts = BrokenDownTime::parse(format, text).ok()?;
    let time = parts.to_time().ok()?;
    match parts.to_date() {
        Ok(date) => Moment::dated(date, time, parts.offset().map_or(0, |o| o.seconds().into())),
        Err(_) => Some(Moment::of_day(time)),
    }
}

/// Date and time of day, apart at `T` or at the last blank before it.
fn split(text: &str) -> (Option<&str>, &str) {
    let colon = text.find(':').unwrap_or(text.len());
    let at = match text[..colon].rfind(' ') {
        Some(at) => Some(at),
        None => text.find(['T', 't']),
    };
    match at {
        Some(at) if at > 0 => (
            Some(text[..at].trim_end_matches([',', ' '])),
            text[at + 1..].trim_start(),
        ),
        _ => (None, text),
    }
}

/// The time before a zone, and how much (s) that is ahead of UTC.
fn without_zone(time: &str) -> Option<(&str, i64)> {
    for zone in [" UTC", " GMT", "Z", "z"] {
        if let Some(time) = time.strip_suffix(zone) {
            return Some((time.trim_end(), 0));
        }
    }
    let Some(at) = time.rfind(['+', '-']) else {
        return Some((time, 0));
    };
    let sign = if time.as_bytes()[at] == b'-' { -1 } else { 1 };
    let digits: String = time[at + 1..].chars().filter(|c| *c != ':').collect();
    if !digits.is_ascii() {
        return None;
    }
    let (hours, minutes) = match digits.len() {
        2 => (digits.parse::<i64>().ok()?, 0),
        4 => (digits[..2].parse().ok()?, digits[2..].parse::<i64>().ok()?),
        _ => return None,
    };
    let is_one = (0..24).contains(&hours) && (0..60).contains(&minutes);
    is_one.then_some((time[..at].trim_end(), sign * (3600 * hours + 60 * minutes)))
}

/// Micro- or nanoseconds since 1970: whole numbers that no other stamp can be.
fn count(cell: &[u8]) -> Option<Moment> {
    let per_second = match cell.len() {
        15 | 16 => 1_000_000,
        18 | 19 => 1_000_000_000,
        _ => return None,
    };
    let count: i64 = std::str::from_utf8(cell).ok()?.parse().ok()?;
    let second = count.div_euclid(per_second);
    EPOCHS_S.contains(&(second as f64)).then(|| Moment {
        second,
        part: count.rem_euclid(per_second) as f64 / per_second as f64,
        is_dated: true,
    })
}

/// The order of days and months in some cells, and both readings of the first where nothing says.
pub fn order<'a>(cells: impl Iterator<Item = &'a str>) -> (Order, Option<[Date; 2]>) {
    let mut open = None;
    for cell in cells {
        let (Some(text), _) = split(cell) else {
            continue;
        };
        let day = date(text, Order::DayFirst);
        let month = date(text, Order::MonthFirst);
        let [Some(day), Some(month)] = [day, month] else {
            continue;
        };
        if day == month {
            let first: Option<u32> = text
                .split(['/', '-', '.'])
                .next()
                .and_then(|d| d.parse().ok());
            let is_named = text.starts_with(|c: char| c.is_alphabetic());
            let month_first = first == Some(day.month().unsigned_abs().into())
                && day.month() != day.day()
                && !is_named
                && first.is_some_and(|f| f <= 12);
            return (
                if month_first {
                    Order::MonthFirst
                } else {
                    Order::DayFirst
                },
                None,
            );
        }
        // A point is written between numbers where the day stands first, and AM or PM where the month does.
        if text.contains('.') {
            return (Order::DayFirst, None);
        }
        if cell.ends_with(['M', 'm']) {
            return (Order::MonthFirst, None);
        }
        open = open.or(Some([day, month]));
    }
    (Order::DayFirst, open)
}

/// Whether a cell is a date without a time of day.
pub fn is_date(cell: &str) -> bool {
    let has_marks = cell.matches(['-', '/', '.']).count() == 2;
    (8..=11).contains(&cell.len()) && has_marks && date(cell, Order::DayFirst).is_some()
}

/// Whether a cell is a time.
pub fn is_time(cell: &str) -> bool {
    Times::default().read(cell.as_bytes()).is_some()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn epoch(text: &str) -> Option<f64> {
        Times::default().read(text.as_bytes()).map(|m| m.epoch_s())
    }

    #[test]
    fn dates_with_times_are_seconds_since_1970() {
        for (text, expected) in [
            ("1970-01-01T00:00:00Z", 0.0),
            ("2000-02-29 12:00", 951_825_600.0),
            ("2026-11-23T09:51:10.25", 1_795_427_470.25),
            ("2026-11-23T10:51:10.25+01:00", 1_795_427_470.25),
            ("2026-11-23t04:21:10,25-0530", 1_795_427_470.25),
            ("1969-12-31T23:59:59.5z", -0.5),
            ("2026-11-23T09:51:10.", 1_795_427_470.0),
            ("11/23/2026 09:51:10.25 AM", 1_795_427_470.25),
            ("11/23/2026 09:51:10 PM", 1_795_470_670.0),
            ("23.11.2026 09:51:10,250", 1_795_427_470.25),
            ("2026/11/23 09:51:10.25", 1_795_427_470.25),
            ("2026-11-23 09:51:10.25 UTC", 1_795_427_470.25),
            ("20261123T095110.25Z", 1_795_427_470.25),
            ("23-Nov-2026 09:51:10", 1_795_427_470.0),
            ("23-Nov-26 09:51:10", 1_795_427_470.0),
            ("23.11.26 09:51:10", 1_795_427_470.0),
            ("11/23/2026 09:51:10.250000000", 1_795_427_470.25),
            ("1795427470250000", 1_795_427_470.25),
            ("1795427470250000000", 1_795_427_470.25),
        ] {
            assert_eq!(epoch(text), Some(expected), "{text}");
        }
    }

    #[test]
    fn times_of_day_are_seconds_since_midnight() {
        for (text, expected) in [
            ("10:00:00.5", 36_000.5),
            ("10:00:00:500", 36_000.5),
            ("23:59", 86_340.0),
        ] {
            assert_eq!(epoch(text), Some(expected), "{text}");
        }
        let at = |text: &str| Times::default().read(text.as_bytes()).unwrap();
        let late = at("23:59:59.5");
        assert_eq!(at("00:00:00.5").after(late).since(late), 1.0);
    }

    #[test]
    fn other_text_is_no_time() {
        for text in [
            "",
            "2026",
            "2026-13-01T00:00:00",
            "2026-11-23T24:00:00",
            "2026-11-23T10:00:00+1",
            "2026-11-23T10:00:00+01:0",
            "2026-11-23T10:00:00Zx",
            "12.5",
            "100: gps",
            "a:b",
            "1234567890123456789012",
        ] {
            assert_eq!(epoch(text), None, "{text}");
        }
    }

    #[test]
    fn the_order_of_day_and_month_follows_from_days_beyond_twelve() {
        let of = |text: &str| order([text].into_iter());
        assert_eq!(of("05/21/2026 10:00:00"), (Order::MonthFirst, None));
        assert_eq!(of("21/05/2026 10:00:00"), (Order::DayFirst, None));
        assert_eq!(of("04.05.2026 10:00:00"), (Order::DayFirst, None));
        assert_eq!(of("04/05/2026 10:00:00 AM"), (Order::MonthFirst, None));
        assert_eq!(of("2026-05-04 10:00:00").1, None);
        assert!(of("04/05/2026 10:00:00").1.is_some());
    }

    #[test]
    fn a_date_may_stand_in_a_column_of_its_own() {
        let mut times = Times::default();
        times.take_date(b"21.05.2026");
        let moment = times.read(b"10:00:00.5").unwrap();
        assert_eq!((moment.is_dated, moment.epoch_s()), (true, 1_779_357_600.5));
        for (cell, expected) in [
            ("21.05.2026", true),
            ("5/21/2026", true),
            ("2026-05-21", true),
            ("1.5.2", false),
            ("10:00:00", false),
            ("20260521", false),
        ] {
            assert_eq!(is_date(cell), expected, "{cell}");
        }
    }

    #[test]
    fn no_digit_is_lost_between_moments() {
        let at = |text: &str| Times::default().read(text.as_bytes()).unwrap();
        let first = at("2026-11-23T23:59:59.999999");
        let next = at("2026-11-24T00:00:00.000001");
        assert!((next.since(first) - 2e-6).abs() < 1e-15);
    }
}
