//! Looks at each beat whether database and store of raw files are those that this process began with
//! (docs/decisions/installation.md). Nothing is accepted or published while they are not.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use tokio::time::MissedTickBehavior;
use tokio_util::sync::CancellationToken;

use crate::exchanged::Exchanged;
use crate::files::Files;
use crate::store::{self, Db, installation, scrub};

pub const BEAT: Duration = Duration::from_secs(2);
/// A store that does not answer for so long is not there.
const PATIENCE: Duration = Duration::from_secs(5);
/// A damaged database is looked through again after so many times as long as that took.
const PAUSE: u32 = 20;

/// Watches over a database that has settled, until `stop` is cancelled.
pub async fn watch(db: Db, files: Files, stop: CancellationToken) {
    let mut ticks = tokio::time::interval(BEAT);
    ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let mut watch = Watch {
        db,
        files,
        next_search: Instant::now(),
        copy: None,
    };
    loop {
        tokio::select! {
            _ = ticks.tick() => {}
            () = watch.db.condition().suspected() => {}
            () = stop.cancelled() => return,
        }
        let known = watch.db.condition().fault();
        let found = watch.look(&known).await;
        watch.db.condition().note(&known, found);
    }
}

struct Watch {
    db: Db,
    files: Files,
    /// When a database that was found to be damaged is looked through again.
    next_search: Instant,
    /// What was copied out of a database whose file is open and has lost its name.
    copy: Option<PathBuf>,
}

impl Watch {
    async fn look(&mut self, known: &Option<Exchanged>) -> Option<Exchanged> {
        match self.db.condition().check_place() {
            Ok(()) => {}
            Err(Exchanged::Log(fault)) => return Some(self.save(&fault).await),
            Err(fault) => return Some(self.rescue(&fault).await),
        }
        if let Some(copy) = self.copy.take() {
            let _ = tokio::fs::remove_file(copy).await;
        }
        if let Some(Exchanged::Damaged(_)) = known
            && let Some(fault) = self.search(known).await
        {
            return Some(fault);
        }
        match installation::ask(&self.db).await {
            Ok(found) if found == self.files.owner() => {}
            Ok(found) => {
                let found = found.map_or("none".to_owned(), |id| id.to_string());
                return Some(Exchanged::Database(format!(
                    "it belongs to another installation ({found}): put it back, or restart to work with this one"
                )));
            }
            Err(error) if store::is_damage(&error) => {
                return Some(Exchanged::Damaged(error.to_string()));
            }
            // That it does not answer now says nothing of what it is.
            Err(error) if store::is_outage(&error) => return known.clone(),
            Err(error) => return Some(Exchanged::Database(error.to_string())),
        }
        match tokio::time::timeout(PATIENCE, self.files.check()).await {
            Ok(found) => found.err(),
            Err(_) => Some(Exchanged::Store(format!(
                "the store did not answer for {} s",
                PATIENCE.as_secs()
            ))),
        }
    }

    /// What the file without a name has would end with this process.
    async fn rescue(&mut self, fault: &Exchanged) -> Exchanged {
        let copy = match self.copy.take() {
            Some(copy) => Ok(copy),
            None => self.db.copy_beside().await,
        };
        let text = match &copy {
            Ok(copy) => format!(
                "{fault}: put it back, or before another takes its place stop this process and remove its -wal and -shm; all that \
                 was acknowledged is also in {}",
                copy.display()
            ),
            Err(error) => {
                format!("{fault}: put it back; no copy of what is open was made: {error}")
            }
        };
        self.copy = copy.ok();
        Exchanged::File(text)
    }

    /// What the missing log has is written into the database, so that a restart finds it.
    async fn save(&self, fault: &str) -> Exchanged {
        let saved = match self.db.empty_log().await {
            Ok(true) => "what it had is in the database: put it back or restart",
            Ok(false) => "what it had is not in the database yet: do not end this process",
            Err(error) => return Exchanged::Damaged(format!("{fault}: {error}")),
        };
        Exchanged::Log(format!("{fault}; {saved}"))
    }

    /// What is wrong with the pages of a database that was found to be damaged.
    async fn search(&mut self, known: &Option<Exchanged>) -> Option<Exchanged> {
        let begun = Instant::now();
        if begun < self.next_search {
            return known.clone();
        }
        let fault = match scrub::first_fault(&self.db).await {
            Ok(fault) => fault?,
            Err(error) => error.to_string(),
        };
        self.next_search = Instant::now() + begun.elapsed() * PAUSE;
        Some(Exchanged::Damaged(fault))
    }
}
