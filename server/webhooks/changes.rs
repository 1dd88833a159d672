//! What is new about a bicycle.

use serde_json::{Value, json};

use super::event::Event;
use crate::fleet::{BikeHistory, Course, Development};

/// Something new, and what is to be remembered of it as reported: axle, name and kind.
pub struct Change {
    pub event: Option<Event>,
    pub axle: String,
    pub name: String,
    pub kind: String,
    pub data: Value,
}

/// Parameters of which another thing is to be said than was said last: `reported` holds axle, name and kind.
pub fn of(history: &BikeHistory, reported: &[(String, String, String)]) -> Vec<Change> {
    let courses = history.courses.iter();
    let changes = courses.flat_map(|course| {
        let mut known = reported.iter();
        let own = known.find(|(axle, name, _)| *axle == course.axle && *name == course.name);
        let before = own.map_or(Counts::default(), |(_, _, kind)| Counts::read(kind));
        of_course(&history.bike, course, before)
    });
    changes.collect()
}

fn of_course(bike: &str, course: &Course, before: Counts) -> Vec<Change> {
    let Some(development) = &course.development else {
        return Vec::new();
    };
    let now = Counts::of(development);
    if now == before {
        return Vec::new();
    }
    let data = json!({
        "bike": bike, "axle": course.axle, "name": course.name, "unit": course.unit, "development": development,
        "pooled": course.pooled,
    });
    let mut events: Vec<Option<Event>> = now.events_since(before).map(Some).collect();
    if events.is_empty() {
        // What is found no longer is remembered, so that it may come again.
        events.push(None);
    }
    let change = |event| Change {
        event,
        axle: course.axle.clone(),
        name: course.name.clone(),
        kind: now.text(),
        data: data.clone(),
    };
    events.into_iter().map(change).collect()
}

/// Drifts that began, steps that last, and what is over: drifts that ended, steps that were undone.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Counts {
    drifts: usize,
    steps: usize,
    over: usize,
}

/// Standard errors up to which two steps undo each other.
const UNDONE: f64 = 2.0;

impl Counts {
    fn of(development: &Development) -> Self {
        let ended = development.drifts.iter().filter(|d| d.until.is_some());
        let undone = development.steps.windows(2).filter(|pair| {
            let error = pair[0].std_error.hypot(pair[1].std_error);
            (pair[0].size + pair[1].size).abs() < UNDONE * error
        });
        let undone = undone.count();
        Self {
            drifts: development.drifts.len(),
            steps: development.steps.len() - undone,
            over: ended.count() + undone,
        }
    }

    /// What was kept, by earlier versions as a word.
    fn read(kind: &str) -> Self {
        let [drifts, steps, over] = match kind {
            "drift" => [1, 0, 0],
            "step" => [0, 1, 0],
            "both" => [1, 1, 0],
            kind => {
                let mut numbers = kind.split(' ').map(|n| n.parse().unwrap_or(0));
                std::array::from_fn(|_| numbers.next().unwrap_or(0))
            }
        };
        Self {
            drifts,
            steps,
            over,
        }
    }

    fn text(self) -> String {
        format!("{} {} {}", self.drifts, self.steps, self.over)
    }

    /// One message each of what is new; that something is over also where it is found no longer.
    fn events_since(self, before: Self) -> impl Iterator<Item = Event> {
        let began = self.drifts > before.drifts;
        let stepped = self.steps > before.steps;
        let vanished =
            !began && !stepped && self.drifts + self.steps < before.drifts + before.steps;
        let events = [
            (began, Event::BikeDrifts),
            (stepped, Event::BikeStepped),
            (self.over > before.over || vanished, Event::BikeSettled),
        ];
        events
            .into_iter()
            .filter(|(is_new, _)| *is_new)
            .map(|(_, event)| event)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changes_are_reported_once_and_so_is_their_end() {
        let events = |before: &str, [drifts, steps, over]: [usize; 3]| -> Vec<Event> {
            let now = Counts {
                drifts,
                steps,
                over,
            };
            assert_eq!(Counts::read(&now.text()), now);
            now.events_since(Counts::read(before)).collect()
        };
        let (drifts, stepped, settled) =
            (Event::BikeDrifts, Event::BikeStepped, Event::BikeSettled);
        assert_eq!(events("none", [0, 0, 0]), []);
        assert_eq!(events("none", [1, 0, 0]), [drifts]);
        assert_eq!(events("drift", [1, 0, 0]), []);
        assert_eq!(events("1 0 0", [1, 1, 1]), [stepped, settled]);
        assert_eq!(events("1 1 1", [2, 1, 1]), [drifts]);
        assert_eq!(events("both", [1, 1, 1]), [settled]);
        assert_eq!(events("1 0 0", [0, 1, 0]), [stepped]);
        assert_eq!(events("1 0 0", [0, 0, 0]), [settled]);
        assert_eq!(events("0 1 0", [0, 0, 1]), [settled]);
    }
}
