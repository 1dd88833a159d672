//! Who listens to a job hears here what this process does with it. Nothing depends on it: listeners
//! also look at the database from time to time, where other processes leave their results.

use std::collections::{BTreeMap, HashMap, VecDeque};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use serde::{Deserialize, Serialize};
use tokio::sync::broadcast;
use utoipa::ToSchema;
use uuid::Uuid;

use crate::store::now_ms;

/// Events kept for listeners that come back; older ones are covered by a snapshot.
const HISTORY: usize = 4096;

/// A swarm iteration is done.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Iteration {
    pub trial: usize,
    pub iteration: usize,
    pub best_cost: f64,
}

/// How far the search for missing physics is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Searched {
    /// Integrator steps taken.
    pub steps: u64,
    /// Integrator steps that it may take; most searches need a part of them.
    pub budget: u64,
}

/// What a computation reports while it runs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Heard {
    Iteration(Iteration),
    Searched(Searched),
}

#[derive(Clone, Debug, PartialEq)]
pub enum HubEvent {
    Iteration {
        id: u64,
        iteration: Iteration,
    },
    Searched(Searched),
    /// The job's row changed.
    Changed,
}

#[derive(Clone)]
pub struct Hub {
    /// Start of this process: event ids of another process mean nothing here.
    epoch: i64,
    jobs: Arc<Mutex<HashMap<Uuid, Channel>>>,
}

struct Channel {
    sender: broadcast::Sender<HubEvent>,
    history: VecDeque<(u64, Iteration)>,
    curves: BTreeMap<usize, Vec<f64>>,
    searched: Option<Searched>,
    last_id: u64,
}

/// What a listener gets: what it missed, and what comes.
pub struct Subscription {
    pub receiver: broadcast::Receiver<HubEvent>,
    /// Iterations after the given id; none where they are no longer known, so that only a snapshot helps.
    pub missed: Option<Vec<(u64, Iteration)>>,
    /// Best cost so far of the trials that this process runs.
    pub curves: BTreeMap<usize, Vec<f64>>,
    pub searched: Option<Searched>,
    pub last_id: u64,
}

impl Hub {
    pub fn new() -> Self {
        Self {
            epoch: now_ms(),
            jobs: Arc::default(),
        }
    }

    /// Text of an event id, to come back with as `Last-Event-ID`.
    pub fn event_id(&self, id: u64) -> String {
        format!("{}-{id}", self.epoch)
    }

    /// The id in a `Last-Event-ID` of this process.
    pub fn parse_event_id(&self, text: &str) -> Option<u64> {
        let (epoch, id) = text.split_once('-')?;
        (epoch.parse() == Ok(self.epoch)).then(|| id.parse().ok())?
    }

    pub fn iteration(&self, job: Uuid, iteration: Iteration) {
        let mut jobs = self.lock();
        let Some(channel) = jobs.get_mut(&job) else {
            return;
        };
        channel.last_id += 1;
        let id = channel.last_id;
        channel
            .curves
            .entry(iteration.trial)
            .or_default()
            .push(iteration.best_cost);
        channel.history.push_back((id, iteration));
        if channel.history.len() > HISTORY {
            channel.history.pop_front();
        }
        let _ = channel.sender.send(HubEvent::Iteration { id, iteration });
    }

    pub fn searched(&self, job: Uuid, searched: Searched) {
        if let Some(channel) = self.lock().get_mut(&job) {
            channel.searched = Some(searched);
            let _ = channel.sender.send(HubEvent::Searched(searched));
        }
    }

    /// A trial begins, perhaps again: from here on its iterations are kept.
    pub fn open(&self, job: Uuid, trial: usize) {
        let mut jobs = self.lock();
        let channel = jobs.entry(job).or_insert_with(Channel::new);
        channel.curves.remove(&trial);
    }

    /// The job's row has changed.
    pub fn changed(&self, job: Uuid) {
        if let Some(channel) = self.lock().get(&job) {
            let _ = channel.sender.send(HubEvent::Changed);
        }
    }

    /// The job is at its end: its listeners hear so, and what was kept for them goes.
    pub fn close(&self, job: Uuid) {
        if let Some(channel) = self.lock().remove(&job) {
            let _ = channel.sender.send(HubEvent::Changed);
        }
    }

    pub fn subscribe(&self, job: Uuid, after: Option<u64>) -> Subscription {
        let mut jobs = self.lock();
        // Listeners that left jobs of other processes behind.
        jobs.retain(|_, c| !c.history.is_empty() || c.sender.receiver_count() > 0);
        let channel = jobs.entry(job).or_insert_with(Channel::new);
        let oldest = channel.last_id - channel.history.len() as u64;
        let missed = after
            .filter(|id| (oldest..=channel.last_id).contains(id))
            .map(|after| {
                channel
                    .history
                    .iter()
                    .filter(|(id, _)| *id > after)
                    .copied()
                    .collect()
            });
        Subscription {
            receiver: channel.sender.subscribe(),
            missed,
            curves: channel.curves.clone(),
            searched: channel.searched,
            last_id: channel.last_id,
        }
    }

    fn lock(&self) -> MutexGuard<'_, HashMap<Uuid, Channel>> {
        self.jobs.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Channel {
    fn new() -> Self {
        Self {
            sender: broadcast::channel(256).0,
            history: VecDeque::new(),
            curves: BTreeMap::new(),
            searched: None,
            last_id: 0,
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn iteration(iteration: usize) -> Iteration {
        Iteration {
            trial: 0,
            iteration,
            best_cost: 1.0,
        }
    }

    #[test]
    fn a_listener_that_comes_back_misses_nothing_that_is_kept() {
        let (hub, job) = (Hub::new(), Uuid::now_v7());
        hub.open(job, 0);
        for i in 0..5 {
            hub.iteration(job, iteration(i));
        }
        let last = hub.parse_event_id(&hub.event_id(3)).unwrap();
        let missed = hub.subscribe(job, Some(last)).missed.unwrap();
        assert_eq!(missed, vec![(4, iteration(3)), (5, iteration(4))]);
        assert_eq!(hub.subscribe(job, None).curves[&0].len(), 5);
    }

    #[test]
    fn ids_that_are_forgotten_or_foreign_ask_for_a_snapshot() {
        let (hub, job) = (Hub::new(), Uuid::now_v7());
        hub.open(job, 0);
        for i in 0..HISTORY + 2 {
            hub.iteration(job, iteration(i));
        }
        assert!(hub.subscribe(job, Some(1)).missed.is_none());
        assert!(hub.subscribe(job, Some(2)).missed.is_some());
        assert!(hub.subscribe(job, Some(1 << 40)).missed.is_none());
        assert_eq!(hub.parse_event_id("7-3"), None);
    }

    #[tokio::test]
    async fn how_far_a_search_is_is_reported_to_those_who_listen_and_to_those_who_come() {
        let (hub, job) = (Hub::new(), Uuid::now_v7());
        let mut receiver = hub.subscribe(job, None).receiver;
        let searched = Searched {
            steps: 3,
            budget: 10,
        };
        hub.searched(job, searched);
        assert_eq!(receiver.recv().await, Ok(HubEvent::Searched(searched)));
        assert_eq!(hub.subscribe(job, None).searched, Some(searched));
    }

    #[tokio::test]
    async fn closing_tells_listeners() {
        let (hub, job) = (Hub::new(), Uuid::now_v7());
        let mut receiver = hub.subscribe(job, None).receiver;
        hub.close(job);
        assert_eq!(receiver.recv().await.unwrap(), HubEvent::Changed);
        assert!(receiver.recv().await.is_err());
    }
}
