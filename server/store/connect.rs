use std::str::FromStr;
use std::time::Duration;

use sqlx::pool::PoolOptions;
use sqlx::postgres::{PgConnectOptions, PgPoolOptions};
use sqlx::sqlite::{SqliteConnectOptions, SqliteJournalMode, SqlitePoolOptions, SqliteSynchronous};
use sqlx::{Connection, Database};

use super::{Db, nodelay};

const BUSY_TIMEOUT: Duration = Duration::from_secs(10);
const ACQUIRE_TIMEOUT: Duration = Duration::from_secs(10);
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

/// Whether an address is that of a PostgreSQL.
pub fn is_postgres(url: &str) -> bool {
    url.starts_with("postgres://") || url.starts_with("postgresql://")
}

/// A pool that no task of sqlx's looks after: in sqlx 0.9.0 that task may meet a count of idle connections that has just
/// gone below zero, and then never ends (launchbadge/sqlx issue 3645, mended by pull request 4289 after 0.9.0).
fn unmaintained<D: Database>(options: PoolOptions<D>) -> PoolOptions<D> {
    options
        .min_connections(0)
        .idle_timeout(None)
        .max_lifetime(None)
}

impl Db {
    /// Opens `sqlite:FILE` (made when absent) or `postgres://...`.
    pub async fn connect(url: &str) -> sqlx::Result<Db> {
        if is_postgres(url) {
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
            return Ok(Db::Postgres {
                write: pool(WRITERS)
                    .connect_with(options.options([WRITING]))
                    .await?,
                read: pool(READERS).connect_with(reading.clone()).await?,
                signs: pool(1).connect_lazy_with(reading),
            });
        }
        let options = SqliteConnectOptions::from_str(url)?
            .create_if_missing(true)
            .journal_mode(SqliteJournalMode::Wal)
            .synchronous(SqliteSynchronous::Normal)
            .busy_timeout(BUSY_TIMEOUT)
            .foreign_keys(true);
        // A file need not be asked whether it is still there: each time would be a way to SQLite's thread
        // and back.
        let pool = |most| {
            unmaintained(SqlitePoolOptions::new())
                .max_connections(most)
                .acquire_timeout(ACQUIRE_TIMEOUT)
                .test_before_acquire(false)
        };
        // On a full disk SQLite ends a transaction by itself. sqlx, whose rollback then fails, holds the
        // connection to be in it for ever: such a one is closed, and the pool opens another.
        let write = pool(1)
            .after_release(|connection, _| {
                Box::pin(async move {
                    if connection.is_in_transaction() {
                        // Behind the rollback.
                        connection.ping().await?;
                    }
                    Ok(!connection.is_in_transaction())
                })
            })
            .connect_with(options.clone())
            .await?;
        let reading = options.read_only(true);
        Ok(Db::Sqlite {
            write,
            read: pool(8).connect_with(reading.clone()).await?,
            signs: pool(1).connect_lazy_with(reading),
        })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use sqlx::pool::PoolOptions;
    use sqlx::{Database, Sqlite, Transaction};

    use crate::conformance::on_each_empty;
    use crate::store::{Db, Tx};

    /// What SQLite calls 1, NORMAL, or 2, FULL.
    async fn synchronous(tx: &mut Transaction<'static, Sqlite>) -> i64 {
        let asked = sqlx::query_scalar("PRAGMA synchronous");
        asked.fetch_one(&mut **tx).await.unwrap()
    }

    fn is_unmaintained<D: Database>(options: &PoolOptions<D>) {
        assert_eq!(options.get_min_connections(), 0);
        assert_eq!(options.get_idle_timeout(), None);
        assert_eq!(options.get_max_lifetime(), None);
    }

    /// sqlx's task that looks after a pool begins where one of these is set.
    #[tokio::test]
    async fn no_task_looks_after_a_pool() {
        on_each_empty(async |db| match &db {
            Db::Sqlite { write, read, signs } => {
                for pool in [write, read, signs] {
                    is_unmaintained(pool.options());
                }
            }
            Db::Postgres { write, read, signs } => {
                for pool in [write, read, signs] {
                    is_unmaintained(pool.options());
                }
            }
        })
        .await;
    }

    #[tokio::test]
    async fn commits_wait_for_the_disk_unless_they_are_lax() {
        on_each_empty(async |db| {
            for _ in 0..2 {
                let Tx::Sqlite(mut synced) = db.begin().await.unwrap() else {
                    return;
                };
                assert_eq!(synchronous(&mut synced).await, 2);
                synced.commit().await.unwrap();
                let Tx::Sqlite(mut lax) = db.begin_lax().await.unwrap() else {
                    return;
                };
                assert_eq!(synchronous(&mut lax).await, 1);
            }
        })
        .await;
    }
}
