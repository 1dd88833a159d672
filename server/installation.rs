//! Database and store of raw files carry the id of one installation, so that no process works on the files of another
//! database (docs/decisions/installation.md).

use std::collections::BTreeSet;
use std::time::Duration;

use futures_util::TryStreamExt;
use uuid::Uuid;

use crate::files::Files;
use crate::store::{Db, installation, ride};

/// A raw file may lie in the store for so long before its ride is recorded.
pub const ARRIVING: Duration = Duration::from_secs(3600);
/// Files that the database is asked for at once.
const PAGE: usize = 500;

#[derive(Debug, thiserror::Error)]
pub enum InstallationError {
    #[error(
        "the database belongs to installation {database}, the store of raw files to {store}: give the two that belong \
         together (DATABASE_URL, VELOID_DATA, VELOID_FILES); if these are copies of both, `veloid adopt --new` makes them a \
         separate installation"
    )]
    Differ { database: Uuid, store: Uuid },
    #[error(
        "the database has {rides} rides, but the store of raw files has no id; it may be an unmounted folder: mount or give the \
         store that belongs to the database (VELOID_DATA, VELOID_FILES); if this is that store, `veloid adopt` makes both one \
         installation"
    )]
    Unmarked { rides: i64 },
    #[error(
        "the store contains raw files, but the database has no rides: give the database that belongs to it (DATABASE_URL, \
         VELOID_DATA) or an empty store; if that database is lost, `veloid adopt` continues without it and keeps the files"
    )]
    NoRides,
    #[error(
        "{unknown} of {files} raw files in the store belong to no ride of this database, so they may be another \
         installation's: give the database and the store that belong together; if these do, `veloid adopt` makes both one \
         installation"
    )]
    Unknown { unknown: usize, files: usize },
    #[error("database: {0}")]
    Database(#[from] sqlx::Error),
    #[error("file store: {0}")]
    Files(#[from] std::io::Error),
}

/// How many raw files a store has, and the SHA-256 of those that the database does not know.
#[derive(Default)]
pub struct Census {
    pub files: usize,
    pub unknown: Vec<String>,
}

impl Census {
    /// Counts the files that have lain in the store for so long.
    pub async fn take(db: &Db, files: &Files, age: Duration) -> Result<Self, InstallationError> {
        let mut census = Self::default();
        let mut pages = std::pin::pin!(files.kept_for(age).try_chunks(PAGE));
        while let Some(names) = pages.try_next().await.map_err(|error| error.1)? {
            let known: BTreeSet<String> = ride::known(db, &names).await?.into_iter().collect();
            census.files += names.len();
            let unknown = names.into_iter().filter(|name| !known.contains(name));
            census.unknown.extend(unknown);
        }
        Ok(census)
    }

    fn knows_some(&self) -> bool {
        self.files > self.unknown.len()
    }
}

/// Holds the ids of database and store against each other, and gives it. Both get one where neither is in use, or where the files that
/// an earlier version kept are those of its rides.
pub async fn pair(db: &Db, files: &Files) -> Result<Uuid, InstallationError> {
    let (database, store) = (installation::find(db).await?, files.installation().await?);
    let id = match (database, store) {
        (Some(database), Some(store)) => return same(database, store),
        (Some(database), None) => match (ride::count(db).await?, files.has_any().await?) {
            (0, false) => database,
            (rides, _) => return Err(InstallationError::Unmarked { rides }),
        },
        (None, store) => match (ride::count(db).await?, files.has_any().await?) {
            // An id that is there is that of an installation which has nothing to lose, but may go on to be used.
            (0, false) => Uuid::now_v7(),
            (0, true) => return Err(InstallationError::NoRides),
            (rides, false) => return Err(InstallationError::Unmarked { rides }),
            (_, true) => {
                match_files(db, files).await?;
                store.unwrap_or_else(Uuid::now_v7)
            }
        },
    };
    join(db, files, store, id).await
}

fn same(database: Uuid, store: Uuid) -> Result<Uuid, InstallationError> {
    match database == store {
        true => Ok(database),
        false => Err(InstallationError::Differ { database, store }),
    }
}

/// Refuses a store with files that the database does not know, other than those that may be arriving.
async fn match_files(db: &Db, files: &Files) -> Result<(), InstallationError> {
    let settled = Census::take(db, files, ARRIVING).await?;
    let refuse = |census: Census| InstallationError::Unknown {
        unknown: census.unknown.len(),
        files: census.files,
    };
    if !settled.unknown.is_empty() {
        return Err(refuse(settled));
    }
    if settled.knows_some() {
        return Ok(());
    }
    let all = Census::take(db, files, Duration::ZERO).await?;
    match all.knows_some() {
        true => Ok(()),
        false => Err(refuse(all)),
    }
}

/// Gives database and store one id: the store first, so that a process which dies between the two leaves what the next
/// one may complete, and not what looks like an unmounted folder.
async fn join(
    db: &Db,
    files: &Files,
    seen: Option<Uuid>,
    id: Uuid,
) -> Result<Uuid, InstallationError> {
    let mut tx = db.begin().await?;
    let database = installation::lock(&mut tx).await?.unwrap_or(id);
    // Where another process has joined them meanwhile, the store has that id by now.
    let store = match seen {
        Some(seen) if seen != id && database == id => {
            files.replace_installation(id).await?;
            id
        }
        _ => files.keep_installation(database).await?,
    };
    same(database, store)?;
    installation::put(&mut tx, database).await?;
    tx.commit().await?;
    Ok(database)
}

/// Makes database and store one installation as they are, without looking at rides and files: under the id that one of
/// them has or, where both have others or `new` is wanted, under a new one.
pub async fn adopt(db: &Db, files: &Files, new: bool) -> Result<Uuid, InstallationError> {
    let (database, store) = (installation::find(db).await?, files.installation().await?);
    let id = match (database, store) {
        _ if new => Uuid::now_v7(),
        (Some(database), Some(store)) if database != store => {
            return Err(InstallationError::Differ { database, store });
        }
        (database, store) => database.or(store).unwrap_or_else(Uuid::now_v7),
    };
    if store != Some(id) {
        files.replace_installation(id).await?;
    }
    let mut tx = db.begin().await?;
    installation::put(&mut tx, id).await?;
    tx.commit().await?;
    Ok(id)
}
