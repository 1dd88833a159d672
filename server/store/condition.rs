//! Whether the database may be written to: every transaction asks at its beginning, and before and after its commit.

use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use tokio::sync::Notify;

use super::place::Place;
use crate::exchanged::Exchanged;

#[derive(Clone, Default)]
pub struct Condition(Arc<Known>);

#[derive(Default)]
struct Known {
    place: OnceLock<Place>,
    fault: Mutex<Option<Exchanged>>,
    suspected: Notify,
}

impl Condition {
    /// From now on these are the files that are open.
    pub(super) fn settle(&self, place: Place) {
        let _ = self.0.place.set(place);
    }

    /// What is wrong with database or raw files.
    pub fn check(&self) -> Result<(), Exchanged> {
        match self.fault() {
            Some(fault) => Err(fault),
            None => self.look_soon(),
        }
    }

    /// What is wrong with the database.
    pub fn check_database(&self) -> Result<(), Exchanged> {
        match self.fault() {
            None | Some(Exchanged::Store(_)) => self.look_soon(),
            Some(fault) => Err(fault),
        }
    }

    fn look_soon(&self) -> Result<(), Exchanged> {
        let held = self.check_place();
        if held.is_err() {
            self.0.suspected.notify_one();
        }
        held
    }

    /// Whether the files that are open still have their names.
    pub fn check_place(&self) -> Result<(), Exchanged> {
        self.0.place.get().map_or(Ok(()), Place::holds)
    }

    /// What was found last.
    pub fn fault(&self) -> Option<Exchanged> {
        self.lock().clone()
    }

    /// Notes what was found in place of what was known then, and logs it where it is new.
    pub fn note(&self, known: &Option<Exchanged>, found: Option<Exchanged>) {
        let mut fault = self.lock();
        if *fault != *known || *fault == found {
            return;
        }
        match &found {
            Some(fault) => {
                tracing::error!(detail = %fault, "{}: nothing is accepted", fault.what());
            }
            None => tracing::warn!("database and raw files are as they should be again"),
        }
        *fault = found;
    }

    /// Nothing is written until the database has been looked through.
    pub fn suspect(&self, why: impl ToString) {
        if self.check().is_ok() {
            self.note(&None, Some(Exchanged::Damaged(why.to_string())));
        }
        self.0.suspected.notify_one();
    }

    fn lock(&self) -> MutexGuard<'_, Option<Exchanged>> {
        self.0.fault.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Ends when there is a suspicion.
    pub async fn suspected(&self) {
        self.0.suspected.notified().await;
    }
}
