//! A socket whose other side has to take what is sent to it: not at all for a while, or too little for long, and the
//! connection ends. Only the time counts in which the system has no room for more, so that silence of the server's
//! own, as between events, costs nobody a connection.

use std::io::{self, ErrorKind, IoSlice};
use std::pin::Pin;
use std::task::{Context, Poll, ready};

use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};

use super::account::{Pace, Watch};

use crate::metrics::METRICS;

/// A socket, or what stands for one.
pub struct Taken<S> {
    socket: S,
    watch: Watch,
}

impl<S> Taken<S> {
    pub fn new(socket: S, pace: Pace) -> Self {
        Self {
            socket,
            watch: Watch::new(pace),
        }
    }

    /// What became of a piece that was offered to the socket.
    fn offered(
        &mut self,
        context: &mut Context<'_>,
        written: Poll<io::Result<usize>>,
    ) -> Poll<io::Result<usize>> {
        let slow = match written {
            Poll::Ready(Ok(bytes)) => match self.watch.came(bytes) {
                Ok(()) => return Poll::Ready(Ok(bytes)),
                Err(slow) => slow,
            },
            Poll::Ready(Err(error)) => return Poll::Ready(Err(error)),
            Poll::Pending => ready!(self.watch.waits(context)),
        };
        METRICS.answers_cut.add(1, []);
        let why = slow.described("an answer", "was read");
        tracing::info!(%why, "a connection was closed");
        Poll::Ready(Err(io::Error::new(ErrorKind::TimedOut, why)))
    }
}

impl<S: AsyncRead + Unpin> AsyncRead for Taken<S> {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        Pin::new(&mut self.socket).poll_read(context, buffer)
    }
}

impl<S: AsyncWrite + Unpin> AsyncWrite for Taken<S> {
    fn poll_write(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        let written = Pin::new(&mut self.socket).poll_write(context, bytes);
        self.offered(context, written)
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        pieces: &[IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        let written = Pin::new(&mut self.socket).poll_write_vectored(context, pieces);
        self.offered(context, written)
    }

    fn is_write_vectored(&self) -> bool {
        self.socket.is_write_vectored()
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.socket).poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.socket).poll_shutdown(context)
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use tokio::io::{AsyncReadExt, AsyncWriteExt, DuplexStream};

    use super::*;

    /// A server's end, and a client's, with room for 100 bytes between them.
    fn pair() -> (Taken<DuplexStream>, DuplexStream) {
        let (server, client) = tokio::io::duplex(100);
        let pace = Pace {
            idle: Duration::from_millis(10),
            rate: 1_000_000,
        };
        (Taken::new(server, pace), client)
    }

    #[tokio::test]
    async fn who_does_not_take_an_answer_is_cut_off() {
        let (mut server, client) = pair();
        let cut = server.write_all(&[0; 1000]).await;
        let kind = cut.as_ref().map_err(io::Error::kind).err();
        assert_eq!(kind, Some(ErrorKind::TimedOut), "{cut:?}");
        drop(client);
    }

    #[tokio::test]
    async fn silence_of_the_server_counts_for_nothing() -> io::Result<()> {
        let (mut server, mut client) = pair();
        let mut heard = [0; 9];
        for _ in 0..10 {
            tokio::time::sleep(Duration::from_millis(20)).await;
            server.write_all(b"data: 1\n\n").await?;
            client.read_exact(&mut heard).await?;
        }
        Ok(())
    }
}
