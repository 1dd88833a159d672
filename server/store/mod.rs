//! SQL, in one place per table. The same text runs on SQLite and PostgreSQL: `$1` placeholders, ids
//! as UUID, times as epoch milliseconds, documents as JSON. Functions that write take a [`Tx`],
//! functions that only read take the [`Db`].

/// Runs a body once per driver: `on!(read db, p => ...)` with the pool that reads, `on!(tx, t => ...)`
/// with the transaction.
macro_rules! on {
    (read $db:expr, $p:ident => $body:expr) => {
        match $db {
            $crate::store::Db::Sqlite { read: $p, .. } => $body,
            #[cfg(feature = "postgres")]
            $crate::store::Db::Postgres { read: $p, .. } => $body,
        }
    };
    (signs $db:expr, $p:ident => $body:expr) => {
        match $db {
            $crate::store::Db::Sqlite { signs: $p, .. } => $body,
            #[cfg(feature = "postgres")]
            $crate::store::Db::Postgres { signs: $p, .. } => $body,
        }
    };
    ($tx:expr, $t:ident => $body:expr) => {
        match $tx {
            $crate::store::Tx::Sqlite($t, _) => $body,
            #[cfg(feature = "postgres")]
            $crate::store::Tx::Postgres($t, _) => $body,
        }
    };
}
pub(crate) use on;

/// The condition that a job identifies one ride and is the newest of those that succeeded for this ride and bicycle.
macro_rules! newest_of_ride {
    () => {
        "job.study IS NULL \
         AND NOT EXISTS (SELECT 1 FROM job AS newer \
                         WHERE newer.ride_id = job.ride_id AND newer.id > job.id AND newer.bike = job.bike \
                           AND newer.study IS NULL AND newer.state = 'succeeded' AND newer.deleted_at IS NULL)"
    };
}

pub mod audit;
pub mod bike;
pub mod bike_event;
mod condition;
mod connect;
pub mod deletion;
pub mod dependence;
pub mod erased_file;
pub mod facts;
pub mod idempotency_key;
pub mod installation;
pub mod job;
pub mod key;
pub mod loss;
mod migrate;
#[cfg(all(feature = "postgres", target_os = "linux"))]
mod nodelay;
#[cfg(all(feature = "postgres", not(target_os = "linux")))]
mod nodelay {
    pub fn send_at_once(_port: u16) {}
}
pub mod parameter;
mod place;
mod pool;
#[cfg(feature = "postgres")]
mod postgres;
pub mod proposal;
pub mod refused;
pub mod repair;
pub mod result;
pub mod ride;
pub mod river;
pub mod scrub;
pub mod search;
pub mod session;
mod settle;
pub mod snapshot;
mod transaction;
pub mod trial;
pub mod turn;
pub mod webhook;
pub mod worker;

use std::time::Duration;

pub use condition::Condition;
pub use connect::is_postgres;
pub use migrate::MigrateError;
use sqlx::error::DatabaseError;
use sqlx::sqlite::SqliteError;
#[cfg(feature = "postgres")]
use sqlx::{PgPool, Postgres};
use sqlx::{Sqlite, SqlitePool, Transaction};

/// Longest wait for a sign of life.
const PING: Duration = Duration::from_secs(3);

/// The database: native pools, since sqlx's `Any` knows neither UUID nor JSON. `signs` is one connection, opened when
/// it is needed, by which the database is asked whether it lives however many wait for the others.
#[derive(Clone)]
pub enum Db {
    /// One connection writes, so that writers queue in the pool instead of meeting `SQLITE_BUSY`.
    Sqlite {
        write: SqlitePool,
        read: SqlitePool,
        signs: SqlitePool,
        condition: Condition,
    },
    /// Apart, so that however many pages are looked at, the queue has its connections.
    #[cfg(feature = "postgres")]
    Postgres {
        write: PgPool,
        read: PgPool,
        signs: PgPool,
        condition: Condition,
    },
}

/// The driver of transactions that are not SQLite's. Without the feature there are none, and nothing that is typed with it runs.
#[cfg(feature = "postgres")]
type Other = Postgres;
#[cfg(not(feature = "postgres"))]
type Other = Sqlite;

/// A transaction that may write.
pub enum Tx {
    Sqlite(Transaction<'static, Sqlite>, Condition),
    #[cfg(feature = "postgres")]
    Postgres(Transaction<'static, Postgres>, Condition),
}

impl Db {
    /// Begins a transaction whose commit survives a power cut.
    pub async fn begin(&self) -> sqlx::Result<Tx> {
        self.begin_as(transaction::SYNCED).await
    }

    /// Begins a transaction of what would be done again: SQLite does not wait for the disk at its commit,
    /// so that a power cut, which ends this process too, may take the last of them back. The commit of one
    /// that is synced makes all before it safe.
    pub async fn begin_lax(&self) -> sqlx::Result<Tx> {
        self.begin_as(transaction::LAX).await
    }

    async fn begin_as(&self, on_sqlite: &'static str) -> sqlx::Result<Tx> {
        let condition = self.condition().clone();
        condition.check_database()?;
        Ok(match self {
            Db::Sqlite { write, .. } => {
                let begun = transaction::begin_sqlite(write, on_sqlite).await?;
                Tx::Sqlite(begun, condition)
            }
            #[cfg(feature = "postgres")]
            Db::Postgres { write, .. } => {
                let begun = riverqueue::database::begin_postgres(write).await?;
                Tx::Postgres(begun, condition)
            }
        })
    }

    /// Whether it may be written to.
    pub fn condition(&self) -> &Condition {
        match self {
            Db::Sqlite { condition, .. } => condition,
            #[cfg(feature = "postgres")]
            Db::Postgres { condition, .. } => condition,
        }
    }

    /// A River client builder on the pool that writes.
    pub fn river(&self) -> riverqueue::ClientBuilder {
        match self {
            Db::Sqlite { write, .. } => riverqueue::Client::builder(write.clone()),
            #[cfg(feature = "postgres")]
            Db::Postgres { write, .. } => riverqueue::Client::builder(write.clone()),
        }
    }

    pub fn is_sqlite(&self) -> bool {
        self.sqlite().is_some()
    }

    /// The pool that reads, where this is SQLite.
    pub fn sqlite(&self) -> Option<&SqlitePool> {
        self.sqlite_pools().map(|[_, read, _]| read)
    }

    fn sqlite_pools(&self) -> Option<[&SqlitePool; 3]> {
        match self {
            Db::Sqlite {
                write, read, signs, ..
            } => Some([write, read, signs]),
            #[cfg(feature = "postgres")]
            Db::Postgres { .. } => None,
        }
    }

    /// The statement as this database spells it.
    pub fn spelt(&self, sqlite: &'static str, postgres: &'static str) -> &'static str {
        if self.is_sqlite() { sqlite } else { postgres }
    }

    /// Whether nothing of ours is there.
    pub async fn is_new(&self) -> sqlx::Result<bool> {
        const SQLITE: &str = "SELECT COUNT(*) FROM sqlite_schema WHERE name = 'job'";
        const POSTGRES: &str =
            "SELECT CASE WHEN to_regclass('job') IS NULL THEN 0 ELSE 1 END::BIGINT";
        let sql = self.spelt(SQLITE, POSTGRES);
        let tables: i64 = on!(read self, p => sqlx::query_scalar(sql).fetch_one(p).await)?;
        Ok(tables == 0)
    }

    /// Whether the database answers, and soon.
    pub async fn ping(&self) -> sqlx::Result<()> {
        // A table, since a number needs nothing of a file that cannot be read.
        const SQL: &str = "SELECT COUNT(*) FROM worker";
        soon(async { on!(signs self, p => sqlx::query(SQL).execute(p).await.map(drop)) }).await
    }
}

/// Ends what waits for a database that gives no sign of life.
async fn soon<T>(answer: impl Future<Output = sqlx::Result<T>>) -> sqlx::Result<T> {
    let soon = tokio::time::timeout(PING, answer).await;
    soon.unwrap_or(Err(sqlx::Error::PoolTimedOut))
}

/// Whether the database could not be reached, ended the session, or cannot write for now.
pub fn is_outage(error: &sqlx::Error) -> bool {
    match error {
        sqlx::Error::Io(_) | sqlx::Error::Protocol(_) | sqlx::Error::PoolTimedOut => true,
        sqlx::Error::Database(database) => match sqlite_code(error) {
            Some(code) => sqlite_cannot(code),
            None => database.code().is_some_and(|code| postgres_cannot(&code)),
        },
        _ => false,
    }
}

/// Whether SQLite's file cannot be read: input/output error, corrupt, no database.
pub fn is_damage(error: &sqlx::Error) -> bool {
    sqlite_code(error).is_some_and(|code| [10, 11, 26].contains(&code))
}

/// Whether SQLite found the disk to be full.
pub fn is_full(error: &sqlx::Error) -> bool {
    sqlite_code(error) == Some(13)
}

fn sqlite_code(error: &sqlx::Error) -> Option<i32> {
    let error = error.as_database_error()?;
    let code: i32 = error
        .try_downcast_ref::<SqliteError>()?
        .code()?
        .parse()
        .ok()?;
    // Extended codes hold the primary one in their lowest byte.
    Some(code & 0xff)
}

/// Busy, locked, read-only, input/output error, corrupt, disk full, file not to be opened, no database.
fn sqlite_cannot(code: i32) -> bool {
    [5, 6, 8, 10, 11, 13, 14, 26].contains(&code)
}

/// Connection lost, idle in transaction for too long, shutting down or starting up, out of disk or memory.
fn postgres_cannot(code: &str) -> bool {
    ["08", "53", "57P"]
        .iter()
        .any(|class| code.starts_with(class))
        || code == "25P03"
}

impl Tx {
    /// The statement as this database spells it.
    pub fn spelt(&self, sqlite: &'static str, postgres: &'static str) -> &'static str {
        let is_sqlite = match self {
            Tx::Sqlite(..) => true,
            #[cfg(feature = "postgres")]
            Tx::Postgres(..) => false,
        };
        if is_sqlite { sqlite } else { postgres }
    }

    /// The transaction where it is PostgreSQL's, which has many writers and needs more locks.
    pub fn postgres(&mut self) -> Option<&mut Transaction<'static, Other>> {
        match self {
            Tx::Sqlite(..) => None,
            #[cfg(feature = "postgres")]
            Tx::Postgres(t, _) => Some(t),
        }
    }

    /// Commits, and only then says so if the database is still the one that it is taken for.
    pub async fn commit(self) -> sqlx::Result<()> {
        let condition = match &self {
            Tx::Sqlite(_, condition) => condition.clone(),
            #[cfg(feature = "postgres")]
            Tx::Postgres(_, condition) => condition.clone(),
        };
        condition.check_database()?;
        on!(self, t => t.commit().await)?;
        Ok(condition.check_database()?)
    }
}

/// Now, as epoch milliseconds by this process's clock. Leases use the database's clock instead.
pub fn now_ms() -> i64 {
    jiff::Timestamp::now().as_millisecond()
}
