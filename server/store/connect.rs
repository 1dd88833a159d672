use std::str::FromStr;
use std::time::Duration;

use sqlx::Connection;
use sqlx::sqlite::{SqliteConnectOptions, SqliteJournalMode, SqlitePoolOptions, SqliteSynchronous};

use super::pool::{ACQUIRE_TIMEOUT, unmaintained};
#[cfg(feature = "postgres")]
use super::postgres;
use super::{Condition, Db};

const BUSY_TIMEOUT: Duration = Duration::from_secs(10);

/// Whether an address is that of a PostgreSQL.
pub fn is_postgres(url: &str) -> bool {
    url.starts_with("postgres://") || url.starts_with("postgresql://")
}

impl Db {
    /// Opens `sqlite:FILE` (made when absent) or `postgres://...`.
    pub async fn connect(url: &str) -> sqlx::Result<Db> {
        #[cfg(feature = "postgres")]
        if is_postgres(url) {
            return postgres::connect(url).await;
        }
        let options = SqliteConnectOptions::from_str(url)?
            .create_if_missing(true)
            .journal_mode(SqliteJournalMode::Wal)
            .synchronous(SqliteSynchronous::Normal)
            .busy_timeout(BUSY_TIMEOUT)
            .foreign_keys(true);
        // A file need not be asked whether it is still there: each time would be a way to SQLite's thread
        // and back.
        let condition = Condition::default();
        let pool = |most| {
            let condition = condition.clone();
            unmaintained(SqlitePoolOptions::new())
                .max_connections(most)
                .acquire_timeout(ACQUIRE_TIMEOUT)
                .test_before_acquire(false)
                .after_connect(move |_, _| {
                    let place = condition.check_place();
                    Box::pin(async { Ok(place?) })
                })
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
            condition,
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
            Db::Sqlite {
                write, read, signs, ..
            } => {
                for pool in [write, read, signs] {
                    is_unmaintained(pool.options());
                }
            }
            #[cfg(feature = "postgres")]
            Db::Postgres {
                write, read, signs, ..
            } => {
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
                for (is_lax, meant) in [(false, 2), (true, 1)] {
                    let tx = match is_lax {
                        true => db.begin_lax().await,
                        false => db.begin().await,
                    };
                    match tx.unwrap() {
                        Tx::Sqlite(mut tx, _) => {
                            assert_eq!(synchronous(&mut tx).await, meant);
                            tx.commit().await.unwrap();
                        }
                        #[cfg(feature = "postgres")]
                        Tx::Postgres(..) => {}
                    }
                }
            }
        })
        .await;
    }
}
