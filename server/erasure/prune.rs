//! The end of what was deleted. Rows go first, in a transaction that is synced; then the files that no ride has
//! any more. Whoever dies between the two leaves files without a ride, which the next one finds.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use futures_util::TryStreamExt;
use uuid::Uuid;

use super::policy::{DAY_MS, Policy};
use crate::crash;
use crate::files::Files;
use crate::jobs::{Fault, Queue, give_up};
use crate::store::audit::{self, Actor};
use crate::store::deletion::{self, Due};
use crate::store::{Db, Tx, job, now_ms, ride};

/// Jobs that are erased in one transaction.
const BATCH: i64 = 50;
/// Files that are asked for at once.
const FILES: usize = 500;
/// A file may lie there for so long before its ride is known.
const ARRIVING: Duration = Duration::from_secs(3600);

#[derive(Debug, thiserror::Error)]
pub enum EraseError {
    #[error("database: {0}")]
    Database(#[from] sqlx::Error),
    #[error("file store: {0}")]
    Files(#[from] std::io::Error),
    #[error(transparent)]
    Work(#[from] Fault),
}

/// What was erased, or would be.
#[derive(Debug, Default, PartialEq)]
pub struct Erased {
    pub jobs: u64,
    pub rides: u64,
    pub bikes: u64,
    pub files: u64,
}

/// Erases what was deleted long enough ago.
pub struct Prune<'a> {
    pub db: &'a Db,
    pub files: &'a Files,
    pub queue: &'a Queue,
    pub policy: &'a Policy,
    pub actor: Actor,
    /// Only says what it would do.
    pub dry_run: bool,
    /// Hears of everything that is deleted or erased, in a line each.
    pub tell: &'a (dyn Fn(&str) + Sync),
}

impl Prune<'_> {
    pub async fn run(&self) -> Result<Erased, EraseError> {
        self.expire().await?;
        let mut erased = Erased::default();
        let until = now_ms() - self.policy.grace_ms;
        let mut last = Uuid::nil();
        loop {
            let due = deletion::due(self.db, until, last, BATCH).await?;
            let Some(end) = due.last() else { break };
            last = end.id;
            self.erase(&due, until, &mut erased).await?;
        }
        let mut tx = self.db.begin().await?;
        for (group, name) in deletion::erase_bikes(&mut tx, until).await? {
            self.note(&mut tx, &group, "erase", &format!("bike {name}"))
                .await?;
            erased.bikes += 1;
        }
        self.end(tx).await?;
        erased.files += self.orphans().await?;
        Ok(erased)
    }

    /// Deletes what is older than its group keeps it.
    async fn expire(&self) -> Result<(), EraseError> {
        for group in deletion::groups(self.db).await? {
            let Some(retained) = self.policy.retained(&group) else {
                continue;
            };
            let (now, mut tx) = (now_ms(), self.db.begin().await?);
            let jobs = deletion::mark_before(&mut tx, &group, now - retained, now).await?;
            if jobs > 0 {
                let subject = format!("{jobs} jobs older than {} days", retained / DAY_MS);
                self.note(&mut tx, &group, "delete", &subject).await?;
            }
            self.end(tx).await?;
        }
        Ok(())
    }

    /// Erases jobs, the rides that have none left, and their files.
    async fn erase(&self, due: &[Due], until: i64, erased: &mut Erased) -> Result<(), EraseError> {
        let mut tx = self.db.begin().await?;
        let mut rides = BTreeMap::new();
        for job in due {
            job::lock(&mut tx, job.id).await?;
            if deletion::is_due(&mut tx, job.id, until).await? {
                // One may have been queued while its bike was deleted.
                give_up(self.queue, &mut tx, job.id, None).await?;
                deletion::erase_job(&mut tx, job.id).await?;
                *rides.entry((job.ride_id, &job.group_name)).or_insert(0) += 1;
            }
        }
        let mut left = BTreeSet::new();
        for ((ride, group), jobs) in rides {
            let files = ride::erase_if_done(&mut tx, ride).await?;
            let subject = match &files {
                Some(_) => format!("ride {ride} with {jobs} jobs"),
                None => format!("{jobs} jobs of ride {ride}"),
            };
            self.note(&mut tx, group, "erase", &subject).await?;
            erased.jobs += jobs;
            erased.rides += u64::from(files.is_some());
            for sha256 in files.into_iter().flatten() {
                if !ride::is_held(&mut tx, &sha256).await? {
                    left.insert(sha256);
                }
            }
        }
        crash::point("in_erase");
        self.end(tx).await?;
        crash::point("after_erase");
        for sha256 in left {
            erased.files += u64::from(self.remove(&sha256).await?);
        }
        Ok(())
    }

    /// Removes files that have lain there for a while without a ride.
    pub async fn orphans(&self) -> Result<u64, EraseError> {
        let mut removed = 0;
        let mut chunks = std::pin::pin!(self.files.kept_for(ARRIVING).try_chunks(FILES));
        while let Some(files) = chunks.try_next().await.map_err(|error| error.1)? {
            let held: BTreeSet<String> = ride::held(self.db, &files).await?.into_iter().collect();
            for sha256 in files.iter().filter(|sha256| !held.contains(*sha256)) {
                removed += u64::from(self.remove(sha256).await?);
            }
        }
        Ok(removed)
    }

    /// Removes a file that no ride has. Whoever uploads the same bytes meanwhile sees that they are gone, or is
    /// seen here.
    async fn remove(&self, sha256: &str) -> Result<bool, EraseError> {
        if !self.dry_run {
            let mut tx = self.db.begin().await?;
            ride::lock_file(&mut tx, sha256).await?;
            if ride::is_held(&mut tx, sha256).await? || !self.files.remove(sha256).await? {
                return Ok(false);
            }
        }
        self.say("erase", &format!("raw file {sha256}"));
        Ok(true)
    }

    async fn note(&self, tx: &mut Tx, group: &str, action: &str, what: &str) -> sqlx::Result<()> {
        self.say(action, &format!("{what} of group {group}"));
        audit::note(tx, group, self.actor, action, what).await
    }

    fn say(&self, action: &str, what: &str) {
        match self.dry_run {
            true => (self.tell)(&format!("would {action} {what}")),
            false => (self.tell)(&format!("{action}d {what}")),
        }
    }

    async fn end(&self, tx: Tx) -> sqlx::Result<()> {
        match self.dry_run {
            true => Ok(()),
            false => tx.commit().await,
        }
    }
}
