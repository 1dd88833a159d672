//! HTTP on a socket: `axum::serve` with bounds on what strangers may hold open. See docs/security.md.

mod account;
mod connections;
mod limits;
mod pace;
mod taken;

use std::convert::Infallible;
use std::net::IpAddr;
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use axum::body::Body;
use hyper::Request;
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper::service::{Service, service_fn};
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use socket2::SockRef;
use tokio::net::{TcpListener, TcpStream};
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

pub use self::limits::HttpLimits;
pub use self::pace::Unfinished;

use self::connections::{Connections, Held, Seat};
use self::pace::Paced;
use self::taken::Taken;

use crate::metrics::METRICS;
use crate::seldom::Seldom;

/// What is read of a request before it is understood (bytes): a line of 64 KiB, which is the longest that
/// hyper takes, and as much of headers.
const HEAD: usize = 128 << 10;
/// Wait before another connection is taken after one could not be, most likely for want of a descriptor.
const PAUSE: Duration = Duration::from_millis(100);
static NOT_ACCEPTED: Seldom = Seldom::new();

/// What the system holds of an answer that is not on its way yet (bytes). It takes megabytes unless asked otherwise, and
/// more only when a third of them have left: whether a slow reader takes anything could not be seen.
const UNSENT: u32 = 64 << 10;

/// Address from which a request came.
#[derive(Clone, Copy)]
pub struct Peer(pub IpAddr);

/// Marks a request on a connection that is kept for signs of life, because all others are waiting for answers.
#[derive(Clone, Copy)]
pub struct Spare;

/// Serves until it is asked to stop, and then until the answers in progress are sent.
pub async fn serve(
    listener: TcpListener,
    router: Router,
    limits: HttpLimits,
    stop: CancellationToken,
) {
    let connections = Arc::new(Connections::new(&limits));
    let spare = Arc::new(Connections::spare());
    let answers = TaskTracker::new();
    while let Some(accepted) = stop.run_until_cancelled(listener.accept()).await {
        let (stream, peer) = match accepted {
            Ok(accepted) => accepted,
            Err(error) => {
                if NOT_ACCEPTED.is_due() {
                    tracing::warn!(%error, "a connection was not accepted");
                }
                tokio::time::sleep(PAUSE).await;
                continue;
            }
        };
        let seat = Connections::admit(&connections, peer.ip());
        match seat.or_else(|| Connections::admit(&spare, peer.ip())) {
            Some(seat) => {
                let router = router.clone();
                answers.spawn(answer(
                    stream,
                    peer.ip(),
                    seat,
                    router,
                    limits,
                    stop.clone(),
                ));
            }
            None => {
                METRICS.connections_refused.add(1, []);
            }
        }
    }
    drop(listener);
    answers.close();
    answers.wait().await;
}

/// Answers what comes on one connection.
async fn answer(
    stream: TcpStream,
    peer: IpAddr,
    seat: Seat,
    router: Router,
    limits: HttpLimits,
    stop: CancellationToken,
) {
    if let Err(error) = SockRef::from(&stream).set_tcp_notsent_lowat(UNSENT) {
        tracing::debug!(%error, "unsent bytes of a connection are not bounded");
    }
    let (seat, router) = (Arc::new(seat), TowerToHyperService::new(router));
    let (gone, is_spare) = (seat.gone(), seat.is_spare());
    let (pace, answers) = (limits.body(), limits.answer());
    let stops = stop.clone();
    let service = service_fn(move |mut request: Request<Incoming>| {
        seat.asks();
        request.extensions_mut().insert(Peer(peer));
        if is_spare {
            request.extensions_mut().insert(Spare);
        }
        let seat = Arc::clone(&seat);
        let paced = |body| Body::new(Paced::new(body, pace, stops.clone()));
        let response = router.call(request.map(paced));
        async move {
            let response = response.await?;
            Ok::<_, Infallible>(response.map(|body| Held::new(body, seat)))
        }
    });
    let connection = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(limits.header_timeout())
        .max_buf_size(HEAD)
        .keep_alive(!is_spare)
        .serve_connection(TokioIo::new(Taken::new(stream, answers)), service);
    let mut connection = std::pin::pin!(connection);
    let ended = tokio::select! {
        ended = connection.as_mut() => ended,
        () = gone.cancelled() => return,
        () = stop.cancelled() => {
            connection.as_mut().graceful_shutdown();
            connection.await
        }
    };
    if let Err(error) = ended {
        tracing::debug!(%error, "connection");
    }
}
