//! Reads the files of rides for requests and jobs, a few at a time, in a lane of its own.

use std::sync::Arc;
use std::time::Duration;

use rayon::ThreadPoolBuildError;
use tokio_util::sync::CancellationToken;
use veloid_engine::replay::Window;
use veloid_engine::report::{IdentifiedModel, ModelOnRide};
use veloid_engine::ride::{Logger, Preview, Ride};

use super::budget::Budget;
use super::compute::Lane;
use super::control::Control;
use super::drawing::Drawing;
use super::errand::{Checked, Errand, Found, Source, Wanted};
use super::fault::Fault;
use super::seats::{Purpose, SEATS, Seat, Seats};
use super::task::{Order, Outcome};
use crate::store::job::Request;

pub struct Readers {
    lane: Lane,
    budget: Budget,
    patience: Patience,
    loggers: Arc<[Logger]>,
    seats: Arc<Seats>,
}

/// Time that reading may take.
#[derive(Clone, Copy)]
pub struct Patience {
    /// For a request.
    pub request: Duration,
    /// For a job, whose file was read within that time once.
    pub job: Duration,
}

impl Readers {
    /// In child processes that have so much memory (bytes), if any is said.
    pub fn new(
        isolated: Option<u64>,
        budget: Budget,
        patience: Patience,
        loggers: Arc<[Logger]>,
    ) -> Result<Self, ThreadPoolBuildError> {
        Ok(Self {
            lane: Lane::new("reading", SEATS, 0, isolated)?,
            budget,
            patience,
            loggers,
            seats: Arc::default(),
        })
    }

    /// A reader for files of so many bytes, when it is the group's turn.
    pub async fn turn(
        &self,
        group: &str,
        bytes: u64,
        purpose: Purpose,
    ) -> Result<Reader<'_>, Fault> {
        let seat = Seats::take(&self.seats, group, bytes, purpose).await?;
        let limit = match purpose {
            Purpose::Request => self.patience.request,
            Purpose::Job => self.patience.job,
        };
        Ok(Reader {
            readers: self,
            limit,
            _seat: seat,
        })
    }
}

/// One reader, until it is dropped.
pub struct Reader<'a> {
    readers: &'a Readers,
    limit: Duration,
    _seat: Seat,
}

impl Reader<'_> {
    /// The ride, if a job may have as much memory as it needs.
    pub async fn ride(self, files: Vec<Source>, request: Request) -> Result<Ride, Fault> {
        let wanted = Wanted::Ride(self.readers.budget);
        match self.perform(files, request, wanted).await? {
            Found::Ride(ride) => Ok(*ride),
            _ => Err(Fault::Mismatch),
        }
    }

    /// What an upload is asked before it is kept, by the same condition.
    pub async fn check(self, files: Vec<Source>, request: Request) -> Result<Checked, Fault> {
        let wanted = Wanted::Check(self.readers.budget);
        match self.perform(files, request, wanted).await? {
            Found::Checked(checked) => Ok(*checked),
            _ => Err(Fault::Mismatch),
        }
    }

    pub async fn preview(self, files: Vec<Source>, request: Request) -> Result<Preview, Fault> {
        match self.perform(files, request, Wanted::Preview).await? {
            Found::Preview(preview) => Ok(*preview),
            _ => Err(Fault::Mismatch),
        }
    }

    pub async fn window(
        self,
        files: Vec<Source>,
        request: Request,
        drawing: Drawing,
    ) -> Result<Window, Fault> {
        let wanted = Wanted::Drawing(drawing);
        match self.perform(files, request, wanted).await? {
            Found::Window(window) => Ok(*window),
            _ => Err(Fault::Mismatch),
        }
    }

    /// How well a model predicts the ride.
    pub async fn comparison(
        self,
        files: Vec<Source>,
        request: Request,
        model: IdentifiedModel,
    ) -> Result<ModelOnRide, Fault> {
        let wanted = Wanted::Comparison(Box::new(model));
        match self.perform(files, request, wanted).await? {
            Found::Compared(compared) => Ok(*compared),
            _ => Err(Fault::Mismatch),
        }
    }

    /// Whose child is killed from outside has one more try: somebody else may have taken the memory.
    async fn perform(
        self,
        files: Vec<Source>,
        request: Request,
        wanted: Wanted,
    ) -> Result<Found, Fault> {
        let errand = Arc::new(Errand {
            files,
            request,
            loggers: self.readers.loggers.to_vec(),
            wanted,
        });
        let outcome = match self.once(&errand).await {
            Err(Fault::Killed(why)) => {
                tracing::warn!(why, "retrying to read a ride");
                self.once(&errand).await
            }
            outcome => outcome,
        };
        match outcome {
            Ok(Outcome::Errand(found)) => Ok(found?),
            Ok(_) => Err(Fault::Mismatch),
            Err(Fault::OutOfMemory(why)) => {
                tracing::warn!(why, "a ride was too large to read");
                Err(Fault::TooLargeToRead(self.readers.budget))
            }
            Err(fault) => Err(fault),
        }
    }

    async fn once(&self, errand: &Arc<Errand>) -> Result<Outcome, Fault> {
        let control = Control {
            job: None,
            turn: 0,
            token: CancellationToken::new(),
            limit: self.limit,
            deadline: None,
        };
        let order = Order::Errand(Arc::clone(errand));
        self.readers.lane.perform(control, order).await
    }
}
