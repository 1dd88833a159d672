//! A short ride and models of it that were never fitted, for tests here and in the diagnosis.
#![allow(clippy::unwrap_used)]

use nalgebra::DMatrix;

use super::dataset::Dataset;
use super::effects::Kind;
use super::fit::{Fitted, Fitter, Model, Point, Term, Unit};
use super::law::{AT_REST, MAX_PARAMETERS, Values};
use veloid_core::bicycle::{Axle, Bike, PerAxle};
use veloid_core::numerics::autoregressive::NoiseModel;
use veloid_core::plant::Coefficients;
use veloid_methods::output_error::AxleFit;
use veloid_methods::simulate::simulated_ride::{SimulatedRide, Spring};
use veloid_report::diagnosis::Place;

/// Stiffness (N/m) and damping (N s/m) of both axles, and what each carries (kg).
pub const K: f64 = 60e3;
pub const B: f64 = 500.0;
pub const FRONT: f64 = 25.0;
pub const REAR: f64 = 50.0;
/// Deviation (m) of the noise that every model is given.
pub const NOISE: f64 = 1e-4;

/// Six seconds of the plain model on a road without any noise.
pub fn dataset() -> Dataset {
    loaded(FRONT, REAR)
}

/// The same with other masses (kg).
pub fn loaded(front: f64, rear: f64) -> Dataset {
    let spring = |mass_kg| Spring {
        mass_kg,
        k_n_m: K,
        b_n_s_m: B,
    };
    let simulated_ride = SimulatedRide {
        duration_s: 6.0,
        front: Some(spring(front)),
        rear: Some(spring(rear)),
        ..SimulatedRide::default()
    };
    let ride = simulated_ride.ride();
    let bike = Bike {
        mass_front_kg: Some(front),
        mass_rear_kg: Some(rear),
        ..Bike::default()
    };
    let mut fits = PerAxle::default();
    for (axle, record) in ride.axles.iter() {
        let mass = bike.mass(axle).unwrap();
        let plain = Coefficients {
            kappa: K / mass,
            beta: B / mass,
            per_mass: 1.0 / mass,
            height: record.displacement[0],
            ..Coefficients::default()
        };
        fits.set(axle, AxleFit::exact(plain, ride.samples));
    }
    Dataset::new(&ride, &bike, &fits, train_end(ride.samples))
}

/// Samples that are fitted of so many.
pub fn train_end(samples: usize) -> usize {
    3 * samples / 4
}

pub fn fitter(dataset: &Dataset) -> Fitter<'_> {
    Fitter {
        dataset,
        samples: train_end(dataset.samples),
    }
}

pub fn term(kind: Kind, axle: Axle) -> Term {
    let place = Place::from(axle);
    Term { kind, place }
}

/// The plain springs and dampers of a unit's axles, with effects of these values in its order.
pub fn point(dataset: &Dataset, unit: &Unit, values: Vec<Values>) -> Point {
    let base = unit.tracks.iter().map(|t| {
        let track = &dataset.tracks[*t];
        let mass = track.scale.mass;
        Coefficients {
            kappa: K / mass,
            beta: B / mass,
            per_mass: 1.0 / mass,
            height: track.measured[0],
            ..Coefficients::default()
        }
    });
    Point {
        base: base.collect(),
        initial: vec![AT_REST; values.len()],
        values,
    }
}

/// The model with some effects of such first values.
pub fn model(dataset: &Dataset, effects: &[(Term, f64)]) -> Model {
    let terms: Vec<Term> = effects.iter().map(|(term, _)| *term).collect();
    let value = |term: &Term| {
        let mut values = [0.0; MAX_PARAMETERS];
        let known = effects.iter().find(|(known, _)| known == term);
        values[0] = known.map_or(0.0, |(_, value)| *value);
        values
    };
    let fit = |unit: Unit| {
        let slots = unit.slots(dataset).len();
        Fitted {
            point: point(dataset, &unit, unit.terms.iter().map(value).collect()),
            residuals: vec![vec![0.0; train_end(dataset.samples)]; unit.tracks.len()],
            noise_models: vec![NoiseModel::white(NOISE * NOISE); unit.tracks.len()],
            likelihood: 0.0,
            covariance: DMatrix::identity(slots, slots),
            unit,
        }
    };
    let fits = Unit::all(dataset, &terms).into_iter().map(fit);
    Model::new(terms, fits.collect())
}

/// The same with another likelihood (nats).
pub fn likely(mut model: Model, likelihood: f64) -> Model {
    model.likelihood = likelihood;
    model
}
