//! Times at the edge: epoch milliseconds inside, RFC 3339 outside.

use jiff::Timestamp;
use jiff::civil::{Date, date};
use jiff::tz::TimeZone;
use utoipa::openapi::schema::{AnyOfBuilder, ObjectBuilder, Schema, Type};
use utoipa::openapi::{KnownFormat, SchemaFormat};

use crate::unique::shown;

const EPOCH: Date = date(1970, 1, 1);
const DAY_MS: i64 = 86_400_000;

/// As RFC 3339 in UTC, always with three digits of the second's fraction: as texts, times sort as they passed.
pub fn text(epoch_ms: i64) -> String {
    let time = Timestamp::from_millisecond(epoch_ms);
    time.map_or_else(|_| epoch_ms.to_string(), |t| format!("{t:.3}"))
}

/// An RFC 3339 time as epoch milliseconds.
pub fn epoch_ms(time: &str) -> Option<i64> {
    time.parse().ok().map(Timestamp::as_millisecond)
}

/// The day of an RFC 3339 time in words, with its year where that is not the present one: "12 June", "3 May 2024".
pub fn day_in_words(time: &str) -> String {
    let Some(day) = time.get(..10).and_then(|day| day.parse::<Date>().ok()) else {
        return time.to_owned();
    };
    let this_year = Timestamp::now().to_zoned(TimeZone::UTC).year();
    let form = if day.year() == this_year {
        "%-d %B"
    } else {
        "%-d %B %Y"
    };
    day.strftime(form).to_string()
}

/// Why times of a query mean nothing.
#[derive(Debug, PartialEq, thiserror::Error)]
pub enum TimeError {
    #[error(
        "{name}: '{text}', expected a day such as 2026-05-01 or a time such as 2026-05-01T00:00:00Z"
    )]
    NoTime { name: &'static str, text: String },
    #[error("from: {from} is later than to: {to}")]
    Backwards { from: String, to: String },
}

/// From when on, or until when.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Bound {
    From,
    /// What is before this time. A day is meant with all of its hours.
    To,
}

/// From when on, and until when (ms).
pub fn span(from: Option<&str>, to: Option<&str>) -> Result<(Option<i64>, Option<i64>), TimeError> {
    let begin = from
        .map(|text| parse("from", text, Bound::From))
        .transpose()?;
    let end = to.map(|text| parse("to", text, Bound::To)).transpose()?;
    match (begin.zip(end), from.zip(to)) {
        // What a day ends with is the next one's beginning.
        (Some((begin, end)), Some((from, to))) if begin > end - i64::from(is_day(to)) => {
            let [from, to] = [from, to].map(str::to_owned);
            Err(TimeError::Backwards { from, to })
        }
        _ => Ok((begin, end)),
    }
}

/// Reads RFC 3339, or a day of UTC, as milliseconds.
fn parse(name: &'static str, text: &str, bound: Bound) -> Result<i64, TimeError> {
    let time = text.parse().ok().map(Timestamp::as_millisecond);
    time.or_else(|| day(text, bound)).ok_or_else(|| {
        let text = shown(text);
        TimeError::NoTime { name, text }
    })
}

/// Only a date as RFC 3339 has it: jiff reads times without an offset as dates too.
fn is_day(text: &str) -> bool {
    text.len() == 10
}

/// The beginning or the end of a day. A timestamp of jiff does not reach to the end of the year 9999.
fn day(text: &str, bound: Bound) -> Option<i64> {
    if !is_day(text) {
        return None;
    }
    let day: Date = text.parse().ok()?;
    let begin = i64::try_from(day.duration_since(EPOCH).as_millis()).ok()?;
    Some(match bound {
        Bound::From => begin,
        Bound::To => begin + DAY_MS,
    })
}

/// A time or a day in the API's document.
pub fn schema() -> Schema {
    let of = |format| {
        ObjectBuilder::new()
            .schema_type(Type::String)
            .format(Some(SchemaFormat::KnownFormat(format)))
    };
    let any = AnyOfBuilder::new()
        .item(of(KnownFormat::DateTime))
        .item(of(KnownFormat::Date));
    any.build().into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_day_is_meant_whole() {
        let ms = |text, bound| parse("from", text, bound).ok().map(self::text);
        let [from, to] = [Bound::From, Bound::To].map(|bound| ms("2026-09-01", bound));
        assert_eq!(from.as_deref(), Some("2026-09-01T00:00:00.000Z"));
        assert_eq!(to.as_deref(), Some("2026-09-02T00:00:00.000Z"));
        let time = "2026-09-01T12:00:00.000Z";
        assert_eq!(ms(time, Bound::From).as_deref(), Some(time));
        assert_eq!(ms(time, Bound::To).as_deref(), Some(time));
        for bad in [
            "",
            "yesterday",
            "2026-09",
            "2026-09-31",
            "20260901T0",
            "2026-09-01T12:00",
            "-999-01-01",
        ] {
            assert_eq!(ms(bad, Bound::To), None, "{bad}");
        }
    }

    #[test]
    fn texts_sort_as_times() {
        let texts: Vec<String> = [-1, 0, 1, 10, 100, 250, 999, 1000].map(text).into();
        assert!(texts.is_sorted(), "{texts:?}");
    }

    #[test]
    fn days_are_told_in_words() {
        assert_eq!(day_in_words("2024-05-03T23:00:00Z"), "3 May 2024");
        assert_eq!(day_in_words("soon"), "soon");
        let today = text(Timestamp::now().as_millisecond());
        assert!(!day_in_words(&today).contains(&today[..4]));
    }

    #[test]
    fn every_day_is_one_and_spans_go_forwards() {
        for day in ["0000-01-01", "1969-12-31", "2024-02-29", "9999-12-31"] {
            let whole = span(Some(day), Some(day)).ok();
            let (Some(from), Some(to)) = whole.unwrap_or_default() else {
                panic!("{day}");
            };
            assert_eq!(to - from, DAY_MS, "{day}");
        }
        let refused = |from, to| {
            span(Some(from), Some(to))
                .err()
                .map(|fault| fault.to_string())
        };
        let [day, next, noon] = ["2026-09-01", "2026-09-02", "2026-09-01T12:00:00Z"];
        for (from, to) in [
            (day, day),
            (day, next),
            (day, noon),
            (noon, day),
            (noon, noon),
        ] {
            assert_eq!(refused(from, to), None);
        }
        for (from, to) in [(next, day), ("2026-09-03", day), (next, noon)] {
            let expected = format!("from: {from} is later than to: {to}");
            assert_eq!(refused(from, to), Some(expected));
        }
    }
}
