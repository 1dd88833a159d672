//! Requests' bodies that do not come: nothing for a while, or too little for long, or not before the server
//! stops. Only the time counts in which somebody waits for them.

use std::pin::Pin;
use std::task::{Context, Poll};

use axum::body::{Bytes, HttpBody};
use http_body::{Frame, SizeHint};
use tokio_util::sync::{CancellationToken, WaitForCancellationFutureOwned};

use super::account::{Pace, Slow, Watch};

/// Why a body is not waited for any longer.
#[derive(Clone, Copy, Debug, thiserror::Error)]
pub enum Unfinished {
    #[error("{}", .0.described("the request", "arrived"))]
    Slow(Slow),
    #[error("the server is stopping; send the request again")]
    Stops,
}

/// A body at a pace.
pub struct Paced<B> {
    body: B,
    watch: Watch,
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
            watch: Watch::new(pace),
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
        self.watch.waits(context).map(Unfinished::Slow)
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
                match this.watch.came(bytes) {
                    Ok(()) => return Poll::Ready(Some(Ok(frame))),
                    Err(slow) => Unfinished::Slow(slow),
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
