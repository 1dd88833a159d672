//! Connections to PostgreSQL, which many processes share.

use std::str::FromStr;
use std::time::Duration;

use sqlx::Connection;
use sqlx::postgres::{PgConnectOptions, PgPoolOptions};

use super::pool::{ACQUIRE_TIMEOUT, unmaintained};
use super::{Condition, Db, nodelay};

/// A connection that has rested for so long is asked whether its PostgreSQL is still there.
const RESTED: Duration = Duration::from_secs(1);

/// Connections of one process to PostgreSQL; one more listens for the queue.
const WRITERS: u32 = 8;
const READERS: u32 = 4;

/// A process that is cut off in the middle of a transaction must not hold its locks for longer than
/// others wait before they take its work over.
const SESSION: [(&str, &str); 5] = [
    ("idle_in_transaction_session_timeout", "8s"),
    ("tcp_user_timeout", "8s"),
    ("tcp_keepalives_idle", "4"),
    ("tcp_keepalives_interval", "2"),
    ("tcp_keepalives_count", "2"),
];
/// Longest statement of those who change things, and of those who only look.
const WRITING: (&str, &str) = ("statement_timeout", "60s");
const READING: (&str, &str) = ("statement_timeout", "10s");

pub async fn connect(url: &str) -> sqlx::Result<Db> {
    let options = PgConnectOptions::from_str(url)?.options(SESSION);
    let port = options.get_port();
    let pool = |most| {
        unmaintained(PgPoolOptions::new())
            .max_connections(most)
            .acquire_timeout(ACQUIRE_TIMEOUT)
            .test_before_acquire(false)
            .after_connect(move |_, _| {
                nodelay::send_at_once(port);
                Box::pin(async { Ok(()) })
            })
            .before_acquire(|connection, rest| {
                Box::pin(async move {
                    if rest.idle_for > RESTED {
                        connection.ping().await?;
                    }
                    Ok(true)
                })
            })
    };
    let reading = options.clone().options([READING]);
    Ok(Db::Postgres {
        write: pool(WRITERS)
            .connect_with(options.options([WRITING]))
            .await?,
        read: pool(READERS).connect_with(reading.clone()).await?,
        signs: pool(1).connect_lazy_with(reading),
        condition: Condition::default(),
    })
}
