//! Who may compute beside whom. Attempts run side by side, but those of a suspect (`store/loss.rs`), which
//! have the process to themselves: should it die then, nobody else can have been the cause.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use tokio::sync::{OwnedRwLockReadGuard, OwnedRwLockWriteGuard, RwLock};
use uuid::Uuid;

use super::fault::Fault;
use crate::store::{Db, loss};

/// Wait before the database is asked again whose turn it is.
const LOOK: Duration = Duration::from_millis(50);
/// An attempt that may not begin for so long goes back, or those who have to go first might find no slot.
const PATIENCE: Duration = Duration::from_secs(1);

#[derive(Clone, Default)]
pub struct Gate {
    passage: Arc<RwLock<()>>,
    /// The River row that has the process to itself.
    alone: Arc<Mutex<Option<i64>>>,
}

/// Leave to compute, for as long as it is held.
#[expect(dead_code, reason = "held, not looked at")]
pub(super) enum Leave {
    Beside(OwnedRwLockReadGuard<()>),
    Alone(OwnedRwLockWriteGuard<()>),
}

impl Gate {
    /// Waits until the row's job may compute.
    pub(super) async fn enter(&self, db: &Db, job: Uuid, row: i64) -> Result<Leave, Fault> {
        let until = Instant::now() + PATIENCE;
        loop {
            let beside = Arc::clone(&self.passage).read_owned().await;
            let standing = loss::standing(db, job).await?;
            if standing.is_suspect() {
                drop(beside);
                let alone = Arc::clone(&self.passage).write_owned().await;
                if !gives_way(db, loss::standing(db, job).await?) && note(db, job, row).await? {
                    *self.row() = Some(row);
                    return Ok(Leave::Alone(alone));
                }
            } else if !gives_way(db, standing) {
                *self.row() = None;
                return Ok(Leave::Beside(beside));
            }
            if Instant::now() >= until {
                return Err(Fault::GivesWay);
            }
            tokio::time::sleep(LOOK).await;
        }
    }

    /// The River row that has the process to itself, if any has.
    pub(super) fn alone(&self) -> Option<i64> {
        *self.row()
    }

    fn row(&self) -> MutexGuard<'_, Option<i64>> {
        self.alone.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// On SQLite the next process begins with what was alone when the last one died. Where many work,
/// the others need not wait.
fn gives_way(db: &Db, standing: loss::Standing) -> bool {
    db.is_sqlite() && standing.gives_way()
}

/// Notes that a row has the process to itself; false while another row of the job has another process.
pub(super) async fn note(db: &Db, job: Uuid, row: i64) -> Result<bool, Fault> {
    let mut tx = db.begin_lax().await?;
    let noted = loss::alone(&mut tx, job, row).await?;
    tx.commit().await?;
    Ok(noted)
}
