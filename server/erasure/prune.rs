//! The end of what was deleted. Rows go first, in a synced transaction that also records the files which no ride has any
//! more. These are removed once the days of grace have passed again, so that a copy of the database which is no older
//! finds the files of its rides. A file is removed because the database says so, never because it lacks a row.

use std::collections::{BTreeMap, BTreeSet};

use uuid::Uuid;

use super::policy::{DAY_MS, Policy};
use crate::crash;
use crate::files::Files;
use crate::installation::{InstallationError, pair};
use crate::jobs::{Fault, Queue, give_up};
use crate::store::audit::{self, Actor};
use crate::store::deletion::{self, Due};
use crate::store::{Db, Tx, bike_event, erased_file, job, now_ms, refused, ride};

/// Jobs that are erased in one transaction.
const BATCH: i64 = 50;
/// Files that are asked for at once.
const FILES: i64 = 500;

#[derive(Debug, thiserror::Error)]
pub enum EraseError {
    #[error("database: {0}")]
    Database(#[from] sqlx::Error),
    #[error("file store: {0}")]
    Files(#[from] std::io::Error),
    #[error(transparent)]
    Installation(#[from] InstallationError),
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
    pub note: &'a (dyn Fn(&str) + Sync),
}

impl Prune<'_> {
    pub async fn run(&self) -> Result<Erased, EraseError> {
        self.expire().await?;
        let mut erased = Erased::default();
        let until = now_ms() - self.policy.grace_ms;
        let mut released = BTreeSet::new();
        let mut last = Uuid::nil();
        loop {
            let due = deletion::due(self.db, until, last, BATCH).await?;
            let Some(end) = due.last() else { break };
            last = end.id;
            released.extend(self.erase(&due, until, &mut erased).await?);
        }
        let mut tx = self.db.begin().await?;
        let mut events: BTreeMap<(String, String), u64> = BTreeMap::new();
        for of in bike_event::erase(&mut tx, until).await? {
            *events.entry(of).or_default() += 1;
        }
        for ((group, name), count) in events {
            let what = format!("{count} events of bike {name}");
            self.note(&mut tx, &group, "erase", &what).await?;
        }
        for (group, name) in deletion::erase_bikes(&mut tx, until).await? {
            self.note(&mut tx, &group, "erase", &format!("bike {name}"))
                .await?;
            erased.bikes += 1;
        }
        refused::erase(&mut tx, now_ms() - refused::KEPT_MS).await?;
        self.end(tx).await?;
        erased.files = match self.dry_run && self.policy.grace_ms == 0 {
            true => self.foresee(&released),
            false => 0,
        };
        erased.files += self.remove_recorded().await?;
        Ok(erased)
    }

    /// Says of files that a dry run has not recorded what would become of them.
    fn foresee(&self, released: &BTreeSet<String>) -> u64 {
        for sha256 in released {
            self.say("erase", &format!("raw file {sha256}"));
        }
        released.len() as u64
    }

    /// Removes the files that were recorded long enough ago.
    async fn remove_recorded(&self) -> Result<u64, EraseError> {
        // The store may have been exchanged since this process began.
        pair(self.db, self.files).await?;
        let until = now_ms() - self.policy.grace_ms;
        let (mut removed, mut last) = (0, String::new());
        loop {
            let due = erased_file::due(self.db, until, &last, FILES).await?;
            let Some(end) = due.last() else {
                return Ok(removed);
            };
            last.clone_from(end);
            for sha256 in &due {
                removed += u64::from(self.remove(sha256).await?);
            }
        }
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

    /// Erases jobs and the rides that have none left; the files that no ride has any more.
    async fn erase(
        &self,
        due: &[Due],
        until: i64,
        erased: &mut Erased,
    ) -> Result<BTreeSet<String>, EraseError> {
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
        let mut released = BTreeSet::new();
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
                    erased_file::add(&mut tx, &sha256, now_ms()).await?;
                    released.insert(sha256);
                }
            }
        }
        crash::point("in_erase");
        self.end(tx).await?;
        crash::point("after_erase");
        Ok(released)
    }

    /// Removes a file that no ride has, and its row. An upload of the same bytes either sees that they are gone, or is
    /// seen here.
    pub(super) async fn remove(&self, sha256: &str) -> Result<bool, EraseError> {
        let mut tx = self.db.begin().await?;
        ride::lock_file(&mut tx, sha256).await?;
        let removed = match ride::is_held(&mut tx, sha256).await? {
            true => false,
            false if self.dry_run => self.files.has(sha256).await?,
            false => self.files.remove(sha256).await?,
        };
        crash::point("in_removal");
        erased_file::forget(&mut tx, sha256).await?;
        self.end(tx).await?;
        if removed {
            self.say("erase", &format!("raw file {sha256}"));
        }
        Ok(removed)
    }

    async fn note(&self, tx: &mut Tx, group: &str, action: &str, what: &str) -> sqlx::Result<()> {
        self.say(action, &format!("{what} of group {group}"));
        audit::note(tx, group, self.actor, action, what).await
    }

    fn say(&self, action: &str, what: &str) {
        match self.dry_run {
            true => (self.note)(&format!("would {action} {what}")),
            false => (self.note)(&format!("{action}d {what}")),
        }
    }

    async fn end(&self, tx: Tx) -> sqlx::Result<()> {
        match self.dry_run {
            true => Ok(()),
            false => tx.commit().await,
        }
    }
}
