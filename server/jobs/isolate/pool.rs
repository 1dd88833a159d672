//! The children of one lane, kept for the next order once they have done one.

use std::io;
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::child::Child;
use super::process::{Ended, Process};
use crate::jobs::hub::Heard;
use crate::jobs::task::{Order, Outcome};

pub struct Children {
    as_what: Child,
    idle: Mutex<Vec<Process>>,
}

impl Children {
    pub fn new(as_what: Child) -> Self {
        Self {
            as_what,
            idle: Mutex::default(),
        }
    }

    /// Has an order carried out by a child that knows what it is about, by another, or by a new one. Dropped before
    /// that, it ends the child.
    pub async fn perform(&self, order: Order, hear: impl Fn(Heard)) -> Result<Outcome, Ended> {
        let mut child = self.take(&order)?;
        let outcome = child.perform(order, hear).await;
        if matches!(outcome, Ok(_) | Err(Ended::Refused { .. })) {
            self.idle().push(child);
        }
        outcome
    }

    fn take(&self, order: &Order) -> io::Result<Process> {
        let mut idle = self.idle();
        idle.retain_mut(Process::lives);
        match idle.iter().position(|child| child.knows(order)) {
            Some(index) => Ok(idle.swap_remove(index)),
            None => idle.pop().map_or_else(|| Process::start(&self.as_what), Ok),
        }
    }

    fn idle(&self) -> MutexGuard<'_, Vec<Process>> {
        self.idle.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
