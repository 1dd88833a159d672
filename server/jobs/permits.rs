//! Permits to compute, granted in the order of turns (`store/turn.rs`).

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::sync::oneshot;

use super::fault::Fault;

pub struct Permits(Arc<Mutex<State>>);

struct State {
    free: usize,
    /// By turn, then in the order of arrival.
    waiting: BTreeMap<(i64, u64), oneshot::Sender<Permit>>,
    arrived: u64,
}

/// Returned when dropped.
pub struct Permit(Arc<Mutex<State>>);

impl Permits {
    pub fn new(count: usize) -> Self {
        Self(Arc::new(Mutex::new(State {
            free: count,
            waiting: BTreeMap::new(),
            arrived: 0,
        })))
    }

    /// Waits until a permit is free and no lower turn waits for one.
    pub async fn acquire(&self, turn: i64) -> Result<Permit, Fault> {
        let granted = {
            let mut state = lock(&self.0);
            if state.free > 0 {
                state.free -= 1;
                return Ok(Permit(Arc::clone(&self.0)));
            }
            let (grant, granted) = oneshot::channel();
            state.arrived += 1;
            let place = (turn, state.arrived);
            state.waiting.insert(place, grant);
            granted
        };
        granted.await.map_err(|_| Fault::Stopped)
    }

    #[cfg(test)]
    pub fn free(&self) -> usize {
        lock(&self.0).free
    }
}

impl Drop for Permit {
    fn drop(&mut self) {
        let next = {
            let mut state = lock(&self.0);
            let next = state.waiting.pop_first();
            if next.is_none() {
                state.free += 1;
            }
            next
        };
        if let Some((_, grant)) = next {
            // If the receiver is gone, the permit is dropped here and passed on.
            let _ = grant.send(Permit(Arc::clone(&self.0)));
        }
    }
}

fn lock(state: &Mutex<State>) -> MutexGuard<'_, State> {
    state.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use std::future::Future;
    use std::pin::pin;
    use std::task::{Context, Poll, Waker};

    use super::*;

    fn ready<F: Future>(future: std::pin::Pin<&mut F>) -> Option<F::Output> {
        match future.poll(&mut Context::from_waker(Waker::noop())) {
            Poll::Ready(output) => Some(output),
            Poll::Pending => None,
        }
    }

    #[test]
    fn permits_go_to_the_lowest_turn_first() {
        let permits = Permits::new(1);
        let held = ready(pin!(permits.acquire(9)));
        let (mut late, mut early, mut second) = (
            pin!(permits.acquire(7)),
            pin!(permits.acquire(3)),
            pin!(permits.acquire(3)),
        );
        assert!(ready(late.as_mut()).is_none());
        assert!(ready(early.as_mut()).is_none());
        assert!(ready(second.as_mut()).is_none());
        drop(held);
        assert!(ready(late.as_mut()).is_none());
        assert!(ready(second.as_mut()).is_none());
        drop(ready(early).expect("the lowest turn"));
        drop(ready(second).expect("the same turn, arrived later"));
        assert!(ready(late).is_some());
    }

    #[test]
    fn permits_of_cancelled_waiters_are_passed_on() {
        let permits = Permits::new(1);
        let held = ready(pin!(permits.acquire(0)));
        {
            let mut cancelled = pin!(permits.acquire(1));
            assert!(ready(cancelled.as_mut()).is_none());
        }
        let mut granted_unseen = Box::pin(permits.acquire(2));
        assert!(ready(granted_unseen.as_mut()).is_none());
        drop(held);
        drop(granted_unseen);
        assert_eq!(permits.free(), 1);
    }
}
