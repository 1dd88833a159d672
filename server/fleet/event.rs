//! What was done to a bicycle, and which step that may explain.

use serde::Serialize;
use utoipa::ToSchema;
use uuid::Uuid;

use super::development::{Development, Step};
use crate::store::bike_event::EventRow;
use crate::time;

/// An event this many days before a step is near, though there were rides between.
const NEAR: i64 = 7;
const DAY_MS: i64 = 86_400_000;

/// What was done to a bicycle on a day.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct BikeEvent {
    pub id: Uuid,
    /// The day, such as 2026-06-11.
    #[schema(format = Date)]
    pub date: String,
    pub text: String,
    #[serde(skip)]
    day: i64,
}

impl From<EventRow> for BikeEvent {
    fn from(row: EventRow) -> Self {
        Self {
            id: row.id,
            date: time::text(row.day).chars().take(10).collect(),
            text: row.text,
            day: row.day / DAY_MS,
        }
    }
}

/// Says of each step which of the bicycle's events is near.
pub fn beside(development: Option<Development>, events: &[BikeEvent]) -> Option<Development> {
    let mut development = development?;
    for step in &mut development.steps {
        step.event = near(step, events);
    }
    Some(development)
}

/// The event nearest to a step: between its two rides, the day after, or up to a week before.
fn near(step: &Step, events: &[BikeEvent]) -> Option<String> {
    let (since, at) = (day(&step.since)?, day(&step.at)?);
    let events = events.iter().filter(|event| {
        let between = (since..=at + 1).contains(&event.day);
        between || (0..=NEAR).contains(&(at - event.day))
    });
    let nearest = events.min_by_key(|event| ((at - event.day).abs(), -event.day))?;
    let text = &nearest.text;
    Some(match at - nearest.day {
        0 => format!("the day of '{text}'"),
        1 => format!("the day after '{text}'"),
        -1 => format!("the day before '{text}'"),
        _ if nearest.day >= since => {
            let date = time::day_in_words(&nearest.date);
            format!("the first ride after '{text}' on {date}")
        }
        days => format!("{days} days after '{text}'"),
    })
}

fn day(time: &str) -> Option<i64> {
    let ms = time::epoch_ms(time)?;
    Some(ms.div_euclid(DAY_MS))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_names_the_event_that_is_near() {
        let event = |date: &str, text: &str| BikeEvent {
            id: Uuid::nil(),
            date: date.to_owned(),
            text: text.to_owned(),
            day: day(&format!("{date}T00:00:00Z")).unwrap_or_default(),
        };
        let step = Step {
            at: "2024-06-12T10:00:00Z".to_owned(),
            since: "2024-06-03T18:00:00Z".to_owned(),
            size: 1.0,
            std_error: 0.1,
            event: None,
            margin: 0.2,
        };
        for (dates, expected) in [
            (["2024-06-11", "2024-05-01"], Some("the day after 'a'")),
            (["2024-06-12", "2024-06-11"], Some("the day of 'a'")),
            (["2024-06-13", "2023-06-12"], Some("the day before 'a'")),
            (
                ["2024-06-03", "2024-06-14"],
                Some("the first ride after 'a' on 3 June 2024"),
            ),
            (["2024-06-02", "2024-06-20"], None),
        ] {
            let events = [event(dates[0], "a"), event(dates[1], "b")];
            assert_eq!(near(&step, &events).as_deref(), expected, "{dates:?}");
        }
        let daily = Step {
            since: "2024-06-11T00:00:00Z".to_owned(),
            ..step
        };
        let events = [event("2024-06-08", "service")];
        assert_eq!(
            near(&daily, &events).as_deref(),
            Some("4 days after 'service'")
        );
    }
}
