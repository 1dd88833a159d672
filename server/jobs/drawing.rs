//! The curves of a job, of which whoever draws them keeps the last: a page that is zoomed into asks for them again and again.

use std::sync::{Arc, Mutex, PoisonError};

use serde::{Deserialize, Serialize};
use uuid::Uuid;
use veloid_engine::replay::{Quantity, Series, Window};
use veloid_engine::report::Report;
use veloid_engine::ride::Ride;

use super::unread::Unread;

/// Which part of what curves is drawn.
#[derive(Serialize, Deserialize)]
pub struct Drawing {
    pub job: Uuid,
    pub revision: i64,
    /// The job's report (JSON).
    pub report: String,
    pub quantity: Quantity,
    pub t0: Option<f64>,
    pub t1: Option<f64>,
    pub points: usize,
}

impl Drawing {
    fn key(&self) -> Key {
        (self.job, self.revision, self.quantity)
    }

    pub fn series(&self, ride: &Ride) -> Result<Series, Unread> {
        let report: Report =
            serde_json::from_str(&self.report).map_err(|e| Unread::Report(e.to_string()))?;
        Ok(Series::of(ride, &report, self.quantity))
    }

    pub fn window(&self, series: &Series) -> Window {
        series.window(self.t0, self.t1, self.points)
    }
}

type Key = (Uuid, i64, Quantity);

/// What was drawn last.
#[derive(Default)]
pub struct Drawn(Mutex<Option<(Key, Arc<Series>)>>);

impl Drawn {
    /// The curves, if they are those.
    pub fn of(&self, drawing: &Drawing) -> Option<Arc<Series>> {
        let last = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let (key, series) = last.as_ref()?;
        (*key == drawing.key()).then(|| Arc::clone(series))
    }

    pub fn keep(&self, drawing: &Drawing, series: Series) -> Arc<Series> {
        let series = Arc::new(series);
        let last = Some((drawing.key(), Arc::clone(&series)));
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = last;
        series
    }
}
