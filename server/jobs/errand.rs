//! What is asked of the files of a ride: to read them, to say what would be read, to draw what came of them. Done where stages are
//! computed, here or in a child process, of files that lie on this machine, so that no process but that one has what they hold.

use std::ffi::OsString;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};
use uuid::Uuid;
use veloid_engine::replay::Window;
use veloid_engine::report::{IdentifiedModel, ModelOnRide};
use veloid_engine::ride::{self, Logger, Preview, ReadOptions, Ride, RideFile, RideSummary};

use super::at_hand::{SMALL, bytes};
use super::budget::Budget;
use super::drawing::{Drawing, Drawn};
use super::unread::{Unread, Unreadable};
use crate::crash;
use crate::store::job::Request;

#[derive(Serialize, Deserialize)]
pub struct Errand {
    pub files: Vec<Source>,
    pub request: Request,
    /// Loggers of the lab.
    pub loggers: Vec<Logger>,
    pub wanted: Wanted,
}

/// A file as its sender calls it, and where it lies.
#[derive(Clone, Serialize, Deserialize)]
pub struct Source {
    name: String,
    /// A folder's name need not be text.
    path: OsString,
}

#[derive(Serialize, Deserialize)]
pub enum Wanted {
    /// The ride, if the budget bears it.
    Ride(Budget),
    /// What an upload is asked, by the same condition.
    Check(Budget),
    Preview,
    Drawing(Drawing),
    /// How well the model predicts the ride.
    Comparison(Box<IdentifiedModel>),
}

/// What came of an [`Errand`].
#[derive(Serialize, Deserialize)]
pub enum Found {
    Ride(Box<Ride>),
    Checked(Box<Checked>),
    Preview(Box<Preview>),
    Window(Box<Window>),
    Compared(Box<ModelOnRide>),
}

/// What is asked of a ride that is sent.
#[derive(Serialize, Deserialize)]
pub struct Checked {
    pub summary: RideSummary,
    /// Epoch (s) of the first sample, where the files say it.
    pub begun_s: Option<f64>,
    /// Mean of the speed (m/s).
    pub speed: Option<f64>,
    /// What the files say in comments above their headers, by line.
    pub comments: Vec<(usize, String)>,
    /// What the bicycle lacks for it.
    pub lacks: Option<String>,
    /// The ride, if it is small.
    pub ride: Option<Ride>,
}

impl Source {
    pub fn new(name: String, path: PathBuf) -> Self {
        let path = path.into_os_string();
        Self { name, path }
    }
}

impl Wanted {
    fn stage(&self) -> &'static str {
        match self {
            Wanted::Ride(_) | Wanted::Check(_) => "read",
            Wanted::Preview => "preview",
            Wanted::Drawing(_) => "series",
            Wanted::Comparison(_) => "validation",
        }
    }
}

impl Errand {
    /// The job that is drawn.
    pub fn job(&self) -> Option<Uuid> {
        match &self.wanted {
            Wanted::Drawing(drawing) => Some(drawing.job),
            _ => None,
        }
    }

    /// Does it, with what was drawn last at hand.
    pub fn perform(&self, drawn: &Drawn) -> Result<Found, Unread> {
        crash::poison(self.wanted.stage(), self.request.options.settings.seed);
        if let Wanted::Drawing(drawing) = &self.wanted
            && let Some(series) = drawn.of(drawing)
        {
            return Ok(Found::Window(Box::new(drawing.window(&series))));
        }
        let contents = self.contents()?;
        let files: Vec<RideFile<'_>> = (self.files.iter().zip(&contents))
            .map(|(file, bytes)| RideFile::new(&file.name, bytes))
            .collect();
        Ok(match &self.wanted {
            Wanted::Ride(budget) => Found::Ride(Box::new(self.borne(&files, *budget)?)),
            Wanted::Check(budget) => {
                let ride = self.borne(&files, *budget)?;
                let comments = contents.iter().flat_map(|bytes| ride::comments(bytes));
                Found::Checked(Box::new(self.checked(ride, comments.collect())))
            }
            Wanted::Preview => {
                let preview = ride::preview(&files, &self.reading());
                Found::Preview(Box::new(preview.map_err(Unreadable::from)?))
            }
            Wanted::Drawing(drawing) => {
                let ride = self.ride(&files)?;
                let series = drawn.keep(drawing, drawing.series(&ride)?);
                Found::Window(Box::new(drawing.window(&series)))
            }
            Wanted::Comparison(model) => {
                let (ride, Request { bike, options }) = (self.ride(&files)?, &self.request);
                let alpha = options.settings.alpha;
                let compared = veloid_engine::compare(model, &ride, bike, alpha);
                let compared = compared.map_err(|e| Unread::Incomparable(e.to_string()))?;
                Found::Compared(Box::new(compared))
            }
        })
    }

    fn contents(&self) -> Result<Vec<Vec<u8>>, Unread> {
        let read = |file: &Source| {
            std::fs::read(&file.path).map_err(|e| Unread::File(format!("{}: {e}", file.name)))
        };
        self.files.iter().map(read).collect()
    }

    fn ride(&self, files: &[RideFile<'_>]) -> Result<Ride, Unreadable> {
        let bike = &self.request.bike;
        Ok(veloid_engine::read(files, bike, &self.reading())?)
    }

    fn reading(&self) -> ReadOptions {
        ReadOptions {
            loggers: self.loggers.clone().into(),
            ..self.request.options.reading.clone()
        }
    }
}

impl Errand {
    /// The ride, if a job may have as much memory as it needs.
    fn borne(&self, files: &[RideFile<'_>], budget: Budget) -> Result<Ride, Unread> {
        let ride = self.ride(files)?;
        budget.bears(&ride, &self.request.options.settings)?;
        Ok(ride)
    }

    fn checked(&self, ride: Ride, comments: Vec<(usize, String)>) -> Checked {
        let mean = |values: &Vec<f64>| values.iter().sum::<f64>() / values.len() as f64;
        let lacks = ride.fits(&self.request.bike).err();
        Checked {
            summary: ride.summary.clone(),
            begun_s: ride.epoch_s.map(|epoch_s| epoch_s + ride.time_s(0)),
            speed: ride.speed.as_ref().map(mean),
            comments,
            lacks: lacks.map(|error| error.to_string()),
            ride: (bytes(&ride) <= SMALL).then_some(ride),
        }
    }
}
