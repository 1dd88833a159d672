//! Every error of the API: RFC 9457 `application/problem+json` with a stable `type`.

use std::time::Duration;

use axum::extract::rejection::{PathRejection, QueryRejection};
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::Serialize;
use utoipa::ToSchema;
use veloid_engine::EngineError;

use crate::built::NotBuilt;
use crate::exchanged::Exchanged;
use crate::export::NoModel;
use crate::facts::FactsError;
use crate::files::FileError;
use crate::jobs::{Fault, OverBudget, Unreadable};
use crate::options::OptionsError;
use crate::seldom::Seldom;
use crate::store;
use crate::store::result::DocumentError;
use crate::time::TimeError;
use crate::watch::BEAT;

/// What a response carries for the server itself: an error that makes the database suspect.
#[derive(Clone, Debug)]
pub struct Suspicion(pub String);

/// Wait that is asked for where files have to be read first.
const CROWDED_WAIT: Duration = Duration::from_secs(10);

/// Clients try again, and each request has its own line in the log.
static UNREACHED: Seldom = Seldom::new();
static UNSTORED: Seldom = Seldom::new();

/// An error in the form of RFC 9457.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct Problem {
    #[serde(rename = "type")]
    pub kind: Kind,
    /// The kind of problem in words.
    #[schema(value_type = String)]
    pub title: &'static str,
    pub status: u16,
    /// What is wrong in this case, and what was expected.
    pub detail: String,
    /// Where the fault is in the uploaded file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub place: Option<Box<Place>>,
    /// Wait before another try is worth it: the header `Retry-After`.
    #[serde(skip)]
    retry_after: Option<Duration>,
    #[serde(skip)]
    pub suspicion: Option<Suspicion>,
}

/// The kinds of problem: the `type` on which clients may rely.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[schema(as = ProblemKind)]
pub enum Kind {
    #[serde(rename = "urn:veloid:problem:bad-request")]
    BadRequest,
    #[serde(rename = "urn:veloid:problem:not-found")]
    NotFound,
    #[serde(rename = "urn:veloid:problem:method-not-allowed")]
    MethodNotAllowed,
    #[serde(rename = "urn:veloid:problem:too-large")]
    TooLarge,
    #[serde(rename = "urn:veloid:problem:too-slow")]
    TooSlow,
    #[serde(rename = "urn:veloid:problem:unreadable-ride")]
    UnreadableRide,
    #[serde(rename = "urn:veloid:problem:bad-bike")]
    BadBike,
    #[serde(rename = "urn:veloid:problem:bad-option")]
    BadOption,
    #[serde(rename = "urn:veloid:problem:bad-fact")]
    BadFact,
    #[serde(rename = "urn:veloid:problem:idempotency-key-reused")]
    IdempotencyKeyReused,
    #[serde(rename = "urn:veloid:problem:not-finished")]
    NotFinished,
    #[serde(rename = "urn:veloid:problem:no-model")]
    NoModel,
    #[serde(rename = "urn:veloid:problem:not-comparable")]
    NotComparable,
    #[serde(rename = "urn:veloid:problem:file-lost")]
    FileLost,
    #[serde(rename = "urn:veloid:problem:report-unreadable")]
    ReportUnreadable,
    #[serde(rename = "urn:veloid:problem:wrong-state")]
    WrongState,
    #[serde(rename = "urn:veloid:problem:foreign")]
    Foreign,
    #[serde(rename = "urn:veloid:problem:unauthorized")]
    Unauthorized,
    #[serde(rename = "urn:veloid:problem:forbidden")]
    Forbidden,
    #[serde(rename = "urn:veloid:problem:too-many")]
    TooMany,
    #[serde(rename = "urn:veloid:problem:unavailable")]
    Unavailable,
    #[serde(rename = "urn:veloid:problem:storage")]
    Storage,
    #[serde(rename = "urn:veloid:problem:not-built")]
    NotBuilt,
    #[serde(rename = "urn:veloid:problem:internal")]
    Internal,
}

impl Kind {
    /// The `type` of its problems.
    pub fn urn(self) -> String {
        let name = serde_json::to_value(self).ok();
        let name = name.as_ref().and_then(serde_json::Value::as_str);
        name.unwrap_or_default().to_owned()
    }

    fn status_and_title(self) -> (StatusCode, &'static str) {
        match self {
            Kind::BadRequest => (StatusCode::BAD_REQUEST, "The request is malformed"),
            Kind::NotFound => (StatusCode::NOT_FOUND, "Not found"),
            Kind::MethodNotAllowed => (
                StatusCode::METHOD_NOT_ALLOWED,
                "The method is not allowed here",
            ),
            Kind::TooLarge => (StatusCode::PAYLOAD_TOO_LARGE, "The upload is too large"),
            Kind::TooSlow => (StatusCode::REQUEST_TIMEOUT, "The request was too slow"),
            Kind::UnreadableRide => (
                StatusCode::UNPROCESSABLE_ENTITY,
                "The ride file cannot be used",
            ),
            Kind::BadBike => (
                StatusCode::UNPROCESSABLE_ENTITY,
                "The bicycle cannot be used",
            ),
            Kind::BadOption => (StatusCode::UNPROCESSABLE_ENTITY, "An option is not allowed"),
            Kind::BadFact => (
                StatusCode::UNPROCESSABLE_ENTITY,
                "A fact of the ride is not allowed",
            ),
            Kind::IdempotencyKeyReused => (
                StatusCode::UNPROCESSABLE_ENTITY,
                "The idempotency key belongs to another request",
            ),
            Kind::NotFinished => (StatusCode::CONFLICT, "The job has no report yet"),
            Kind::NoModel => (StatusCode::CONFLICT, "The ride has no model to simulate"),
            Kind::NotComparable => (
                StatusCode::UNPROCESSABLE_ENTITY,
                "The model cannot be compared with the ride",
            ),
            Kind::FileLost => (
                StatusCode::GONE,
                "The stored file is missing or was altered",
            ),
            Kind::ReportUnreadable => (
                StatusCode::INTERNAL_SERVER_ERROR,
                "The stored report cannot be read",
            ),
            Kind::WrongState => (StatusCode::CONFLICT, "The job's state does not allow this"),
            Kind::Foreign => (StatusCode::FORBIDDEN, "Another site sent this request"),
            Kind::Unauthorized => (StatusCode::UNAUTHORIZED, "A key is required"),
            Kind::Forbidden => (StatusCode::FORBIDDEN, "The key does not allow this"),
            Kind::TooMany => (StatusCode::TOO_MANY_REQUESTS, "The key's limit is reached"),
            Kind::Unavailable => (StatusCode::SERVICE_UNAVAILABLE, "Not ready"),
            Kind::Storage => (
                StatusCode::SERVICE_UNAVAILABLE,
                "The database or the raw files are damaged or not this server's",
            ),
            Kind::NotBuilt => (
                StatusCode::NOT_IMPLEMENTED,
                "This server is built without the required feature",
            ),
            Kind::Internal => (
                StatusCode::INTERNAL_SERVER_ERROR,
                "Something went wrong on the server",
            ),
        }
    }
}

/// Place of a fault in an uploaded file.
#[derive(Clone, Debug, Serialize, ToSchema)]
#[schema(as = RidePlace)]
pub struct Place {
    /// Kind of fault, stable: `not-a-number`, `time-not-increasing`, `gzip-bomb` ...
    pub fault: String,
    pub file: String,
    /// Line and column, counted from 1.
    pub line: Option<usize>,
    pub column: Option<usize>,
    /// Header text of the column.
    pub header: Option<String>,
}

impl Problem {
    pub fn new(kind: Kind, detail: impl Into<String>) -> Self {
        let (status, title) = kind.status_and_title();
        Self {
            kind,
            title,
            status: status.as_u16(),
            detail: detail.into(),
            place: None,
            retry_after: match kind {
                Kind::Unavailable => Some(Duration::from_secs(1)),
                Kind::Storage => Some(BEAT),
                _ => None,
            },
            suspicion: None,
        }
    }

    pub fn retry_after(mut self, wait: Duration) -> Self {
        self.retry_after = Some(wait);
        self
    }

    pub fn not_found(what: &str) -> Self {
        Self::new(Kind::NotFound, format!("{what} was not found"))
    }

    /// The cause goes to the log, not to the client.
    pub fn internal(cause: impl std::fmt::Display) -> Self {
        tracing::error!(%cause, "internal error");
        Self::new(Kind::Internal, "the cause is in the server's log")
    }
}

impl Problem {
    fn unreadable(cause: impl std::fmt::Display) -> Self {
        tracing::error!(%cause, "a report cannot be read");
        let detail = format!("{cause}; upload the ride with `again` to identify it again");
        Self::new(Kind::ReportUnreadable, detail)
    }
}

impl IntoResponse for Problem {
    fn into_response(self) -> Response {
        let status = StatusCode::from_u16(self.status).unwrap_or(StatusCode::INTERNAL_SERVER_ERROR);
        let body = serde_json::to_vec(&self).unwrap_or_default();
        let json = HeaderValue::from_static("application/problem+json");
        let mut response = (status, [(header::CONTENT_TYPE, json)], body).into_response();
        if let Some(suspicion) = self.suspicion {
            response.extensions_mut().insert(suspicion);
        }
        let headers = response.headers_mut();
        if let Some(wait) = self.retry_after {
            let seconds = wait.as_secs_f64().ceil().max(1.0) as u64;
            headers.insert(header::RETRY_AFTER, seconds.into());
        }
        if self.kind == Kind::Unauthorized {
            let bearer = HeaderValue::from_static("Bearer");
            headers.insert(header::WWW_AUTHENTICATE, bearer);
        }
        response
    }
}

impl From<&Exchanged> for Problem {
    fn from(exchanged: &Exchanged) -> Self {
        Self::new(Kind::Storage, format!("{}; try again", exchanged.what()))
    }
}

impl From<sqlx::Error> for Problem {
    fn from(error: sqlx::Error) -> Self {
        match error {
            sqlx::Error::Io(error) if Exchanged::behind(&error).is_some() => error.into(),
            error if store::is_damage(&error) => {
                tracing::error!(%error, "the database cannot be read or written");
                let detail = "the database cannot be read or written; try again";
                let suspicion = Some(Suspicion(error.to_string()));
                Self {
                    suspicion,
                    ..Self::new(Kind::Storage, detail)
                }
            }
            error if store::is_outage(&error) => {
                if UNREACHED.is_due() {
                    tracing::error!(%error, "database cannot be reached");
                }
                Self::new(
                    Kind::Unavailable,
                    "the database is busy or unavailable; try again",
                )
            }
            // Two requests with one idempotency key met; the second one will find the first's job.
            sqlx::Error::Database(error) if error.is_unique_violation() => Self::new(
                Kind::Unavailable,
                "an identical request is being stored; try again",
            ),
            error => Self::internal(error),
        }
    }
}

impl From<std::io::Error> for Problem {
    fn from(error: std::io::Error) -> Self {
        use std::io::ErrorKind::{
            NotADirectory, NotFound, PermissionDenied, QuotaExceeded, ReadOnlyFilesystem,
            StaleNetworkFileHandle, StorageFull,
        };
        if let Some(exchanged) = Exchanged::behind(&error) {
            return exchanged.into();
        }
        match error.kind() {
            // What an operator mends while the client waits.
            StorageFull
            | QuotaExceeded
            | ReadOnlyFilesystem
            | PermissionDenied
            | NotFound
            | NotADirectory
            | StaleNetworkFileHandle => {
                if UNSTORED.is_due() {
                    tracing::error!(%error, "uploads cannot be stored");
                }
                Self::new(
                    Kind::Unavailable,
                    format!("the ride cannot be stored: {}", error.kind()),
                )
            }
            _ => Self::internal(error),
        }
    }
}

impl From<FileError> for Problem {
    fn from(error: FileError) -> Self {
        match error {
            FileError::Store(error) => error.into(),
            lost => {
                tracing::error!(%lost, "a ride's file cannot be used");
                let detail = format!("{lost}; upload the same file again to replace it");
                Self::new(Kind::FileLost, detail)
            }
        }
    }
}

impl From<DocumentError> for Problem {
    fn from(error: DocumentError) -> Self {
        match error {
            DocumentError::Database(error) => error.into(),
            unreadable => Self::unreadable(unreadable),
        }
    }
}

impl From<TimeError> for Problem {
    fn from(error: TimeError) -> Self {
        Self::new(Kind::BadRequest, error.to_string())
    }
}

impl From<riverqueue::Error> for Problem {
    fn from(error: riverqueue::Error) -> Self {
        match error {
            riverqueue::Error::Database(error) => error.into(),
            error => Self::internal(error),
        }
    }
}

impl From<tokio::task::JoinError> for Problem {
    fn from(error: tokio::task::JoinError) -> Self {
        Self::internal(error)
    }
}

impl From<Fault> for Problem {
    fn from(fault: Fault) -> Self {
        match fault {
            Fault::Read(error) => error.into(),
            Fault::File(error) => error.into(),
            Fault::Engine(error) => error.into(),
            Fault::Report(_) => Self::unreadable(fault),
            Fault::Incomparable(why) => Self::new(Kind::NotComparable, why),
            Fault::Database(error) => error.into(),
            Fault::Queue(error) => error.into(),
            Fault::Budget(error) => error.into(),
            Fault::TooLargeToRead(_) => Self::new(Kind::TooLarge, fault.to_string()),
            // What it did to the process that read it, it would do again.
            Fault::Died(_) | Fault::Panic(_) => {
                tracing::error!(%fault, "a ride could not be read");
                let detail = format!("reading it failed: {fault}");
                Self::new(Kind::UnreadableRide, detail)
            }
            Fault::Deadline(limit) => {
                let detail = format!(
                    "reading it took longer than the {} s allowed",
                    limit.as_secs()
                );
                Self::new(Kind::UnreadableRide, detail)
            }
            Fault::Crowded(_) => {
                Self::new(Kind::Unavailable, fault.to_string()).retry_after(CROWDED_WAIT)
            }
            Fault::Killed(_) | Fault::Interrupted | Fault::Stopped => {
                tracing::error!(%fault, "a ride could not be read");
                let detail = "the process that read the ride was killed from outside, possibly for lack of memory; try again";
                Self::new(Kind::Unavailable, detail)
            }
            fault => Self::internal(fault),
        }
    }
}

impl From<OverBudget> for Problem {
    fn from(error: OverBudget) -> Self {
        Self::new(Kind::TooLarge, error.to_string())
    }
}

impl From<OptionsError> for Problem {
    fn from(error: OptionsError) -> Self {
        Self::new(Kind::BadOption, error.to_string())
    }
}

impl From<FactsError> for Problem {
    fn from(error: FactsError) -> Self {
        Self::new(Kind::BadFact, error.to_string())
    }
}

impl From<EngineError> for Problem {
    fn from(error: EngineError) -> Self {
        let kind = match error {
            EngineError::Bike(_) => Kind::BadBike,
            EngineError::Setting { .. } => Kind::BadOption,
            EngineError::Ride { .. } => Kind::UnreadableRide,
            error => return Self::internal(error),
        };
        Self::new(kind, error.to_string())
    }
}

impl From<Unreadable> for Problem {
    fn from(error: Unreadable) -> Self {
        let kind = match error.kind.as_str() {
            "not-built" => Kind::NotBuilt,
            _ => Kind::UnreadableRide,
        };
        let mut problem = Self::new(kind, error.to_string());
        let (column, header) = error.column.unzip();
        problem.place = Some(Box::new(Place {
            fault: error.kind,
            file: error.file,
            line: error.line,
            column,
            header,
        }));
        problem
    }
}

impl From<NoModel> for Problem {
    fn from(error: NoModel) -> Self {
        Problem::new(Kind::NoModel, error.to_string())
    }
}

impl From<NotBuilt> for Problem {
    fn from(error: NotBuilt) -> Self {
        Self::new(Kind::NotBuilt, error.to_string())
    }
}

impl From<QueryRejection> for Problem {
    fn from(rejection: QueryRejection) -> Self {
        Self::new(Kind::BadRequest, rejection.body_text())
    }
}

impl From<PathRejection> for Problem {
    /// An id that is no id names nothing.
    fn from(rejection: PathRejection) -> Self {
        Self::new(Kind::NotFound, rejection.body_text())
    }
}

#[cfg(test)]
mod tests {
    use std::io::Error;

    use rustix::io::Errno;

    use super::*;

    #[test]
    fn a_folder_that_may_not_be_written_puts_uploads_off() {
        let status = |errno: Errno| {
            let problem = Problem::from(Error::from(errno));
            (problem.status, problem.retry_after.is_some())
        };
        for errno in [
            Errno::ACCESS,
            Errno::PERM,
            Errno::ROFS,
            Errno::NOSPC,
            Errno::DQUOT,
            Errno::NOENT,
            Errno::NOTDIR,
            Errno::STALE,
        ] {
            assert_eq!(status(errno), (503, true), "{errno}");
        }
        assert_eq!(status(Errno::INVAL), (500, false), "a fault of the program");
    }
}
