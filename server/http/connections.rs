//! Who is connected. Beyond a bound, whoever has waited longest without asking for anything makes room:
//! connections that are only held open cost nobody the answer.

use std::collections::{BTreeMap, HashMap};
use std::net::IpAddr;
use std::pin::Pin;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll};

use axum::body::{Body, Bytes, HttpBody};
use http_body::{Frame, SizeHint};
use tokio_util::sync::CancellationToken;

use super::HttpLimits;

/// Connections beyond the bound, of one address and of all, that are only good for signs of life.
const SPARE_OF_ONE: usize = 2;
const SPARE: usize = 64;

pub struct Connections {
    most: usize,
    of_one: usize,
    is_spare: bool,
    table: Mutex<Table>,
}

#[derive(Default)]
struct Table {
    open: usize,
    of: HashMap<IpAddr, usize>,
    /// Those that ask for nothing, by when they began to wait.
    waiting: BTreeMap<u64, (IpAddr, CancellationToken)>,
    next: u64,
}

impl Table {
    fn waits(&mut self, address: IpAddr, gone: CancellationToken) -> u64 {
        self.next += 1;
        self.waiting.insert(self.next, (address, gone));
        self.next
    }

    /// Ends the connection that has waited longest, of this address or of any; false if all are asking.
    fn makes_room(&mut self, address: Option<IpAddr>) -> bool {
        let is_of = |of: &IpAddr| address.is_none_or(|address| address == *of);
        let found = self.waiting.iter().find(|(_, (of, _))| is_of(of));
        let Some(since) = found.map(|(since, _)| *since) else {
            return false;
        };
        if let Some((_, gone)) = self.waiting.remove(&since) {
            gone.cancel();
        }
        true
    }
}

impl Connections {
    pub fn new(limits: &HttpLimits) -> Self {
        Self {
            most: limits.connections,
            of_one: limits.per_address(),
            is_spare: false,
            table: Mutex::default(),
        }
    }

    /// Those beside them that are kept for signs of life: an address whose connections all wait for answers still
    /// learns whether the server lives.
    pub fn spare() -> Self {
        Self {
            most: SPARE,
            of_one: SPARE_OF_ONE,
            is_spare: true,
            table: Mutex::default(),
        }
    }

    /// A seat for one more connection, unless all that there are for it are in use.
    pub fn admit(this: &Arc<Self>, address: IpAddr) -> Option<Seat> {
        let mut table = this.table();
        let of_one = table.of.get(&address).copied().unwrap_or_default();
        if of_one >= this.of_one && !table.makes_room(Some(address)) {
            return None;
        }
        // Who has just made room for its own address has left already.
        if of_one < this.of_one && table.open >= this.most && !table.makes_room(None) {
            return None;
        }
        table.open += 1;
        *table.of.entry(address).or_default() += 1;
        let gone = CancellationToken::new();
        let since = table.waits(address, gone.clone());
        Some(Seat {
            connections: Arc::clone(this),
            address,
            since: AtomicU64::new(since),
            gone,
        })
    }

    fn table(&self) -> MutexGuard<'_, Table> {
        self.table.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A connection's place among the others.
pub struct Seat {
    connections: Arc<Connections>,
    address: IpAddr,
    since: AtomicU64,
    gone: CancellationToken,
}

impl Seat {
    /// Ends when the connection has to make room.
    pub fn gone(&self) -> CancellationToken {
        self.gone.clone()
    }

    /// Whether it is one of those that are kept for signs of life.
    pub fn is_spare(&self) -> bool {
        self.connections.is_spare
    }

    /// A request has come.
    pub fn asks(&self) {
        let since = self.since.load(Ordering::Relaxed);
        self.connections.table().waiting.remove(&since);
    }

    /// It is answered.
    fn waits(&self) {
        let mut table = self.connections.table();
        let since = table.waits(self.address, self.gone.clone());
        self.since.store(since, Ordering::Relaxed);
    }
}

impl Drop for Seat {
    fn drop(&mut self) {
        self.asks();
        let mut table = self.connections.table();
        table.open -= 1;
        if let Some(count) = table.of.get_mut(&self.address) {
            *count -= 1;
            if *count == 0 {
                table.of.remove(&self.address);
            }
        }
    }
}

/// An answer; once it is sent, the connection waits again.
pub struct Held {
    body: Body,
    seat: Arc<Seat>,
}

impl Held {
    pub fn new(body: Body, seat: Arc<Seat>) -> Self {
        Self { body, seat }
    }
}

impl Drop for Held {
    fn drop(&mut self) {
        self.seat.waits();
    }
}

impl HttpBody for Held {
    type Data = Bytes;
    type Error = axum::Error;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, axum::Error>>> {
        Pin::new(&mut self.body).poll_frame(context)
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

    fn connections(most: usize, of_one: usize) -> Arc<Connections> {
        let mut limits = HttpLimits::default();
        (limits.connections, limits.connections_per_address) = (most, Some(of_one));
        Arc::new(Connections::new(&limits))
    }

    fn gone(seats: &[Option<Seat>]) -> Vec<bool> {
        let gone = |seat: &Option<Seat>| seat.as_ref().is_none_or(|seat| seat.gone.is_cancelled());
        seats.iter().map(gone).collect()
    }

    #[test]
    fn who_asks_for_nothing_makes_room_for_who_comes() {
        let (a, b) = ([127, 0, 0, 1].into(), [127, 0, 0, 2].into());
        let all = connections(3, 2);
        let mut seats = vec![Connections::admit(&all, a), Connections::admit(&all, a)];
        assert_eq!(gone(&seats), [false, false]);
        if let Some(first) = &seats[0] {
            first.asks();
        }
        seats.push(Connections::admit(&all, a));
        assert_eq!(
            gone(&seats),
            [false, true, false],
            "the share of one address"
        );
        seats.remove(1);
        seats.push(Connections::admit(&all, b));
        assert_eq!(gone(&seats), [false, false, false]);
        seats.push(Connections::admit(&all, b));
        assert_eq!(gone(&seats), [false, true, false, false], "all seats");
        seats.remove(1);

        for seat in seats.iter().flatten() {
            seat.asks();
        }
        assert!(Connections::admit(&all, b).is_none(), "all are asking");
        if let Some(first) = &seats[0] {
            first.waits();
        }
        assert!(
            Connections::admit(&all, b).is_none(),
            "its own share is in use"
        );
        assert!(Connections::admit(&all, [127, 0, 0, 3].into()).is_some());
        assert_eq!(gone(&seats), [true, false, false]);
        drop(seats);
        let table = all.table();
        assert!(table.open == 0 && table.of.is_empty() && table.waiting.is_empty());
    }
}
