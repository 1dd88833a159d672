//! A request ends with its key. Where the key or the session is revoked or expires, a request that waits gets 401, and an
//! answer that is being sent breaks off.

use std::sync::Arc;
use std::time::Duration;

use axum::BoxError;
use axum::body::{Body, HttpBody};
use axum::response::Response;
use futures_util::{StreamExt, stream};
use tokio_util::task::AbortOnDropHandle;

use crate::api::Server;
use crate::api::access::{Caller, unknown};
use crate::api::problem::Problem;

/// How often a key is looked at.
const LOOK: Duration = Duration::from_millis(800);

#[derive(Debug, thiserror::Error)]
#[error("the key is no longer valid")]
struct Ended;

/// The answer, unless the caller's key ends before it.
pub async fn while_admitted(
    server: &Arc<Server>,
    caller: Caller,
    answer: impl Future<Output = Response>,
) -> Result<Response, Problem> {
    if caller.key.is_none() {
        return Ok(answer.await);
    }
    // Apart from the answer, which is not asked for more while its reader is slow.
    let ended = tokio::spawn(ended(Arc::clone(server), caller));
    let mut ended = AbortOnDropHandle::new(ended);
    let answer = tokio::select! {
        answer = answer => answer,
        _ = &mut ended => return Err(unknown()),
    };
    Ok(match answer.body().size_hint().exact() {
        Some(_) => answer,
        None => breaking_off(answer, ended),
    })
}

/// Returns when the key has ended. It ends in the database, so nothing ends while that is away.
async fn ended(server: Arc<Server>, caller: Caller) {
    loop {
        tokio::time::sleep(LOOK).await;
        if matches!(caller.is_admitted(&server.db).await, Ok(false)) {
            return;
        }
    }
}

/// The answer, whose pieces end with an error once the key has ended.
fn breaking_off(answer: Response, ended: AbortOnDropHandle<()>) -> Response {
    answer.map(|body| {
        let begun = Some((body.into_data_stream(), ended));
        let pieces = stream::unfold(begun, async |state| {
            let (mut pieces, mut ended) = state?;
            tokio::select! {
                biased;
                _ = &mut ended => Some((Err(BoxError::from(Ended)), None)),
                piece = pieces.next() => Some((piece?.map_err(BoxError::from), Some((pieces, ended)))),
            }
        });
        // Compression asks again after the end.
        Body::from_stream(pieces.fuse())
    })
}
