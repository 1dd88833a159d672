//! SQL, in one place per table. The same text runs on SQLite and PostgreSQL: `$1` placeholders, ids
//! as UUID, times as epoch milliseconds, documents as JSON. Functions that write take a [`Tx`],
//! functions that only read take the [`Db`].

/// Runs a body once per driver: `on!(read db, p => ...)` with the pool that reads, `on!(tx, t => ...)`
/// with the transaction.
macro_rules! on {
    (read $db:expr, $p:ident => $body:expr) => {
        match $db {
            $crate::store::Db::Sqlite { read: $p, .. } => $body,
            $crate::store::Db::Postgres($p) => $body,
        }
    };
    ($tx:expr, $t:ident => $body:expr) => {
        match $tx {
            $crate::store::Tx::Sqlite($t) => $body,
            $crate::store::Tx::Postgres($t) => $body,
        }
    };
}
pub(crate) use on;

pub mod bike;
mod connect;
pub mod idempotency_key;
pub mod job;
mod migrate;
pub mod parameter;
pub mod result;
pub mod ride;
pub mod river;
pub mod season;
pub mod trial;
pub mod worker;

pub use migrate::MigrateError;
use sqlx::{PgPool, Postgres, Sqlite, SqlitePool, Transaction};

/// The database: native pools, since sqlx's `Any` knows neither UUID nor JSON.
#[derive(Clone)]
pub enum Db {
    /// One connection writes, so that writers queue in the pool instead of meeting `SQLITE_BUSY`.
    Sqlite {
        write: SqlitePool,
        read: SqlitePool,
    },
    Postgres(PgPool),
}

/// A transaction that may write.
pub enum Tx {
    Sqlite(Transaction<'static, Sqlite>),
    Postgres(Transaction<'static, Postgres>),
}

impl Db {
    /// Begins a transaction; on SQLite with the write lock, since a transaction that reads first
    /// cannot take it later.
    pub async fn begin(&self) -> sqlx::Result<Tx> {
        Ok(match self {
            Db::Sqlite { write, .. } => {
                Tx::Sqlite(riverqueue::database::begin_sqlite_write(write).await?)
            }
            Db::Postgres(pool) => Tx::Postgres(riverqueue::database::begin_postgres(pool).await?),
        })
    }

    /// A River client builder on the pool that writes.
    pub fn river(&self) -> riverqueue::ClientBuilder {
        match self {
            Db::Sqlite { write, .. } => riverqueue::Client::builder(write.clone()),
            Db::Postgres(pool) => riverqueue::Client::builder(pool.clone()),
        }
    }

    pub fn is_sqlite(&self) -> bool {
        matches!(self, Db::Sqlite { .. })
    }

    /// Whether the database answers.
    pub async fn ping(&self) -> sqlx::Result<()> {
        on!(read self, p => sqlx::query("SELECT 1").execute(p).await.map(drop))
    }
}

impl Tx {
    pub async fn commit(self) -> sqlx::Result<()> {
        on!(self, t => t.commit().await)
    }
}

/// Now, as epoch milliseconds by this process's clock. Leases use the database's clock instead.
pub fn now_ms() -> i64 {
    jiff::Timestamp::now().as_millisecond()
}
