//! Times at the edge: epoch milliseconds inside, RFC 3339 outside.

use super::problem::{Kind, Problem};

/// As RFC 3339 in UTC.
pub fn text(epoch_ms: i64) -> String {
    jiff::Timestamp::from_millisecond(epoch_ms)
        .map_or_else(|_| epoch_ms.to_string(), |t| t.to_string())
}

/// Reads RFC 3339.
pub fn parse(name: &str, text: &str) -> Result<i64, Problem> {
    text.parse::<jiff::Timestamp>()
        .map(jiff::Timestamp::as_millisecond)
        .map_err(|_| {
            Problem::new(
                Kind::BadRequest,
                format!("{name}: '{text}', expected a time such as 2026-05-01T00:00:00Z"),
            )
        })
}
