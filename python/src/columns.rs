//! Columns for Python: names, and the bytes of doubles, which NumPy takes without a copy.

use pyo3::prelude::*;
use pyo3::types::PyByteArray;
use veloid_engine::Ride;
use veloid_engine::bicycle::{Axle, PerAxle};
use veloid_engine::replay::Series;

pub type Columns<'py> = Vec<(String, Bound<'py, PyByteArray>)>;

/// The ride as a file would hold it.
pub fn of_ride<'py>(py: Python<'py>, ride: &Ride) -> Columns<'py> {
    let channels = ride.channels();
    let named = channels
        .iter()
        .map(|(name, values)| ((*name).to_owned(), doubles(py, values)));
    [times(py, ride)].into_iter().chain(named).collect()
}

/// `front_measured`, `rear_plain` and so on beside the time.
pub fn of_series<'py>(py: Python<'py>, ride: &Ride, series: &Series) -> Columns<'py> {
    let mut columns = vec![times(py, ride)];
    for axle in Axle::BOTH {
        for curve in series.axles.get(axle).into_iter().flatten() {
            let name = format!("{axle}_{}", curve.name);
            columns.push((name, doubles(py, &curve.values)));
        }
    }
    columns
}

/// `front_predicted` and `rear_predicted` beside the time.
pub fn of_prediction<'py>(
    py: Python<'py>,
    times: &[f64],
    axles: &PerAxle<Vec<f64>>,
) -> Columns<'py> {
    let axles = axles.iter();
    let axles = axles.map(|(axle, values)| (format!("{axle}_predicted"), doubles(py, values)));
    let times = [("t".to_owned(), doubles(py, times))];
    times.into_iter().chain(axles).collect()
}

fn times<'py>(py: Python<'py>, ride: &Ride) -> (String, Bound<'py, PyByteArray>) {
    let times: Vec<f64> = (0..ride.samples).map(|i| ride.time_s(i)).collect();
    ("t".to_owned(), doubles(py, &times))
}

fn doubles<'py>(py: Python<'py>, values: &[f64]) -> Bound<'py, PyByteArray> {
    let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
    PyByteArray::new(py, &bytes)
}
