//! The connections of a process that stays, and the log that they write.

use std::path::PathBuf;

use futures_util::future::try_join_all;
use tokio::fs::{self, File};
use uuid::Uuid;

use super::place::Place;
use super::{Db, now_ms};

impl Db {
    /// From now on, SQLite's files are those that are open now. All connections are opened, since one that is opened later
    /// could open another file under the same name.
    pub async fn settle(&self) -> sqlx::Result<()> {
        let Some([write, read, signs]) = self.sqlite_pools() else {
            return Ok(());
        };
        for pool in [write, read, signs] {
            let most = pool.options().get_max_connections();
            drop(try_join_all((0..most).map(|_| pool.acquire())).await?);
        }
        let options = write.connect_options();
        write.set_connect_options((*options).clone().create_if_missing(false));
        let place = Place::of(options.get_filename())?;
        self.condition().settle(place);
        Ok(())
    }

    /// Copies SQLite's database, as it is open, into a new file beside it.
    pub async fn copy_beside(&self) -> sqlx::Result<PathBuf> {
        let [_, read, _] = self.sqlite_pools().ok_or(sqlx::Error::PoolClosed)?;
        let suffixed = |suffix: String| {
            let mut path = read.connect_options().get_filename().as_os_str().to_owned();
            path.push(suffix);
            PathBuf::from(path)
        };
        let copy = suffixed(format!(".rescued-{}", now_ms() / 1000));
        let part = suffixed(format!(".part-{}", Uuid::now_v7().simple()));
        let written = async {
            sqlx::query("VACUUM INTO $1")
                .bind(part.to_string_lossy())
                .execute(read)
                .await?;
            File::open(&part).await?.sync_all().await?;
            fs::rename(&part, &copy).await?;
            Ok(copy)
        };
        let written = written.await;
        if written.is_err() {
            let _ = fs::remove_file(&part).await;
        }
        written
    }

    /// Moves everything that SQLite's log has into the database; whether nothing was left.
    pub async fn empty_log(&self) -> sqlx::Result<bool> {
        let Some([write, ..]) = self.sqlite_pools() else {
            return Ok(true);
        };
        let (busy, pages, moved): (i64, i64, i64) = sqlx::query_as("PRAGMA wal_checkpoint(FULL)")
            .fetch_one(write)
            .await?;
        Ok(busy == 0 && pages == moved)
    }
}
