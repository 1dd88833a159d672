//! What the pools of both databases have in common.

use std::time::Duration;

use sqlx::Database;
use sqlx::pool::PoolOptions;

pub const ACQUIRE_TIMEOUT: Duration = Duration::from_secs(10);

/// A pool that no task of sqlx's looks after: in sqlx 0.9.0 that task may meet a count of idle connections that has just
/// gone below zero, and then never ends (launchbadge/sqlx issue 3645, mended by pull request 4289 after 0.9.0).
pub fn unmaintained<D: Database>(options: PoolOptions<D>) -> PoolOptions<D> {
    options
        .min_connections(0)
        .idle_timeout(None)
        .max_lifetime(None)
}
