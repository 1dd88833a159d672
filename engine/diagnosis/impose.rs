//! Effects put into a simulated ride, by the same laws that the diagnosis looks for.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::search::extend::candidates;
use veloid_core::bicycle::{Axle, Bike, PerAxle};
use veloid_core::numerics::lanes::LANES;
use veloid_core::plant::Coefficients;
use veloid_core::settings::within;
use veloid_core::{EngineError, ImposedProblem, SettingProblem};
use veloid_methods::output_error::AxleFit;
use veloid_methods::simulate::simulated_ride::{FINE, SimulatedRide};
use veloid_model::dataset::Dataset;
use veloid_model::effects::Kind;
use veloid_model::fit::{Point, Term, Unit};
use veloid_model::law::{AT_REST, MAX_PARAMETERS, Values};
use veloid_report::diagnosis::Place;
use veloid_ride::Ride;

/// An effect, with its parameters as reports give them.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Imposed {
    /// Id in the library, such as `coulomb_friction`.
    pub id: String,
    /// The axle or axles that it acts on.
    pub axle: Place,
    /// All of its parameters by name, each in the unit that docs/effects.md gives.
    pub parameters: BTreeMap<String, f64>,
}

/// Effects that may act at once, as many as are looked for.
const MOST: usize = 3;
/// Samples that one simulation with effects may write.
const MOST_SAMPLES: usize = 1_000_000;
/// Largest angle (rad) that the stiffest axle turns through in one step of the integrator.
const ANGLE: f64 = 0.02;

/// The ride as it would be recorded with these effects at work.
///
/// # Errors
/// What cannot be simulated: an unknown effect, a wrong axle or parameter, a ride that lacks what the
/// effect needs.
///
/// ```
/// use std::collections::BTreeMap;
/// use veloid_core::{Bike, EngineError};
/// use veloid_diagnosis::impose::{Imposed, ride};
/// use veloid_methods::simulate::simulated_ride::SimulatedRide;
/// use veloid_report::diagnosis::Place;
/// use veloid_ride::Ride;
///
/// let simulated = SimulatedRide { duration_s: 5.0, ..SimulatedRide::default() };
/// let friction = Imposed {
///     id: "coulomb_friction".to_owned(),
///     axle: Place::Front,
///     parameters: BTreeMap::from([("friction".to_owned(), 40.0)]),
/// };
/// let plain = ride(&simulated, &Bike::default(), &[])?;
/// let rubbing = ride(&simulated, &Bike::default(), &[friction])?;
/// assert_eq!((plain.samples, rubbing.samples), (501, 501));
/// // 40 N of dry friction hold the front wheel nearer to the road.
/// let spread = |ride: &Ride| {
///     let front = ride.axles.front.as_ref().unwrap();
///     let pairs = front.road.iter().zip(&front.displacement);
///     pairs.map(|(u, z)| (u - z) * (u - z)).sum::<f64>()
/// };
/// assert!(spread(&rubbing) < 0.9 * spread(&plain));
/// let roads = [&plain, &rubbing].map(|ride| &ride.axles.front.as_ref().unwrap().road);
/// assert_eq!(roads[0], roads[1]);
/// # Ok::<(), EngineError>(())
/// ```
pub fn ride(
    simulated_ride: &SimulatedRide,
    bike: &Bike,
    effects: &[Imposed],
) -> Result<Ride, EngineError> {
    simulated_ride.validate()?;
    if effects.is_empty() {
        return Ok(simulated_ride.ride());
    }
    Ok(simulated_ride.recorded(&moved(simulated_ride, bike, effects)?))
}

/// The same as two accelerometers with white noise (m/s^2, standard deviation) and a speed sensor record it.
///
/// # Errors
/// As of [`ride`].
pub fn sensed(
    simulated_ride: &SimulatedRide,
    bike: &Bike,
    effects: &[Imposed],
    noise: f64,
) -> Result<Ride, EngineError> {
    if effects.is_empty() {
        return simulated_ride.sensed(noise);
    }
    simulated_ride.validate()?;
    let fine = moved(simulated_ride, bike, effects)?;
    let accelerations = fine.axles.map(|_, record| {
        let z = &record.displacement;
        let last = z.len().saturating_sub(2);
        let at = |i: usize| {
            let i = i.clamp(1, last.max(1));
            (z[i + 1] - 2.0 * z[i] + z[i - 1]) / (fine.step_s * fine.step_s)
        };
        (0..z.len()).step_by(FINE).map(at).collect()
    });
    simulated_ride.accelerations(&accelerations, noise)
}

/// The fine ride as it moves with these effects.
fn moved(
    simulated_ride: &SimulatedRide,
    bike: &Bike,
    effects: &[Imposed],
) -> Result<Ride, EngineError> {
    within("number of effects", effects.len() as f64, 0.0, MOST as f64)?;
    let samples = simulated_ride.samples() as f64;
    within("samples with effects", samples, 0.0, MOST_SAMPLES as f64)?;
    let mut fine = simulated_ride.fine();
    let dataset = dataset(simulated_ride, bike, &fine);
    let mut chosen: Vec<(Term, Values)> = Vec::new();
    for effect in effects {
        let term = effect.term(&dataset)?;
        if chosen.iter().any(|(other, _)| *other == term) {
            return Err(effect.wrong(ImposedProblem::Twice));
        }
        chosen.push((term, effect.values(&dataset, term)?));
    }
    chosen.sort_by_key(|(term, _)| *term);
    let terms: Vec<Term> = chosen.iter().map(|(term, _)| *term).collect();
    for unit in Unit::all(&dataset, &terms) {
        let acting = |(term, _): &&(Term, Values)| unit.terms.contains(term);
        let values: Vec<Values> = chosen.iter().filter(acting).map(|(_, v)| *v).collect();
        let point = Point {
            base: unit.tracks.iter().map(|t| plain(&dataset, *t)).collect(),
            initial: vec![AT_REST; values.len()],
            values,
        };
        let turn = unit.fastest(&dataset, &point) * dataset.step;
        let substeps = ((turn / ANGLE).ceil() as usize).clamp(4, 40);
        let points: [Point; LANES] = std::array::from_fn(|_| point.clone());
        let moved = unit.simulate(&dataset, &points, None, 0..dataset.samples, substeps);
        for (t, z) in unit.tracks.iter().zip(moved) {
            let axle = dataset.tracks[*t].axle;
            let z: Vec<f64> = z.iter().map(|lanes| lanes.0[0]).collect();
            if !z.iter().all(|z| z.is_finite()) {
                return Err(wrong(SettingProblem::RunsAway));
            }
            if let Some(record) = fine.axles.get(axle) {
                let mut record = record.clone();
                record.displacement = z;
                fine.axles.set(axle, record);
            }
        }
    }
    Ok(fine)
}

/// The fine ride as the diagnosis would see it, with sizes and limits at the logger's rate.
pub fn dataset(simulated_ride: &SimulatedRide, bike: &Bike, fine: &Ride) -> Dataset {
    let springs = [
        (Axle::Front, simulated_ride.front),
        (Axle::Rear, simulated_ride.rear),
    ];
    let mut fits = PerAxle::default();
    for (axle, spring) in springs {
        let (Some(spring), Some(record)) = (spring, fine.axles.get(axle)) else {
            continue;
        };
        let plain = Coefficients {
            kappa: spring.k_n_m / spring.mass_kg,
            beta: spring.b_n_s_m / spring.mass_kg,
            per_mass: 1.0 / spring.mass_kg,
            constant: 0.0,
            height: record.displacement[0],
            velocity: 0.0,
        };
        fits.set(axle, AxleFit::exact(plain, fine.samples));
    }
    let mut dataset = Dataset::new(fine, bike, &fits, fine.samples);
    for track in &mut dataset.tracks {
        track.scale.step = 1.0 / simulated_ride.rate_hz;
    }
    dataset
}

/// The plain model's numbers on one track, from the start at rest.
fn plain(dataset: &Dataset, track: usize) -> Coefficients {
    let track = &dataset.tracks[track];
    Coefficients {
        height: track.measured[0],
        ..track.plain()
    }
}

impl Imposed {
    fn term(&self, dataset: &Dataset) -> Result<Term, EngineError> {
        let kind = Kind::by_id(&self.id)
            .filter(|kind| !kind.spec().is_general)
            .ok_or_else(|| self.wrong(ImposedProblem::Unknown { known: ids() }))?;
        let (terms, switched_off) = candidates(dataset);
        let places: Vec<Place> = terms
            .iter()
            .filter(|term| term.kind == kind)
            .map(|term| term.place)
            .collect();
        if places.contains(&self.axle) {
            return Ok(Term {
                kind,
                place: self.axle,
            });
        }
        let lacking = switched_off.iter().find(|off| off.id == self.id);
        Err(match (places.is_empty(), lacking) {
            (true, Some(off)) => self.wrong(ImposedProblem::Lacking {
                why: off.why.clone(),
            }),
            _ => {
                let possible = places.into_iter().map(Place::name).collect();
                self.wrong(ImposedProblem::Axle { possible })
            }
        })
    }

    fn values(&self, dataset: &Dataset, term: Term) -> Result<Values, EngineError> {
        let acted = dataset.tracks.iter().find(|t| term.acts_on(t.axle));
        let Some(track) = acted else {
            return Err(self.wrong(ImposedProblem::NotSimulated));
        };
        let report = |values: &Values| (term.kind.spec().report)(values, &track.scale);
        let known = report(&[1.0; MAX_PARAMETERS]);
        let names = || known.iter().map(|p| p.name.to_string()).collect();
        if let Some(name) =
            (self.parameters.keys()).find(|name| known.iter().all(|p| p.name != **name))
        {
            return Err(self.wrong(ImposedProblem::UnknownParameter {
                name: name.clone(),
                known: names(),
            }));
        }
        let parameter = |name: &str| self.parameters.get(name).copied();
        let values = term.kind.values_named(parameter, &track.scale);
        let values = values.map_err(|name| {
            self.wrong(ImposedProblem::MissingParameter {
                name: name.into_owned(),
                known: names(),
            })
        })?;
        for back in report(&values) {
            let given = parameter(&back.name).unwrap_or(f64::NAN);
            if !back.physical || !((back.value - given).abs() <= 1e-9 * given.abs()) {
                return Err(self.wrong(ImposedProblem::OutOfRange {
                    name: back.name.to_string(),
                    value: given,
                }));
            }
        }
        Ok(values)
    }

    fn wrong(&self, problem: ImposedProblem) -> EngineError {
        let id = self.id.clone();
        wrong(SettingProblem::Effect { id, problem })
    }
}

fn ids() -> Vec<&'static str> {
    Kind::named().map(Kind::id).collect()
}

fn wrong(problem: SettingProblem) -> EngineError {
    EngineError::Setting {
        name: "effect",
        problem,
    }
}
