use axum::Json;
use axum::body::Bytes;
use axum::extract::State;
use axum::http::StatusCode;
use jiff::Timestamp;
use jiff::civil::Date;
use jiff::tz::TimeZone;
use serde::Deserialize;
use utoipa::ToSchema;
use uuid::Uuid;
use veloid_engine::unseen;

use crate::api::App;
use crate::api::Server;
use crate::api::access::Caller;
use crate::api::bikes::existing;
use crate::api::extract::Path;
use crate::api::problem::{Kind, Problem};
use crate::fleet::BikeEvent;
use crate::store::audit;
use crate::store::bike_event::{self, EventRow};
use crate::unique::{Unique, shown};

/// Most events of a bicycle, and most characters of one.
const MOST: i64 = 500;
const LONGEST: usize = 100;
/// Clocks and time zones differ by so much (ms).
const DAY_MS: i64 = 86_400_000;

/// An event to be noted.
#[derive(Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct NewBikeEvent {
    /// The day, such as 2026-06-11; not in the future.
    #[schema(format = Date)]
    pub date: String,
    /// What was done, such as `new tyre`.
    #[schema(min_length = 1, max_length = 100)]
    pub text: String,
}

/// Notes what was done to a bicycle.
///
/// Events are marks in its history, and a step near one names it. They are deleted, brought back and erased with the bicycle.
#[utoipa::path(post, path = "/v1/bikes/{bike}/events", operation_id = "create_bike_event", tag = "fleet",
    params(("bike" = String, Path, min_length = 1)), request_body = NewBikeEvent,
    responses(
        (status = 201, description = "Noted", body = BikeEvent),
        (status = 400, description = "No day, or no text", body = Problem, content_type = "application/problem+json"),
        (status = 404, description = "No such bike", body = Problem, content_type = "application/problem+json"),
        (status = 409, description = "The bike has 500 events, the most", body = Problem, content_type = "application/problem+json")))]
pub async fn create(
    State(server): App,
    caller: Caller,
    Path(bike): Path<String>,
    body: Bytes,
) -> Result<(StatusCode, Json<BikeEvent>), Problem> {
    // Before the body is read, so that other groups cannot see that the bike exists.
    existing(&server, &caller.group, &bike).await?;
    let malformed = |error: serde_json::Error| bad(format!("the body: {error}"));
    let Unique(document) = serde_json::from_slice(&body).map_err(malformed)?;
    let new = serde_json::from_value(document).map_err(malformed)?;
    let event = note(&server, &caller, bike, &new).await?;
    Ok((StatusCode::CREATED, Json(event)))
}

/// Adds an event to a bicycle of the caller's group.
pub async fn note(
    server: &Server,
    caller: &Caller,
    bike: String,
    new: &NewBikeEvent,
) -> Result<BikeEvent, Problem> {
    let missing = || Problem::not_found("the bike");
    // No name holds a NUL, and PostgreSQL refuses to be asked for one.
    if bike.contains('\0') {
        return Err(missing());
    }
    let row = EventRow {
        id: Uuid::now_v7(),
        day: day(&new.date)?,
        text: text(&new.text)?,
        bike,
    };
    let (group, mut tx) = (&caller.group, server.db.begin().await?);
    if bike_event::count(&mut tx, group, &row.bike).await? >= MOST {
        let detail = format!("the bike has {MOST} events, the most");
        return Err(Problem::new(Kind::WrongState, detail));
    }
    if !bike_event::insert(&mut tx, group, &row).await? {
        return Err(missing());
    }
    let subject = format!("event {} of bike {}", row.id, row.bike);
    audit::note(&mut tx, group, caller.actor(), "create", &subject).await?;
    tx.commit().await?;
    Ok(row.into())
}

/// The beginning of a day (epoch ms, UTC).
fn day(text: &str) -> Result<i64, Problem> {
    let text = text.trim();
    let day = Some(text).filter(|text| text.len() == 10);
    let day = day.and_then(|text| text.parse::<Date>().ok());
    let begin = day.and_then(|day| day.to_zoned(TimeZone::UTC).ok());
    let begin = begin.map(|day| day.timestamp().as_millisecond());
    match begin {
        None => {
            let text = shown(text);
            Err(bad(format!(
                "date: '{text}', expected a day such as 2026-06-11"
            )))
        }
        Some(begin) if begin > Timestamp::now().as_millisecond() + DAY_MS => {
            Err(bad(format!("date: {text}, which is in the future")))
        }
        Some(begin) => Ok(begin),
    }
}

fn text(text: &str) -> Result<String, Problem> {
    let text = text.trim();
    let length = text.chars().count();
    if !(1..=LONGEST).contains(&length) {
        return Err(bad(format!(
            "text: {length} characters, expected 1 to {LONGEST}"
        )));
    }
    match unseen(text).next() {
        Some(found) => {
            let code = u32::from(found);
            Err(bad(format!(
                "text: U+{code:04X}, expected characters that can be seen"
            )))
        }
        None => Ok(text.to_owned()),
    }
}

fn bad(detail: String) -> Problem {
    Problem::new(Kind::BadRequest, detail)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn days_and_texts_are_read_or_refused() {
        assert_eq!(day(" 1970-01-02 ").unwrap(), DAY_MS);
        for wrong in [
            "",
            "yesterday",
            "2026-02-30",
            "2026-06-11T10:00:00Z",
            "2999-01-01",
        ] {
            assert!(
                day(wrong).unwrap_err().detail.starts_with("date: "),
                "{wrong}"
            );
        }
        assert_eq!(text(" new tyre ").unwrap(), "new tyre");
        for wrong in ["", "  ", "a\nb", "\u{202e}x", &"x".repeat(101)] {
            assert!(
                text(wrong).unwrap_err().detail.starts_with("text: "),
                "{wrong}"
            );
        }
    }
}
