//! What the stages work with.

use std::sync::Arc;
use std::time::Duration;

use super::budget::Budget;
use super::cache::RideCache;
use super::compute::Compute;
use super::gate::Gate;
use super::hub::Hub;
use crate::store::Db;
use crate::webhooks::{Targets, Turns};

/// What the stages work with.
pub struct Work {
    pub db: Db,
    pub rides: RideCache,
    pub compute: Compute,
    /// Memory that one job may take.
    pub budget: Budget,
    pub gate: Gate,
    pub hub: Hub,
    /// Where others may be reported of what ends.
    pub targets: Targets,
    /// Whose messages may be sent now.
    pub turns: Turns,
    /// New rides of a bicycle with which the server studies its latest by itself; 0: never.
    pub study_after: usize,
    /// Time that one stage may take.
    pub limit: Duration,
}

/// The workers.
#[derive(Clone)]
pub(super) struct Stages(pub(super) Arc<Work>);
