//! The engine's refusals as exceptions of `veloid.errors`, with their place.

use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyDict};
use veloid_engine::bicycle::BikeError;
use veloid_engine::ride::{Problem, ReadError};
use veloid_engine::{Bike, EngineError, Incomparable, ModelError};

pub enum Failure {
    Read(ReadError),
    Engine(EngineError),
    /// An option that cannot be understood, by the key in front.
    Options(String),
    /// A report that is none.
    Report(serde_json::Error),
    Model(ModelError),
    Incomparable(Incomparable),
}

impl From<ModelError> for Failure {
    fn from(error: ModelError) -> Self {
        Self::Model(error)
    }
}

impl From<Incomparable> for Failure {
    fn from(error: Incomparable) -> Self {
        Self::Incomparable(error)
    }
}

impl From<ReadError> for Failure {
    fn from(error: ReadError) -> Self {
        Self::Read(error)
    }
}

impl From<EngineError> for Failure {
    fn from(error: EngineError) -> Self {
        Self::Engine(error)
    }
}

impl From<BikeError> for Failure {
    fn from(error: BikeError) -> Self {
        Self::Engine(error.into())
    }
}

impl From<serde_json::Error> for Failure {
    fn from(error: serde_json::Error) -> Self {
        Self::Report(error)
    }
}

impl From<Failure> for PyErr {
    fn from(failure: Failure) -> Self {
        Python::attach(|py| failure.raised(py).unwrap_or_else(|error| error))
    }
}

impl Failure {
    /// The exception, or what went wrong in making it.
    fn raised(&self, py: Python<'_>) -> PyResult<PyErr> {
        let (class, message) = match self {
            Self::Read(error) => match *error.problem {
                Problem::BadOption { .. } => ("OptionError", error.to_string()),
                _ => ("RideError", error.to_string()),
            },
            Self::Engine(EngineError::Bike(error)) => ("BikeError", error.to_string()),
            Self::Engine(error @ EngineError::Setting { .. }) => ("OptionError", error.to_string()),
            Self::Engine(error) => ("IdentificationError", error.to_string()),
            Self::Options(message) => ("OptionError", message.clone()),
            Self::Report(error) => ("VeloidError", format!("not a report of veloid: {error}")),
            Self::Model(error) => ("VeloidError", error.to_string()),
            Self::Incomparable(error) => ("IdentificationError", error.to_string()),
        };
        let class = py.import("veloid.errors")?.getattr(class)?;
        Ok(PyErr::from_value(
            class.call((message,), Some(&self.place(py)?))?,
        ))
    }

    fn place<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        match self {
            Self::Read(error) => match *error.problem {
                Problem::BadOption { name, .. } => [("key", name)].into_py_dict(py),
                _ => place_in_file(py, error),
            },
            Self::Engine(EngineError::Bike(error)) => {
                [("key", bike_key(&error.to_string()))].into_py_dict(py)
            }
            Self::Engine(EngineError::Setting { name, .. }) => [("key", *name)].into_py_dict(py),
            Self::Engine(EngineError::Ride { axle, .. }) => {
                [("axle", axle.name())].into_py_dict(py)
            }
            Self::Engine(EngineError::Diverged { stage, .. }) => {
                [("stage", *stage)].into_py_dict(py)
            }
            Self::Engine(EngineError::NotFinite(found)) => {
                [("stage", found.stage)].into_py_dict(py)
            }
            Self::Options(message) => {
                let key = message.split_once(": ").map(|(key, _)| key);
                [("key", key)].into_py_dict(py)
            }
            Self::Engine(EngineError::Cancelled)
            | Self::Report(_)
            | Self::Model(_)
            | Self::Incomparable(_) => Ok(PyDict::new(py)),
        }
    }
}

fn place_in_file<'py>(py: Python<'py>, error: &ReadError) -> PyResult<Bound<'py, PyDict>> {
    let place = [("file", error.file()), ("kind", error.kind())].into_py_dict(py)?;
    place.set_item("line", error.line())?;
    // NumPy counts from 0.
    place.set_item("row", error.sample().map(|sample| sample - 1))?;
    place.set_item("column", error.column().map(|(_, name)| name))?;
    place.set_item("column_number", error.column().map(|(number, _)| number))?;
    Ok(place)
}

/// The key that a message about a bike begins with, or the unknown one that it names.
fn bike_key(message: &str) -> Option<&str> {
    if let Some(unknown) = message.strip_prefix("unknown key '") {
        return unknown.split('\'').next();
    }
    let first = message.split([' ', ':']).next()?;
    let known = serde_json::to_value(Bike::default()).ok()?;
    let top = first.split('.').next()?;
    known.get(top).map(|_| first)
}
