//! Who reads long lists. Each key has a few at a time, and without keys each address: what one's readers hold, however
//! slow they are, is bounded, and nobody waits for another's.

use std::collections::HashMap;
use std::net::IpAddr;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use axum::extract::FromRequestParts;
use axum::http::request::Parts;
use uuid::Uuid;

use super::access::Caller;
use super::problem::{Kind, Problem};
use crate::http::Peer;

/// Long lists of one key at a time: a page's three exports and one more. Each holds about a megabyte: 1000 rows, as
/// they came and as they are sent.
const EACH: usize = 4;
/// Wait that is asked for.
const WAIT: Duration = Duration::from_secs(10);

/// Whose reader it is.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub enum Reader {
    Key(Uuid),
    Address(IpAddr),
}

impl<S: Sync> FromRequestParts<S> for Reader {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Problem> {
        let caller = Caller::from_request_parts(parts, state).await?;
        let peer = parts.extensions.get::<Peer>();
        let address = peer.map(|Peer(address)| Self::Address(*address));
        let reader = caller.key.map(Self::Key).or(address);
        reader.ok_or_else(|| Problem::internal("the origin of a request was not recorded"))
    }
}

/// The readers that there are.
#[derive(Default)]
pub struct LongReaders(Mutex<HashMap<Reader, usize>>);

impl LongReaders {
    /// A place for one more.
    pub fn admit(this: &Arc<Self>, reader: Reader) -> Result<Seat, Problem> {
        let mut counts = this.counts();
        let count = counts.entry(reader).or_default();
        if *count >= EACH {
            let (kind, whose) = match reader {
                Reader::Key(_) => (Kind::TooMany, "the key"),
                Reader::Address(_) => (Kind::Unavailable, "this address"),
            };
            let detail = format!("{whose} is reading {EACH} long lists already, its limit");
            return Err(Problem::new(kind, detail).retry_after(WAIT));
        }
        *count += 1;
        let readers = Arc::clone(this);
        Ok(Seat { readers, reader })
    }

    fn counts(&self) -> MutexGuard<'_, HashMap<Reader, usize>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A reader's place, until it is dropped.
pub struct Seat {
    readers: Arc<LongReaders>,
    reader: Reader,
}

impl Drop for Seat {
    fn drop(&mut self) {
        let mut counts = self.readers.counts();
        if let Some(count) = counts.get_mut(&self.reader) {
            *count -= 1;
            if *count == 0 {
                counts.remove(&self.reader);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_has_its_own_places() {
        let all = Arc::new(LongReaders::default());
        let key = Reader::Key(Uuid::from_u128(1));
        let mut seats: Vec<_> = (0..=EACH).map(|_| LongReaders::admit(&all, key)).collect();
        let refused = seats.pop().and_then(Result::err);
        assert_eq!(refused.map(|problem| problem.status), Some(429));
        let address = Reader::Address([127, 0, 0, 1].into());
        assert!(LongReaders::admit(&all, address).is_ok());
        seats.pop();
        assert!(LongReaders::admit(&all, key).is_ok());
        drop(seats);
        assert!(all.counts().is_empty());
    }
}
