use serde::Serialize;
use serde_json::{Value, json};

use crate::time;

/// What is reported of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    JobSucceeded,
    JobFailed,
    JobCancelled,
    BikeDrifts,
    BikeStepped,
    /// A drift ended, a step was undone, or either is found no longer.
    BikeSettled,
    BikeNewPhysics,
    /// Sent by hand only, to see whether it arrives.
    Test,
}

impl Event {
    /// Those that may be asked for.
    pub const ALL: [Event; 7] = [
        Event::JobSucceeded,
        Event::JobFailed,
        Event::JobCancelled,
        Event::BikeDrifts,
        Event::BikeStepped,
        Event::BikeSettled,
        Event::BikeNewPhysics,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Event::JobSucceeded => "job.succeeded",
            Event::JobFailed => "job.failed",
            Event::JobCancelled => "job.cancelled",
            Event::BikeDrifts => "bike.drifts",
            Event::BikeStepped => "bike.stepped",
            Event::BikeSettled => "bike.settled",
            Event::BikeNewPhysics => "bike.new_physics",
            Event::Test => "test",
        }
    }

    pub fn names() -> Vec<&'static str> {
        Self::ALL.map(Self::name).to_vec()
    }
}

/// What is reported: the body of a message.
#[derive(Serialize)]
pub struct Notification {
    #[serde(rename = "type")]
    kind: &'static str,
    timestamp: String,
    data: Value,
}

impl Notification {
    pub fn new(event: Event, at_ms: i64, data: Value) -> Self {
        Self {
            kind: event.name(),
            timestamp: time::text(at_ms),
            data,
        }
    }

    pub fn test(at_ms: i64) -> Self {
        Self::new(
            Event::Test,
            at_ms,
            json!({"text": "a webhook of veloid works"}),
        )
    }

    pub fn body(&self) -> String {
        serde_json::to_string(self).unwrap_or_default()
    }
}
