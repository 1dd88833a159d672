#[cfg(feature = "postgres")]
use riverqueue::migrate::PostgresMigrator;
use riverqueue::migrate::SqliteMigrator;
#[cfg(feature = "postgres")]
use sqlx::Connection;
use sqlx::migrate::Migrator;

use super::Db;

static SQLITE: Migrator = sqlx::migrate!("../migrations/sqlite");
#[cfg(any(test, feature = "postgres"))]
static POSTGRES: Migrator = sqlx::migrate!("../migrations/postgres");

/// Advisory lock of whoever migrates a PostgreSQL database: "veloid" in ASCII.
#[cfg(feature = "postgres")]
const MIGRATION_LOCK: i64 = 0x7665_6c6f_6964;

#[derive(Debug, thiserror::Error)]
pub enum MigrateError {
    #[error("database: {0}")]
    Database(#[from] sqlx::Error),
    #[error(
        "the database has schema {found}, but this veloid supports none after {newest}: use the newer veloid that created it"
    )]
    Newer { found: i64, newest: i64 },
    #[error("schema: {0}")]
    Schema(#[source] sqlx::migrate::MigrateError),
    #[error("queue schema: {0}")]
    Queue(#[from] riverqueue::migrate::Error),
}

impl From<sqlx::migrate::MigrateError> for MigrateError {
    fn from(error: sqlx::migrate::MigrateError) -> Self {
        match error {
            sqlx::migrate::MigrateError::VersionMissing(found) if found > newest() => {
                let newest = newest();
                MigrateError::Newer { found, newest }
            }
            other => MigrateError::Schema(other),
        }
    }
}

/// The newest schema that this program knows; both databases have the same numbers.
fn newest() -> i64 {
    let versions = SQLITE.iter().map(|migration| migration.version);
    versions.max().unwrap_or(0)
}

impl Db {
    /// Brings our tables and River's up to date. Neither migrator bears company, so PostgreSQL holds
    /// an advisory lock around both; on SQLite the caller holds the data folder's file lock.
    ///
    /// SQLite changes a key by building the table again. References are not enforced meanwhile, or
    /// dropping the old table would take along the rows that point to it.
    pub async fn migrate(&self) -> Result<(), MigrateError> {
        match self {
            Db::Sqlite { write, .. } => {
                let mut connection = write.acquire().await?;
                sqlx::query("PRAGMA foreign_keys = OFF")
                    .execute(&mut *connection)
                    .await?;
                SQLITE.run(&mut *connection).await?;
                sqlx::query("PRAGMA foreign_keys = ON")
                    .execute(&mut *connection)
                    .await?;
                drop(connection);
                SqliteMigrator::new(write.clone()).migrate_up().await?;
            }
            #[cfg(feature = "postgres")]
            Db::Postgres { write: pool, .. } => {
                let mut lock = pool.acquire().await?.detach();
                // Others may take their time.
                sqlx::query("SET statement_timeout = 0")
                    .execute(&mut lock)
                    .await?;
                sqlx::query("SELECT pg_advisory_lock($1)")
                    .bind(MIGRATION_LOCK)
                    .execute(&mut lock)
                    .await?;
                POSTGRES.run(pool).await?;
                PostgresMigrator::new(pool.clone()).migrate_up().await?;
                lock.close().await?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod upgrade;

#[cfg(test)]
mod tests {
    use super::*;

    /// Migrations that each database makes in its own way; `upgrade` compares the outcome.
    const OWN_WAY: [i64; 1] = [4];

    /// The PostgreSQL text of a SQLite migration.
    fn translated(sqlite: &str) -> String {
        const JSON: [&str; 9] = [
            "facts",
            "document",
            "request",
            "summary",
            "least_squares",
            "failure",
            "result",
            "study",
            "next_ride",
        ];
        let line = |line: &str| {
            let name = line.split_whitespace().next().unwrap_or_default();
            let text = if JSON.contains(&name) && line.starts_with("    ") {
                line.replace("TEXT", "JSON")
            } else {
                line.to_owned()
            };
            text.replace("BLOB", "UUID")
                .replace("INTEGER", "BIGINT")
                .replace("REAL", "DOUBLE PRECISION")
                .replace(") STRICT;", ");")
                .replace("../postgres", "../sqlite")
        };
        let lines: Vec<String> = sqlite.lines().map(line).collect();
        lines.join("\n")
    }

    #[test]
    fn both_databases_have_the_same_tables() {
        assert_eq!(SQLITE.iter().count(), POSTGRES.iter().count());
        for (ours, theirs) in SQLITE.iter().zip(POSTGRES.iter()) {
            assert_eq!(ours.version, theirs.version);
            if OWN_WAY.contains(&ours.version) {
                continue;
            }
            let (ours, theirs) = (ours.sql.as_str(), theirs.sql.as_str());
            assert_eq!(translated(ours), theirs.trim_end(), "apart from the types");
        }
    }
}
