//! The HTTP API: one file per route, folders by noun. The handlers' documentation is the API's
//! documentation, served as `/openapi.json` and committed as `openapi/openapi.json`.

pub mod access;
pub mod audit;
pub mod bikes;
pub mod dependence;
pub mod extract;
pub mod fleet;
pub mod health;
pub mod jobs;
pub mod known;
pub mod list;
pub mod long_readers;
pub mod names;
mod parameter_view;
pub mod parameters;
pub mod pressure;
pub mod problem;
pub mod rides;
pub mod signs;
pub mod studies;
pub mod validations;
pub mod webhooks;

use std::sync::Arc;
use tokio_util::sync::CancellationToken;

use self::access::Access;
use self::long_readers::LongReaders;
use crate::erasure::Policy;
use crate::files::Files;
use crate::jobs::{Hub, Queue, Readers, RideCache};
use crate::store::Db;
use crate::webhooks::Targets;

/// What the handlers share.
pub struct Server {
    pub db: Db,
    pub files: Files,
    pub rides: RideCache,
    pub queue: Queue,
    pub hub: Hub,
    /// Who reads uploads and draws what came of them.
    pub readers: Arc<Readers>,
    /// Who reads long lists.
    pub long_readers: Arc<LongReaders>,
    pub signs: signs::Signs,
    /// Largest upload (bytes).
    pub max_upload: u64,
    pub access: Access,
    /// For how long what is kept.
    pub policy: Policy,
    /// Where webhooks may go.
    pub targets: Targets,
    /// Ends long answers when the server stops.
    pub stop: CancellationToken,
}

pub type App = axum::extract::State<Arc<Server>>;
