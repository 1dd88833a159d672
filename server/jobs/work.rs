//! What the stages work with.

use std::sync::Arc;
use std::time::Duration;

use veloid_engine::swarm::Swarm;

use super::cache::RideCache;
use super::compute::Compute;
use super::gate::Gate;
use super::hub::Hub;
use crate::lru::Lru;
use crate::store::Db;
use crate::webhooks::Targets;

/// What the stages work with.
pub struct Work {
    pub db: Db,
    pub rides: RideCache,
    /// What the trials of a job share.
    pub swarms: Lru<Swarm>,
    pub compute: Compute,
    pub gate: Gate,
    pub hub: Hub,
    /// Where others may be told of what ends.
    pub targets: Targets,
    /// Time that one stage may take.
    pub limit: Duration,
}

/// The workers.
#[derive(Clone)]
pub(super) struct Stages(pub(super) Arc<Work>);
