//! The order in which files are read. Of the groups with waiting requests, the one with the fewest seats is next, and among these
//! the one whose last turn is longest ago; a group never has all seats. Within a group a file of n MB lets the n requests after
//! it go first, so small files overtake large ones, but no file waits for ever.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::sync::oneshot;

use super::fault::Fault;

/// Files that are read, and so lie in memory, at the same time.
pub const SEATS: usize = 3;
/// Of these, how many one group may have.
const OF_A_GROUP: usize = 2;
/// Of these, how many large files may have.
const OF_LARGE: usize = 2;
/// Size from which a file is large (bytes).
const LARGE: u64 = 8 << 20;
/// Requests of one group that may wait.
const WAITING: usize = 128;
const MB: u64 = 1_000_000;

/// What a file is read for.
#[derive(Clone, Copy)]
pub enum Purpose {
    Request,
    /// Goes before the requests of its group, since it has had its turn in the queue of jobs, and is never refused.
    Job,
}

#[derive(Default)]
pub struct Seats(Mutex<State>);

#[derive(Default)]
struct State {
    /// Requests and turns so far.
    count: u64,
    /// Those that have a seat or wait for one.
    groups: HashMap<String, Group>,
}

#[derive(Default)]
struct Group {
    seats: usize,
    /// Seats with large files.
    large: usize,
    /// Count at its last turn; at its arrival if it has had none.
    since: u64,
    waiting: Vec<Waiting>,
}

struct Waiting {
    rank: (u64, u64),
    large: bool,
    /// Closed once the request is abandoned.
    seat: oneshot::Sender<Seat>,
}

impl Seats {
    /// A seat to read files of so many bytes. Dropped before its end, it leaves its place.
    pub async fn take(
        this: &Arc<Self>,
        group: &str,
        bytes: u64,
        purpose: Purpose,
    ) -> Result<Seat, Fault> {
        let (send, seat) = oneshot::channel();
        this.state().enter(group, bytes, purpose, send)?;
        Self::fill(this);
        seat.await.map_err(|_| Fault::Stopped)
    }

    /// Gives the free seats to those whose turn it is.
    fn fill(this: &Arc<Self>) {
        while let Some((group, waiting)) = this.next() {
            let seat = Seat {
                seats: Arc::clone(this),
                group,
                large: waiting.large,
            };
            // An abandoned request drops the seat, which frees it.
            let _ = waiting.seat.send(seat);
        }
    }

    fn next(&self) -> Option<(String, Waiting)> {
        self.state().next()
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    fn enter(
        &mut self,
        group: &str,
        bytes: u64,
        purpose: Purpose,
        seat: oneshot::Sender<Seat>,
    ) -> Result<(), Fault> {
        self.forget_abandoned();
        self.count += 1;
        let count = self.count;
        let group = (self.groups.entry(group.to_owned())).or_insert_with(|| Group {
            since: count,
            ..Group::default()
        });
        let rank = match purpose {
            Purpose::Request if group.waiting.len() >= WAITING => {
                return Err(Fault::Crowded(WAITING));
            }
            Purpose::Request => (count + bytes / MB, count),
            Purpose::Job => (0, count),
        };
        group.waiting.push(Waiting {
            rank,
            large: bytes >= LARGE,
            seat,
        });
        Ok(())
    }

    /// The request whose turn it is, with its group, if there is a seat for it; the seat is counted.
    fn next(&mut self) -> Option<(String, Waiting)> {
        self.forget_abandoned();
        let sum = |of: fn(&Group) -> usize| self.groups.values().map(of).sum::<usize>();
        if sum(|group| group.seats) >= SEATS {
            return None;
        }
        let no_large = sum(|group| group.large) >= OF_LARGE;
        let (name, group) = (self.groups.iter_mut())
            .filter(|(_, group)| group.seats < OF_A_GROUP && group.first(no_large).is_some())
            .min_by_key(|(_, group)| (group.seats, group.since))?;
        let first = group.first(no_large)?;
        let waiting = group.waiting.swap_remove(first);
        self.count += 1;
        group.since = self.count;
        group.seats += 1;
        group.large += usize::from(waiting.large);
        Some((name.clone(), waiting))
    }

    fn forget_abandoned(&mut self) {
        self.groups.retain(|_, group| {
            group.waiting.retain(|waiting| !waiting.seat.is_closed());
            group.seats > 0 || !group.waiting.is_empty()
        });
    }
}

impl Group {
    /// Index of the waiting request that goes first.
    fn first(&self, no_large: bool) -> Option<usize> {
        (self.waiting.iter().enumerate())
            .filter(|(_, waiting)| !(waiting.large && no_large))
            .min_by_key(|(_, waiting)| waiting.rank)
            .map(|(index, _)| index)
    }
}

/// The right to read files, until it is dropped.
pub struct Seat {
    seats: Arc<Seats>,
    group: String,
    large: bool,
}

impl Drop for Seat {
    fn drop(&mut self) {
        if let Some(group) = self.seats.state().groups.get_mut(&self.group) {
            group.seats -= 1;
            group.large -= usize::from(self.large);
        }
        Seats::fill(&self.seats);
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::future::ready;
    use std::pin::Pin;

    use futures_util::FutureExt;

    use super::*;

    const SMALL: u64 = 1000;
    const HUGE: u64 = 95 * MB;

    type Asked = (
        &'static str,
        Pin<Box<dyn Future<Output = Result<Seat, Fault>>>>,
    );

    /// Enters requests, each by its name `group:what`, in this order.
    async fn enter(seats: &Arc<Seats>, asked: &[(&'static str, u64)]) -> Vec<Asked> {
        let mut entered = Vec::new();
        for (name, bytes) in asked {
            let (seats, bytes) = (Arc::clone(seats), *bytes);
            let group = name.split(':').next().unwrap();
            let purpose = match name.ends_with("job") {
                true => Purpose::Job,
                false => Purpose::Request,
            };
            let take = async move { Seats::take(&seats, group, bytes, purpose).await };
            let mut asked: Asked = (name, Box::pin(take));
            // The first poll enters it; a seat that it got is kept for `seated`.
            if let Some(taken) = (&mut asked.1).now_or_never() {
                asked.1 = Box::pin(ready(taken));
            }
            entered.push(asked);
        }
        entered
    }

    /// Takes out the requests that have a seat now, with their seats.
    async fn seated(entered: &mut Vec<Asked>) -> Vec<(&'static str, Seat)> {
        let mut seated = Vec::new();
        for (name, mut asked) in std::mem::take(entered) {
            match (&mut asked).now_or_never() {
                Some(seat) => seated.push((name, seat.unwrap())),
                None => entered.push((name, asked)),
            }
        }
        seated
    }

    /// The order in which all are served, one seat given back at a time, the oldest first.
    async fn order(entered: &mut Vec<Asked>) -> Vec<&'static str> {
        let (mut served, mut order) = (seated(entered).await, Vec::new());
        while !served.is_empty() {
            let (name, seat) = served.remove(0);
            order.push(name);
            drop(seat);
            served.extend(seated(entered).await);
        }
        order
    }

    #[tokio::test]
    async fn groups_take_turns_and_none_has_every_seat() {
        let seats = Arc::default();
        let many = [
            ("many:1", SMALL),
            ("many:2", SMALL),
            ("many:3", SMALL),
            ("many:4", SMALL),
        ];
        let few = [("few:1", SMALL), ("few:2", SMALL), ("one:1", SMALL)];
        let mut entered = enter(&seats, &[&many[..], &few].concat()).await;
        let first = seated(&mut entered).await;
        let names: Vec<_> = first.iter().map(|(name, _)| *name).collect();
        assert_eq!(names, ["many:1", "many:2", "few:1"]);
        let mut first = first.into_iter();
        drop(first.next());
        let next = seated(&mut entered).await;
        assert_eq!(next[0].0, "one:1", "it has no seat, the others have one");
        drop(next);
        let next = seated(&mut entered).await;
        assert_eq!(next[0].0, "many:3", "its last turn is longest ago");
        drop(next);
        assert_eq!(order(&mut entered).await, ["few:2", "many:4"]);
        drop(first);
        assert!(seats.state().groups.values().all(|group| group.seats == 0));
    }

    #[tokio::test]
    async fn within_a_group_small_files_go_first_and_large_ones_wait_for_no_more_than_their_size() {
        let seats = Arc::default();
        let hold = [("a:1", SMALL), ("a:2", SMALL)];
        let mut entered = enter(&seats, &hold).await;
        let mut held = seated(&mut entered).await;
        let asked = [
            ("a:9 MB", 9 * MB),
            ("a:small", SMALL),
            ("a:job", HUGE),
            ("a:small too", SMALL),
        ];
        entered = enter(&seats, &asked).await;
        for _ in 0..9 {
            entered.extend(enter(&seats, &[("a:later", SMALL)]).await);
        }
        held.pop();
        let order = order(&mut entered).await;
        assert_eq!(order[..3], ["a:job", "a:small", "a:small too"]);
        let large = order.iter().position(|name| *name == "a:9 MB");
        assert!(large.unwrap() < order.len() - 1, "{order:?}");
    }

    #[tokio::test]
    async fn large_files_leave_a_seat_to_small_ones() {
        let seats = Arc::default();
        let asked = [("a:1", HUGE), ("b:1", HUGE), ("c:1", HUGE), ("d:1", SMALL)];
        let mut entered = enter(&seats, &asked).await;
        let first = seated(&mut entered).await;
        let names: Vec<_> = first.iter().map(|(name, _)| *name).collect();
        assert_eq!(names, ["a:1", "b:1", "d:1"]);
    }

    #[tokio::test]
    async fn a_group_may_wait_with_so_many_and_the_abandoned_do_not_count() {
        let seats: Arc<Seats> = Arc::default();
        let asked = vec![("a:1", SMALL); OF_A_GROUP + WAITING];
        let entered = enter(&seats, &asked).await;
        let take = |group| Seats::take(&seats, group, SMALL, Purpose::Request);
        let refused = take("a").await.map(drop);
        assert!(matches!(refused, Err(Fault::Crowded(WAITING))));
        let mut job = enter(&seats, &[("a:job", SMALL)]).await;
        assert!(take("b").await.is_ok());
        drop(entered);
        assert_eq!(seated(&mut job).await.len(), 1);
        assert!(take("a").await.is_ok());
        assert!(seats.state().groups.values().all(|group| group.seats == 0));
    }
}
