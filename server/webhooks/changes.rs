//! What is new about a bicycle.

use serde_json::{Value, json};

use super::event::Event;
use crate::fleet::{BikeHistory, Course, Kind};

/// Something new, and what is to be remembered of it as reported: axle, name and kind.
pub struct Change {
    pub event: Option<Event>,
    pub axle: String,
    pub name: String,
    pub kind: &'static str,
    pub data: Value,
}

/// Parameters of which another thing is to be said than was said last: `reported` holds axle, name and kind.
pub fn of(history: &BikeHistory, reported: &[(String, String, String)]) -> Vec<Change> {
    let courses = history.courses.iter();
    courses
        .flat_map(|course| of_course(&history.bike, course, reported))
        .collect()
}

fn of_course(bike: &str, course: &Course, reported: &[(String, String, String)]) -> Vec<Change> {
    let Some(development) = &course.development else {
        return Vec::new();
    };
    let own = reported
        .iter()
        .find(|(axle, name, _)| *axle == course.axle && *name == course.name);
    let before = own.map_or("none", |(_, _, kind)| kind.as_str());
    let kind = name(development.kind);
    if kind == before {
        return Vec::new();
    }
    let data = json!({
        "bike": bike, "axle": course.axle, "name": course.name, "unit": course.unit, "development": development,
        "pooled": course.pooled,
    });
    let holds = |kind: &str, what: &str| kind == what || kind == "both";
    let new = |what: &str| holds(kind, what) && !holds(before, what);
    let events = [("drift", Event::BikeDrifts), ("step", Event::BikeStepped)];
    let events: Vec<Event> = events
        .into_iter()
        .filter(|(what, _)| new(what))
        .map(|(_, event)| event)
        .collect();
    let change = |event: Option<Event>| Change {
        event,
        axle: course.axle.clone(),
        name: course.name.clone(),
        kind,
        data: data.clone(),
    };
    match events.is_empty() {
        // What ended is remembered, so that it may start again.
        true => vec![change(None)],
        false => events
            .into_iter()
            .map(|event| change(Some(event)))
            .collect(),
    }
}

fn name(kind: Kind) -> &'static str {
    match kind {
        Kind::None => "none",
        Kind::Drift => "drift",
        Kind::Step => "step",
        Kind::Both => "both",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fleet::Development;

    fn history(kind: Kind) -> BikeHistory {
        let course = Course {
            axle: "front".to_owned(),
            name: "k_n_m".to_owned(),
            unit: "N/m".to_owned(),
            points: Vec::new(),
            pooled: None,
            trend: None,
            change: None,
            development: Some(Development {
                kind,
                per_day: -1.0,
                per_day_std_error: 0.1,
                per_day_margin: 0.2,
                at: None,
                step: 0.0,
                steps: Vec::new(),
            }),
        };
        BikeHistory {
            effects: Vec::new(),
            events: Vec::new(),
            bike: "lab-7".to_owned(),
            courses: vec![course],
        }
    }

    #[test]
    fn a_change_is_reported_once_and_again_when_it_came_back() {
        let events = |kind, reported: &[(&str, &str)]| -> Vec<Option<Event>> {
            let reported: Vec<_> = reported
                .iter()
                .map(|(name, kind)| ("front".to_owned(), (*name).to_owned(), (*kind).to_owned()))
                .collect();
            of(&history(kind), &reported)
                .iter()
                .map(|change| change.event)
                .collect()
        };
        let (drifts, stepped) = (Some(Event::BikeDrifts), Some(Event::BikeStepped));
        assert_eq!(events(Kind::None, &[]), []);
        assert_eq!(events(Kind::Drift, &[]), [drifts]);
        assert_eq!(events(Kind::Drift, &[("b_n_s_m", "drift")]), [drifts]);
        assert_eq!(events(Kind::Drift, &[("k_n_m", "drift")]), []);
        assert_eq!(events(Kind::Both, &[("k_n_m", "drift")]), [stepped]);
        assert_eq!(events(Kind::Both, &[]), [drifts, stepped]);
        assert_eq!(events(Kind::Step, &[("k_n_m", "both")]), [None]);
        assert_eq!(events(Kind::None, &[("k_n_m", "step")]), [None]);
    }
}
