//! Requests' bodies that do not come: nothing for a while, or too little for long, or not before the server
//! stops. Only the time counts in which somebody waits for them.

use std::pin::Pin;
use std::task::{Context, Poll};
use std::time::Duration;

use axum::body::{Bytes, HttpBody};
use http_body::{Frame, SizeHint};
use tokio::time::{Instant, Sleep};
use tokio_util::sync::{CancellationToken, WaitForCancellationFutureOwned};

use super::HttpLimits;

/// What is waited for.
#[derive(Clone, Copy)]
pub struct Pace {
    idle: Duration,
    /// Least rate after that time (bytes/s).
    rate: u64,
}

impl From<&HttpLimits> for Pace {
    fn from(limits: &HttpLimits) -> Self {
        Self {
            idle: limits.body_timeout(),
            rate: limits.body_rate,
        }
    }
}

/// Why a body is not waited for any longer.
#[derive(Clone, Copy, Debug, thiserror::Error)]
pub enum Unfinished {
    #[error("nothing more of the request came for {} s", .0.as_secs())]
    Idle(Duration),
    #[error("{bytes} bytes of the request came in {} s, expected {rate} bytes/s at least", .waited.as_secs())]
    Rate {
        bytes: u64,
        waited: Duration,
        rate: u64,
    },
    #[error("the server stops; send the request again")]
    Stops,
}

/// What came, and how long somebody waited for it.
#[derive(Default)]
struct Account {
    bytes: u64,
    waited: Duration,
    /// Since when somebody waits again.
    since: Option<Instant>,
}

impl Account {
    /// Somebody waits; until when it makes sense.
    fn waits(&mut self, pace: Pace, now: Instant) -> Instant {
        *self.since.get_or_insert(now) + pace.idle
    }

    /// Something came.
    fn came(&mut self, pace: Pace, now: Instant, bytes: usize) -> Result<(), Unfinished> {
        if let Some(since) = self.since.take() {
            self.waited += now.saturating_duration_since(since);
        }
        self.bytes += bytes as u64;
        let least = self.waited.as_secs_f64() * pace.rate as f64;
        if self.waited > pace.idle && (self.bytes as f64) < least {
            return Err(Unfinished::Rate {
                bytes: self.bytes,
                waited: self.waited,
                rate: pace.rate,
            });
        }
        Ok(())
    }
}

/// A body at a pace.
pub struct Paced<B> {
    body: B,
    pace: Pace,
    account: Account,
    alarm: Option<Pin<Box<Sleep>>>,
    fault: Option<Unfinished>,
    stop: CancellationToken,
    stops: Option<Pin<Box<WaitForCancellationFutureOwned>>>,
}

impl<B> Paced<B> {
    /// A body that also ends when the server stops: what has not arrived by then is sent again.
    pub fn new(body: B, pace: Pace, stop: CancellationToken) -> Self {
        Self {
            stop,
            stops: None,
            body,
            pace,
            account: Account::default(),
            alarm: None,
            fault: None,
        }
    }

    /// Nothing has come yet; why it is not waited for any longer.
    fn waits(&mut self, context: &mut Context<'_>) -> Poll<Unfinished> {
        let stop = &self.stop;
        let stops = self
            .stops
            .get_or_insert_with(|| Box::pin(stop.clone().cancelled_owned()));
        if stops.as_mut().poll(context).is_ready() {
            return Poll::Ready(Unfinished::Stops);
        }
        let until = self.account.waits(self.pace, Instant::now());
        let alarm = self
            .alarm
            .get_or_insert_with(|| Box::pin(tokio::time::sleep_until(until)));
        if alarm.deadline() != until {
            alarm.as_mut().reset(until);
        }
        alarm
            .as_mut()
            .poll(context)
            .map(|()| Unfinished::Idle(self.pace.idle))
    }
}

impl<B> HttpBody for Paced<B>
where
    B: HttpBody<Data = Bytes> + Unpin,
    B::Error: Into<axum::BoxError>,
{
    type Data = Bytes;
    type Error = axum::BoxError;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, axum::BoxError>>> {
        let this = &mut *self;
        if this.stop.is_cancelled() && !this.body.is_end_stream() {
            this.fault = Some(Unfinished::Stops);
        }
        if let Some(fault) = this.fault {
            return Poll::Ready(Some(Err(fault.into())));
        }
        let fault = match Pin::new(&mut this.body).poll_frame(context) {
            Poll::Ready(Some(Ok(frame))) => {
                let bytes = frame.data_ref().map_or(0, Bytes::len);
                match this.account.came(this.pace, Instant::now(), bytes) {
                    Ok(()) => return Poll::Ready(Some(Ok(frame))),
                    Err(fault) => fault,
                }
            }
            Poll::Ready(Some(Err(error))) => return Poll::Ready(Some(Err(error.into()))),
            Poll::Ready(None) => return Poll::Ready(None),
            Poll::Pending => match this.waits(context) {
                Poll::Ready(fault) => fault,
                Poll::Pending => return Poll::Pending,
            },
        };
        this.fault = Some(fault);
        Poll::Ready(Some(Err(fault.into())))
    }

    fn is_end_stream(&self) -> bool {
        self.body.is_end_stream()
    }

    fn size_hint(&self) -> SizeHint {
        self.body.size_hint()
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
}
