//! Times at the edge: epoch milliseconds inside, RFC 3339 outside.

use jiff::Timestamp;
use jiff::civil::Date;
use jiff::tz::TimeZone;
use utoipa::openapi::schema::{AnyOfBuilder, ObjectBuilder, Schema, Type};
use utoipa::openapi::{KnownFormat, SchemaFormat};

use super::problem::{Kind, Problem};

/// As RFC 3339 in UTC.
pub fn text(epoch_ms: i64) -> String {
    Timestamp::from_millisecond(epoch_ms).map_or_else(|_| epoch_ms.to_string(), |t| t.to_string())
}

/// From when on, or until when.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Bound {
    From,
    /// What is before this time. A day is meant with all of its hours.
    To,
}

/// Reads RFC 3339, or a day of UTC, as milliseconds.
pub fn parse(name: &str, text: &str, bound: Bound) -> Result<i64, Problem> {
    let time = text
        .parse::<Timestamp>()
        .ok()
        .or_else(|| day(text, bound))
        .map(Timestamp::as_millisecond);
    time.ok_or_else(|| {
        let detail = format!(
            "{name}: '{text}', expected a day such as 2026-05-01 or a time such as 2026-05-01T00:00:00Z"
        );
        Problem::new(Kind::BadRequest, detail)
    })
}

fn day(text: &str, bound: Bound) -> Option<Timestamp> {
    // Only a date as RFC 3339 has it: jiff reads times without an offset as dates too.
    if text.len() != 10 {
        return None;
    }
    let day: Date = text.parse().ok()?;
    let begin = match bound {
        Bound::From => day,
        Bound::To => day.tomorrow().ok()?,
    };
    Some(begin.to_zoned(TimeZone::UTC).ok()?.timestamp())
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
        assert_eq!(from.as_deref(), Some("2026-09-01T00:00:00Z"));
        assert_eq!(to.as_deref(), Some("2026-09-02T00:00:00Z"));
        let time = "2026-09-01T12:00:00Z";
        assert_eq!(ms(time, Bound::From).as_deref(), Some(time));
        assert_eq!(ms(time, Bound::To).as_deref(), Some(time));
        for bad in [
            "",
            "yesterday",
            "2026-09",
            "2026-09-31",
            "20260901T0",
            "2026-09-01T12:00",
            "9999-12-31",
        ] {
            assert_eq!(ms(bad, Bound::To), None, "{bad}");
        }
    }
}
