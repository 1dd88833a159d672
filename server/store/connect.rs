use std::str::FromStr;
use std::time::Duration;

use sqlx::Connection;
use sqlx::postgres::{PgConnectOptions, PgPoolOptions};
use sqlx::sqlite::{SqliteConnectOptions, SqliteJournalMode, SqlitePoolOptions, SqliteSynchronous};

use super::Db;

const BUSY_TIMEOUT: Duration = Duration::from_secs(10);
const ACQUIRE_TIMEOUT: Duration = Duration::from_secs(10);

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

/// Whether an address is that of a PostgreSQL.
pub fn is_postgres(url: &str) -> bool {
    url.starts_with("postgres://") || url.starts_with("postgresql://")
}

impl Db {
    /// Opens `sqlite:FILE` (made when absent) or `postgres://...`.
    pub async fn connect(url: &str) -> sqlx::Result<Db> {
        if is_postgres(url) {
            let options = PgConnectOptions::from_str(url)?.options(SESSION);
            let pool = |most, options| {
                PgPoolOptions::new()
                    .max_connections(most)
                    .acquire_timeout(ACQUIRE_TIMEOUT)
                    .connect_with(options)
            };
            return Ok(Db::Postgres {
                write: pool(WRITERS, options.clone().options([WRITING])).await?,
                read: pool(READERS, options.options([READING])).await?,
            });
        }
        // FULL: a 202 promises that the ride survives a power cut.
        let options = SqliteConnectOptions::from_str(url)?
            .create_if_missing(true)
            .journal_mode(SqliteJournalMode::Wal)
            .synchronous(SqliteSynchronous::Full)
            .busy_timeout(BUSY_TIMEOUT)
            .foreign_keys(true);
        // On a full disk SQLite ends a transaction by itself. sqlx, whose rollback then fails, holds the
        // connection to be in it for ever: such a one is closed, and the pool opens another.
        let write = SqlitePoolOptions::new()
            .max_connections(1)
            .acquire_timeout(ACQUIRE_TIMEOUT)
            .after_release(|connection, _| {
                Box::pin(async move {
                    connection.ping().await?;
                    Ok(!connection.is_in_transaction())
                })
            })
            .connect_with(options.clone())
            .await?;
        let read = SqlitePoolOptions::new()
            .max_connections(8)
            .acquire_timeout(ACQUIRE_TIMEOUT)
            .connect_with(options.read_only(true))
            .await?;
        Ok(Db::Sqlite { write, read })
    }
}
