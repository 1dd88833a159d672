//! The engine for Python: what `veloid/` calls. Arrays come in as buffers of doubles and go out as their bytes; documents
//! (bike, options, report) are JSON both ways, so that every number is the command line's, bit for bit.

mod columns;
mod failure;
mod input;
mod run;

use pyo3::prelude::*;
use veloid_engine::document::format_number::Number;
use veloid_engine::replay::Quantity;
use veloid_engine::report::study::StudyReport;
use veloid_engine::report::{self, IdentifiedModel, Report};
use veloid_engine::simulate::simulated_ride::SimulatedRide;
use veloid_engine::{Bike, Ridden, Ride, Settings, Start};

use columns::Columns;
use failure::Failure;
use input::Source;

/// A ride that was read, kept for its series.
#[pyclass(frozen)]
struct Record(Ride);

/// Reads and identifies; the report's text and the ride.
#[pyfunction]
fn identify(
    py: Python<'_>,
    sources: Vec<Source>,
    bike: &str,
    reading: &str,
    settings: &str,
    progress: Option<Bound<'_, PyAny>>,
    threads: Option<usize>,
) -> PyResult<(String, Record)> {
    let bike = Bike::from_json(bike).map_err(Failure::from)?;
    let reading = input::options(reading)?;
    let settings: Settings = input::options(settings)?;
    veloid_engine::validate(&settings).map_err(Failure::from)?;
    let sources = input::owned(py, sources)?;
    let pool = run::pool(threads)?;
    run::beside(py, &pool, &settings, progress, |heard| {
        let ride = input::read(&sources, &bike, &reading)?;
        let report = veloid_engine::identify(&ride, &bike, &settings, heard)?;
        Ok((serde_json::to_string_pretty(&report)?, Record(ride)))
    })
}

/// Several rides as one, each with its name and bicycle; the report's text.
#[pyfunction]
fn study(
    py: Python<'_>,
    rides: Vec<(String, Vec<Source>, String)>,
    reading: &str,
    settings: &str,
    progress: Option<Bound<'_, PyAny>>,
    threads: Option<usize>,
) -> PyResult<String> {
    let reading = input::options(reading)?;
    let settings: Settings = input::options(settings)?;
    veloid_engine::validate(&settings).map_err(Failure::from)?;
    let mut given = Vec::new();
    for (name, sources, bike) in rides {
        let bike = Bike::from_json(&bike).map_err(Failure::from)?;
        given.push((name, input::owned(py, sources)?, bike));
    }
    let pool = run::pool(threads)?;
    run::beside(py, &pool, &settings, progress, |heard| {
        let rides = (given.iter())
            .map(|(_, sources, bike)| input::read(sources, bike, &reading))
            .collect::<Result<Vec<Ride>, _>>()?;
        let ridden: Vec<Ridden<'_>> = (given.iter().zip(&rides))
            .map(|((name, _, bike), ride)| Ridden {
                name: name.clone(),
                ride,
                bike,
            })
            .collect();
        let report = veloid_engine::study(&ridden, &settings, heard)?;
        Ok(serde_json::to_string_pretty(&report)?)
    })
}

/// A simulated ride: its columns, and what it was made of.
#[pyfunction]
fn simulate<'py>(
    py: Python<'py>,
    simulated_ride: &str,
    bike: &str,
    effects: &str,
    accelerometers: Option<f64>,
) -> PyResult<(Columns<'py>, String)> {
    let simulated_ride: SimulatedRide = input::options(simulated_ride)?;
    let bike = Bike::from_json(bike).map_err(Failure::from)?;
    let effects = input::effects(effects)?;
    let pool = run::pool(None)?;
    let ride = run::beside(py, &pool, &Settings::default(), None, |_| {
        Ok(match accelerometers {
            Some(noise) => veloid_engine::sensed(&simulated_ride, &bike, &effects, noise)?,
            None => veloid_engine::simulate(&simulated_ride, &bike, &effects)?,
        })
    })?;
    let made = serde_json::to_string(&simulated_ride).map_err(Failure::from)?;
    Ok((columns::of_ride(py, &ride), made))
}

/// Measured and simulated motion of a ride, sample by sample; the columns of each axle have its name in front.
#[pyfunction]
fn series<'py>(
    py: Python<'py>,
    record: &Record,
    report: &str,
    quantity: &str,
) -> PyResult<Columns<'py>> {
    let quantity: Quantity = input::word("quantity", quantity)?;
    let report: Report = serde_json::from_str(report).map_err(Failure::from)?;
    let series = py.detach(|| veloid_engine::replay::Series::of(&record.0, &report, quantity));
    Ok(columns::of_series(py, &record.0, &series))
}

/// The model of a report, or of an exported model, as a document.
#[pyfunction]
fn model(text: &str) -> PyResult<String> {
    let model = veloid_engine::read_model(text).map_err(Failure::from)?;
    Ok(serde_json::to_string_pretty(&model).map_err(Failure::from)?)
}

/// How well a model predicts a ride, as a document. The bicycle is the model's where none is given.
#[pyfunction]
fn compare(
    py: Python<'_>,
    model: &str,
    sources: Vec<Source>,
    bike: Option<&str>,
    reading: &str,
    alpha: f64,
) -> PyResult<String> {
    on_ride(py, model, sources, bike, reading, |model, ride, bike| {
        let found = veloid_engine::compare(model, ride, bike, alpha)?;
        Ok(serde_json::to_string(&found)?)
    })
}

/// What a model predicts along a ride, from a start that suits it best or `at_rest`.
#[pyfunction]
fn predict<'py>(
    py: Python<'py>,
    model: &str,
    sources: Vec<Source>,
    bike: Option<&str>,
    reading: &str,
    at_rest: bool,
) -> PyResult<Columns<'py>> {
    let start = match at_rest {
        true => Start::AtRest,
        false => Start::Fitted,
    };
    let (times, axles) = on_ride(py, model, sources, bike, reading, |model, ride, bike| {
        Ok(veloid_engine::predict(model, ride, bike, start)?)
    })?;
    Ok(columns::of_prediction(py, &times, &axles))
}

/// Has `work` done with a model and a ride.
fn on_ride<T: Send>(
    py: Python<'_>,
    model: &str,
    sources: Vec<Source>,
    bike: Option<&str>,
    reading: &str,
    work: impl FnOnce(&IdentifiedModel, &Ride, &Bike) -> Result<T, Failure> + Send,
) -> PyResult<T> {
    let model = veloid_engine::read_model(model).map_err(Failure::from)?;
    let bike = match bike {
        Some(text) => Bike::from_json(text).map_err(Failure::from)?,
        None => model.bicycle.clone(),
    };
    let reading = input::options(reading)?;
    let sources = input::owned(py, sources)?;
    let pool = run::pool(None)?;
    run::beside(py, &pool, &Settings::default(), None, |_| {
        let ride = input::read(&sources, &bike, &reading)?;
        work(&model, &ride, &bike)
    })
}

/// What the command line says of a study's report.
#[pyfunction]
fn study_summary(report: &str) -> PyResult<String> {
    let report: StudyReport = serde_json::from_str(report).map_err(Failure::from)?;
    Ok(report.summary())
}

/// What the command line says of a report.
#[pyfunction]
fn summary(report: &str) -> PyResult<String> {
    let report: Report = serde_json::from_str(report).map_err(Failure::from)?;
    Ok(report::summary(&report))
}

/// A value with its 95 % interval, to as many digits as that allows.
#[pyfunction]
fn measured(value: f64, std_error: Option<f64>) -> String {
    Number::measured(value, std_error).to_string()
}

#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<Record>()?;
    module.add_function(wrap_pyfunction!(identify, module)?)?;
    module.add_function(wrap_pyfunction!(study, module)?)?;
    module.add_function(wrap_pyfunction!(study_summary, module)?)?;
    module.add_function(wrap_pyfunction!(simulate, module)?)?;
    module.add_function(wrap_pyfunction!(series, module)?)?;
    module.add_function(wrap_pyfunction!(model, module)?)?;
    module.add_function(wrap_pyfunction!(compare, module)?)?;
    module.add_function(wrap_pyfunction!(predict, module)?)?;
    module.add_function(wrap_pyfunction!(summary, module)?)?;
    module.add_function(wrap_pyfunction!(measured, module)?)
}
