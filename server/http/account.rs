//! How fast the other side is: what came, or was taken, while somebody waited for it.

use std::pin::Pin;
use std::task::{Context, Poll};
use std::time::Duration;

use tokio::time::{Instant, Sleep};

/// What is waited for.
#[derive(Clone, Copy)]
pub struct Pace {
    pub idle: Duration,
    /// Least rate after that time (bytes/s).
    pub rate: u64,
}

/// Why the other side is not waited for any longer.
#[derive(Clone, Copy, Debug)]
pub enum Slow {
    Idle(Duration),
    Rate {
        bytes: u64,
        waited: Duration,
        rate: u64,
    },
}

impl Slow {
    /// In words: of what, and what should have happened to it.
    pub fn described(&self, what: &str, did: &str) -> String {
        match self {
            Slow::Idle(idle) => format!("no more of {what} {did} for {} s", idle.as_secs()),
            Slow::Rate {
                bytes,
                waited,
                rate,
            } => format!(
                "{bytes} bytes of {what} {did} in {} s, expected at least {rate} bytes/s",
                waited.as_secs()
            ),
        }
    }
}

/// Waits for the other side as long as it keeps its pace.
pub struct Watch {
    pace: Pace,
    account: Account,
    alarm: Option<Pin<Box<Sleep>>>,
}

impl Watch {
    pub fn new(pace: Pace) -> Self {
        Self {
            pace,
            account: Account::default(),
            alarm: None,
        }
    }

    /// Nothing happens just now; why that is not waited for any longer.
    pub fn waits(&mut self, context: &mut Context<'_>) -> Poll<Slow> {
        let until = self.account.waits(self.pace, Instant::now());
        let alarm = self
            .alarm
            .get_or_insert_with(|| Box::pin(tokio::time::sleep_until(until)));
        if alarm.deadline() != until {
            alarm.as_mut().reset(until);
        }
        let idle = self.pace.idle;
        alarm.as_mut().poll(context).map(|()| Slow::Idle(idle))
    }

    /// So many bytes are through.
    pub fn came(&mut self, bytes: usize) -> Result<(), Slow> {
        self.account.came(self.pace, Instant::now(), bytes)
    }
}

/// What the other side did, and how long somebody waited for it, since it was last ahead of its pace by as much as
/// it has to do in `idle`. No more than that counts later: what was fast once does not excuse hours of slowness.
#[derive(Default)]
struct Account {
    bytes: u64,
    waited: Duration,
    /// By how much it was ahead then (bytes).
    ahead: f64,
    /// Since when somebody waits again.
    since: Option<Instant>,
}

impl Account {
    /// Somebody waits; until when it makes sense.
    fn waits(&mut self, pace: Pace, now: Instant) -> Instant {
        *self.since.get_or_insert(now) + pace.idle
    }

    /// So many bytes are through.
    fn came(&mut self, pace: Pace, now: Instant, bytes: usize) -> Result<(), Slow> {
        if let Some(since) = self.since.take() {
            self.waited += now.saturating_duration_since(since);
        }
        self.bytes += bytes as u64;
        let rate = pace.rate as f64;
        let (most, due) = (
            pace.idle.as_secs_f64() * rate,
            self.waited.as_secs_f64() * rate,
        );
        let ahead = self.bytes as f64 + self.ahead - due;
        if ahead >= most {
            *self = Self {
                ahead: most,
                ..Self::default()
            };
        } else if self.waited > pace.idle && ahead < 0.0 {
            return Err(Slow::Rate {
                bytes: self.bytes,
                waited: self.waited,
                rate: pace.rate,
            });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PACE: Pace = Pace {
        idle: Duration::from_secs(30),
        rate: 1000,
    };

    /// Pieces of a body, each so many bytes after so many seconds, to a reader who takes as long for each;
    /// how many came before it was refused.
    fn taken(pieces: &[(u64, usize)], reader_s: u64) -> usize {
        let (mut account, mut now) = (Account::default(), Instant::now());
        let taken = pieces.iter().take_while(|(seconds, bytes)| {
            now += Duration::from_secs(reader_s);
            let until = account.waits(PACE, now);
            now += Duration::from_secs(*seconds);
            now < until && account.came(PACE, now, *bytes).is_ok()
        });
        taken.count()
    }

    #[test]
    fn a_body_that_does_not_come_is_given_up_and_a_slow_one_is_not() {
        assert_eq!(
            taken(&[(20, 21_000); 200], 0),
            200,
            "an hour at a slow rate"
        );
        assert_eq!(taken(&[(1, 10), (31, 10)], 0), 1, "nothing for too long");
        assert_eq!(
            taken(&[(29, 1), (29, 1)], 0),
            1,
            "a byte in time is no progress"
        );
        assert_eq!(taken(&[(5, 4_900); 9], 0), 6, "a rate counts after a while");
        assert_eq!(taken(&[(5, 5_100); 9], 0), 9);
        assert_eq!(
            taken(&[(1, 1000); 99], 60),
            99,
            "it was the reader who was slow"
        );
    }

    #[test]
    fn what_was_fast_once_does_not_excuse_slowness_later() {
        let mut pieces = vec![(1, 10_000_000)];
        pieces.extend([(10, 10); 9]);
        assert_eq!(taken(&pieces, 0), 4);
        pieces.splice(1..1, [(25, 0)]);
        assert_eq!(taken(&pieces, 0), 2, "and a pause is no rate");
        let uneven = [(1, 40_000), (29, 1000)].repeat(20);
        assert_eq!(taken(&uneven, 0), 40, "now fast, now slow");
    }
}
