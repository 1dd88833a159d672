//! Limits how often a loop logs the same warning: at its first turn, then every ten seconds. A library's loops as well.

use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use tracing::callsite::Identifier;
use tracing::{Level, Metadata};

const EVERY: Duration = Duration::from_secs(10);

/// When a warning was logged last.
pub struct Seldom(Mutex<Option<Instant>>);

impl Seldom {
    pub const fn new() -> Self {
        Self(Mutex::new(None))
    }

    /// Whether it is to be logged now.
    pub fn is_due(&self) -> bool {
        self.is_due_at(Instant::now())
    }

    fn is_due_at(&self, now: Instant) -> bool {
        let mut last = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let is_due = last.is_none_or(|last| now.saturating_duration_since(last) >= EVERY);
        if is_due {
            *last = Some(now);
        }
        is_due
    }
}

/// The warnings of a library, by the line of its code that logs them.
#[derive(Default)]
pub struct Callsites(Mutex<HashMap<Identifier, Seldom>>);

impl Callsites {
    /// Whether an event is to be logged: always if it is no warning or error.
    pub fn is_due(&self, metadata: &Metadata<'_>) -> bool {
        if *metadata.level() > Level::WARN || !metadata.is_event() {
            return true;
        }
        let mut lines = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let line = lines.entry(metadata.callsite());
        line.or_insert_with(Seldom::new).is_due()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_warning_is_logged_at_the_first_turn_and_every_ten_seconds() {
        let (said, begin) = (Seldom::new(), Instant::now());
        let turns = (0..250).map(|turn| begin + Duration::from_millis(100 * turn));
        assert_eq!(turns.filter(|turn| said.is_due_at(*turn)).count(), 3);
    }
}
