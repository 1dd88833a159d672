//! What Python gives the engine.

use std::collections::BTreeMap;

use pyo3::buffer::PyBuffer;
use pyo3::prelude::*;
use pyo3::pybacked::PyBackedBytes;
use serde_json::Value;
use veloid_engine::document::json;
use veloid_engine::ride::{Arrays, Content, ReadOptions, RideFile};
use veloid_engine::{Bike, Imposed, Ride};

use crate::failure::Failure;

/// One logger's record: its name, and a file's bytes or columns with the epoch (s) of their time 0.
#[derive(FromPyObject)]
pub struct Source(String, Given);

#[derive(FromPyObject)]
enum Given {
    Bytes(PyBackedBytes),
    Columns(Vec<(String, PyBuffer<f64>)>, Option<f64>),
}

/// The same without Python's objects.
pub enum Owned {
    Bytes(String, PyBackedBytes),
    Columns(String, Vec<(String, Vec<f64>)>, Option<f64>),
}

pub fn owned(py: Python<'_>, sources: Vec<Source>) -> PyResult<Vec<Owned>> {
    let owned = sources.into_iter().map(|Source(name, given)| match given {
        Given::Bytes(bytes) => Ok(Owned::Bytes(name, bytes)),
        Given::Columns(columns, epoch_s) => {
            let columns = columns
                .into_iter()
                .map(|(n, buffer)| Ok((n, buffer.to_vec(py)?)));
            let columns = columns.collect::<PyResult<Vec<_>>>()?;
            Ok(Owned::Columns(name, columns, epoch_s))
        }
    });
    owned.collect()
}

pub fn read(sources: &[Owned], bike: &Bike, reading: &ReadOptions) -> Result<Ride, Failure> {
    let columns = sources.iter().map(|source| match source {
        Owned::Bytes(..) => Vec::new(),
        Owned::Columns(_, columns, _) => {
            let lent = columns
                .iter()
                .map(|(name, values)| (name.as_str(), values.as_slice()));
            lent.collect()
        }
    });
    let columns: Vec<Vec<(&str, &[f64])>> = columns.collect();
    let files = sources
        .iter()
        .zip(&columns)
        .map(|(source, columns)| match source {
            Owned::Bytes(name, bytes) => RideFile::new(name, bytes),
            Owned::Columns(name, _, epoch_s) => RideFile {
                name,
                content: Content::Arrays(Arrays {
                    columns,
                    epoch_s: *epoch_s,
                }),
            },
        });
    let files: Vec<RideFile<'_>> = files.collect();
    Ok(veloid_engine::read(&files, bike, reading)?)
}

/// A document of options.
pub fn options<T: serde::de::DeserializeOwned>(text: &str) -> Result<T, Failure> {
    json::from_text(text).map_err(Failure::Options)
}

/// One of several words.
pub fn word<T: serde::de::DeserializeOwned>(key: &str, word: &str) -> Result<T, Failure> {
    let word = json::from_value(Value::from(word));
    word.map_err(|problem| Failure::Options(format!("{key}: {problem}")))
}

/// Effects as triples of id, axle and parameters.
pub fn effects(text: &str) -> Result<Vec<Imposed>, Failure> {
    let given: Vec<(String, String, BTreeMap<String, f64>)> = options(text)?;
    let effects = given.into_iter().map(|(id, axle, parameters)| {
        let axle = word("axle", &axle)?;
        Ok(Imposed {
            id,
            axle,
            parameters,
        })
    });
    effects.collect()
}
