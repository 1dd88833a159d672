//! Stage `observe`: observer, least squares and instrumental variables on every axle of a ride.

use crate::replay::accuracy;
use veloid_core::bicycle::load::wheel_load;
use veloid_core::bicycle::{Axle, Bike, GRAVITY, PerAxle};
use veloid_core::numerics::spline::slopes;
use veloid_core::settings::Settings;
use veloid_core::{EngineError, RideProblem};
use veloid_latent_road::latent_road;
use veloid_methods::least_squares::{
    Deflection, Found, Record, estimates, instrumental, least_squares,
};
use veloid_methods::observer::{States, differentiate_all, jerk_bound};
use veloid_methods::roll::roll;
use veloid_methods::simulate::linear::Input;
use veloid_mistakes::misread;
use veloid_report::stages::Observed;
use veloid_report::{Estimate, Mistake, ObserverReport};
use veloid_ride::{AxleRecord, Ride};

/// What is visible at once: paper section 3 and 4 on every axle.
///
/// An axle on which a rig prescribes the motion has no states to observe, and nothing is said of it here.
///
/// # Errors
/// A null mass without a force channel; an axle whose motion does not determine k and B.
pub fn observe(ride: &Ride, bike: &Bike, settings: &Settings) -> Result<Observed, EngineError> {
    observed(ride, bike, settings).map_err(|error| match error {
        EngineError::Ride {
            axle,
            problem: RideProblem::Undetermined { method },
        } => match misread(ride, bike) {
            Some(Mistake { sentence, .. }) => EngineError::Ride {
                axle,
                problem: RideProblem::Misread { sentence },
            },
            None => undetermined(axle, method),
        },
        other => other,
    })
}

fn observed(ride: &Ride, bike: &Bike, settings: &Settings) -> Result<Observed, EngineError> {
    let ride = &*ride.with_masses();
    let watched = watch(ride, settings);
    let records = ride
        .axles
        .try_map(|axle, record| regressed(axle, record, ride, bike))?;
    let squares = records.try_map(|axle, record| {
        watched
            .get(axle)
            .and_then(|w| w.least_squares(record))
            .ok_or_else(|| undetermined(axle, "least squares"))
    })?;
    let instruments = records.try_map(|axle, record| {
        squares
            .get(axle)
            .and_then(|found| instrumental(record, found.theta))
            .ok_or_else(|| undetermined(axle, "instrumental variables"))
    })?;
    let (least_squares, recursive) = estimates(&squares, ride, bike);
    let (instrumental, _) = estimates(&instruments, ride, bike);
    let reported =
        |estimates: PerAxle<Estimate>| estimates.map(|_, e| e.clone().within_reach(ride.step_s));
    let (least_squares, instrumental) = (reported(least_squares), reported(instrumental));
    for (found, method) in [
        (&least_squares, "least squares"),
        (&instrumental, "instrumental variables"),
    ] {
        if let Some((axle, _)) = found.iter().find(|(_, e)| !e.is_finite()) {
            return Err(undetermined(axle, method));
        }
    }
    let front_load = watched.front.as_ref().and_then(|w| {
        let (record, estimate) = (records.front.as_ref()?, instrumental.front.as_ref()?);
        let static_load = bike
            .static_load(Axle::Front)
            .unwrap_or(estimate.mass_kg * GRAVITY);
        Some(w.load(record, static_load, estimate))
    });
    Ok(Observed {
        observer: watched.map(|_, w| w.report.clone()),
        least_squares,
        instrumental,
        recursive,
        roll: roll(ride, bike, front_load.as_deref()),
        latent_road: latent_road(ride, bike),
    })
}

fn undetermined(axle: Axle, method: &'static str) -> EngineError {
    EngineError::Ride {
        axle,
        problem: RideProblem::Undetermined { method },
    }
}

/// One axle through the observer.
pub struct Watched {
    pub states: States,
    /// The road by the same differentiator; none where the ground is at rest.
    road: Option<States>,
    pub report: ObserverReport,
}

/// Runs the observers of z and u of every axle.
pub fn watch(ride: &Ride, settings: &Settings) -> PerAxle<Watched> {
    let step = ride.step_s;
    let mut signals: Vec<(&[f64], f64)> = Vec::new();
    for (_, record) in ride.axles.iter() {
        let z = record.displacement.as_slice();
        let bound = |x: &[f64]| jerk_bound(x, &record.valid, step);
        signals.push((z, settings.jerk_bound_m_s3.unwrap_or_else(|| bound(z))));
        if record.has_road() {
            signals.push((&record.road, bound(&record.road)));
        }
    }
    let bounds: Vec<f64> = signals.iter().map(|(_, f)| *f).collect();
    let mut followed = differentiate_all(&signals, step).into_iter().zip(bounds);
    ride.axles.map(|_, record| {
        let mut next = || followed.next().unwrap_or_default();
        let (states, f) = next();
        let road = record.has_road().then(|| next().0);
        let z = &record.displacement;
        let report = accuracy(&states, z, &slopes(z, step), &record.valid, step, f);
        Watched {
            states,
            road,
            report,
        }
    })
}

impl Watched {
    /// u - z^, u'^ - z'^ and what else moves the axle.
    fn deflection<'a>(&self, record: &'a Record) -> Deflection<'a> {
        let minus = |road: Option<&Vec<f64>>, state: &[f64]| match road {
            Some(u) => u.iter().zip(state).map(|(u, x)| u - x).collect(),
            None => state.iter().map(|x| -x).collect(),
        };
        let road = self.road.as_ref();
        Deflection {
            value: minus(road.map(|_| &record.input.road), &self.states.position),
            rate: minus(road.map(|r| &r.velocity), &self.states.velocity),
            force: record.input.force.as_ref().map(|(f, _)| f.as_slice()),
        }
    }

    fn least_squares(&self, record: &Record) -> Option<Found> {
        let first = (self.report.converged_after_s / record.step_s).round() as usize;
        let deflection = self.deflection(record);
        least_squares(record, &deflection, &self.states.acceleration, first)
    }

    /// The wheel load at every sample (N).
    fn load(&self, record: &Record, static_load: f64, e: &Estimate) -> Vec<f64> {
        let deflection = self.deflection(record);
        let pairs = deflection.value.iter().zip(&deflection.rate);
        pairs
            .map(|(d, w)| wheel_load(static_load, e.k_n_m, e.b_n_s_m, *d, *w))
            .collect()
    }
}

fn regressed<'a>(
    axle: Axle,
    record: &'a AxleRecord,
    ride: &Ride,
    bike: &Bike,
) -> Result<Record<'a>, EngineError> {
    let mass = bike.mass_or_force(axle, record.force.is_some())?;
    Ok(Record {
        step_s: ride.step_s,
        input: Input::of(record, ride.step_s),
        displacement: &record.displacement,
        valid: &record.valid,
        mass,
        rest_point: record.force.is_some() || !record.has_road(),
    })
}
