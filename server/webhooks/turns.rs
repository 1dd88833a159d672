//! Which message may be sent now. A host has one connection at a time, however many groups send to it. A group leaves it
//! free for as long as an attempt took, and after attempts without an answer for longer each time. No group has more
//! connections than it leaves to the others. What is counted here is counted by each process for itself.

use std::collections::HashMap;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use url::Url;

/// Connections at a time.
pub const CONNECTIONS: usize = 16;
/// A message waits so long for its turn before it is put off.
const PATIENCE: Duration = Duration::from_secs(1);
/// How often it looks whether the host is free.
const LOOK: Duration = Duration::from_millis(20);
/// Messages that are put off for the same reason come back so far apart.
const APART: Duration = Duration::from_millis(100);
/// What an attempt without an answer counts as having taken, at least, and the longest pause after it.
const LEAST: Duration = Duration::from_secs(1);
const LONGEST: Duration = Duration::from_secs(600);
/// Receivers whose pauses are known; beyond it all are forgotten.
const RECEIVERS: usize = 10_000;

/// A group's messages to one host.
#[derive(Clone, PartialEq, Eq, Hash)]
pub struct Receiver {
    group: String,
    host: String,
}

impl Receiver {
    pub fn new(group: &str, url: &str) -> Self {
        let url = Url::parse(url).ok();
        let host = url.as_ref().and_then(Url::host_str).unwrap_or_default();
        Self {
            group: group.to_owned(),
            host: host.trim_end_matches('.').to_owned(),
        }
    }
}

#[derive(Default)]
pub struct Turns(Mutex<State>);

#[derive(Default)]
struct State {
    open: Vec<(Receiver, Instant)>,
    pauses: HashMap<Receiver, Pause>,
}

struct Pause {
    until: Instant,
    /// When the last message that was put off comes back.
    line: Instant,
    /// Attempts without an answer since the last one that had one.
    silences: u32,
}

impl Turns {
    /// Waits for the receiver's turn for a moment; else for how long the message is put off.
    pub async fn take(&self, receiver: Receiver) -> Result<Turn<'_>, Duration> {
        let patience = Instant::now() + PATIENCE;
        loop {
            let now = Instant::now();
            let wait = match self.state().begin(&receiver, now) {
                Ok(()) => return Ok(Turn::new(self, receiver)),
                Err(wait) => wait,
            };
            if now + wait >= patience {
                return Err(self.state().put_off(&receiver, wait, now));
            }
            tokio::time::sleep(wait).await;
        }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Leave to send, for as long as it is held.
pub struct Turn<'a> {
    turns: &'a Turns,
    receiver: Receiver,
    is_silent: bool,
}

impl<'a> Turn<'a> {
    fn new(turns: &'a Turns, receiver: Receiver) -> Self {
        Self {
            turns,
            receiver,
            is_silent: false,
        }
    }

    /// Ends it.
    pub fn end(mut self, is_silent: bool) {
        self.is_silent = is_silent;
    }
}

impl Drop for Turn<'_> {
    fn drop(&mut self) {
        let mut state = self.turns.state();
        state.end(&self.receiver, self.is_silent, Instant::now());
    }
}

impl State {
    /// Begins an attempt, or says when to ask again.
    fn begin(&mut self, receiver: &Receiver, now: Instant) -> Result<(), Duration> {
        if let Some(pause) = self.pauses.get(receiver).filter(|pause| pause.until > now) {
            return Err((pause.until - now).max(LOOK));
        }
        let busy = self.open.iter().find(|(r, _)| r.host == receiver.host);
        if let Some((_, since)) = busy {
            // A host that has been busy for long may be so for longer.
            let is_long = now - *since >= PATIENCE;
            return Err(if is_long { PATIENCE } else { LOOK });
        }
        let own = self.open.iter().filter(|(r, _)| r.group == receiver.group);
        if own.count() >= CONNECTIONS - self.open.len() {
            return Err(PATIENCE);
        }
        self.open.push((receiver.clone(), now));
        Ok(())
    }

    fn end(&mut self, receiver: &Receiver, is_silent: bool, now: Instant) {
        let Some(place) = self.open.iter().position(|(r, _)| r == receiver) else {
            return;
        };
        let (_, since) = self.open.swap_remove(place);
        let took = now - since;
        let pause = self.pause(receiver, now);
        if is_silent {
            pause.silences = pause.silences.saturating_add(1);
            let factor = 1_u32.checked_shl(pause.silences).unwrap_or(u32::MAX);
            pause.until = now + took.max(LEAST).saturating_mul(factor).min(LONGEST);
        } else {
            pause.silences = 0;
            pause.until = now + took;
        }
    }

    fn put_off(&mut self, receiver: &Receiver, wait: Duration, now: Instant) -> Duration {
        let pause = self.pause(receiver, now);
        pause.line = pause.line.max(now + wait) + APART;
        pause.line - now
    }

    fn pause(&mut self, receiver: &Receiver, now: Instant) -> &mut Pause {
        if self.pauses.len() >= RECEIVERS && !self.pauses.contains_key(receiver) {
            self.pauses.clear();
        }
        let none = Pause {
            until: now,
            line: now,
            silences: 0,
        };
        self.pauses.entry(receiver.clone()).or_insert(none)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn receiver(group: &str, host: usize) -> Receiver {
        Receiver::new(group, &format!("https://host-{host}.example./hook"))
    }

    #[test]
    fn a_host_has_one_connection_and_a_group_leaves_some_to_others() {
        let (mut state, now) = (State::default(), Instant::now());
        let begun = |state: &mut State, group: &str, hosts: std::ops::Range<usize>| {
            hosts
                .filter(|host| state.begin(&receiver(group, *host), now).is_ok())
                .count()
        };
        assert_eq!(begun(&mut state, "a", 0..1), 1);
        assert_eq!(begun(&mut state, "b", 0..1), 0, "the host is busy");
        assert_eq!(begun(&mut state, "a", 1..100), CONNECTIONS / 2 - 1);
        assert_eq!(begun(&mut state, "b", 100..200), CONNECTIONS / 4);
        assert_eq!(begun(&mut state, "c", 200..300), CONNECTIONS / 8);
        state.end(&receiver("a", 0), false, now);
        assert_eq!(begun(&mut state, "d", 0..1), 1);
    }

    #[test]
    fn pauses_grow_until_there_is_an_answer() {
        let (mut state, mut now) = (State::default(), Instant::now());
        let (receiver, other) = (receiver("a", 0), receiver("b", 0));
        let mut pauses = Vec::new();
        for is_silent in [true, true, true, true, true, true, true, false, true] {
            assert_eq!(state.begin(&receiver, now), Ok(()));
            now += Duration::from_secs(10);
            state.end(&receiver, is_silent, now);
            let pause = state.begin(&receiver, now).err().unwrap_or_default();
            pauses.push(pause.as_secs());
            assert_eq!(state.begin(&other, now), Ok(()), "another group's");
            state.end(&other, false, now);
            now += pause;
        }
        assert_eq!(pauses, [20, 40, 80, 160, 320, 600, 600, 10, 20]);
    }

    #[test]
    fn what_is_put_off_comes_back_one_by_one() {
        let (mut state, now) = (State::default(), Instant::now());
        let waits: Vec<_> = (0..3)
            .map(|_| state.put_off(&receiver("a", 0), PATIENCE, now).as_millis())
            .collect();
        assert_eq!(waits, [1100, 1200, 1300]);
        for host in 0..RECEIVERS + 10 {
            state.put_off(&receiver("a", host), PATIENCE, now);
        }
        assert!(state.pauses.len() <= RECEIVERS);
    }
}
