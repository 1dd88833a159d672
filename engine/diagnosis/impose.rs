//! Effects put into a simulated ride, by the same laws that the diagnosis looks for.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::bicycle::{Axle, Bike, PerAxle};
use crate::diagnosis::dataset::Dataset;
use crate::diagnosis::effects::Kind;
use crate::diagnosis::fit::{Point, Term, Unit};
use crate::diagnosis::law::{MAX_PARAMETERS, Values};
use crate::diagnosis::search::extend::candidates;
use crate::numerics::lanes::LANES;
use crate::output_error::AxleFit;
use crate::plant::Coefficients;
use crate::report::diagnosis::Place;
use crate::ride::Ride;
use crate::settings::within;
use crate::simulate::simulated_ride::SimulatedRide;
use crate::{EngineError, ImposedProblem, SettingProblem};

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
/// use veloid_engine::report::diagnosis::Place;
/// use veloid_engine::simulate::simulated_ride::SimulatedRide;
/// use veloid_engine::{Bike, EngineError, Imposed, Ride, simulate};
///
/// let simulated = SimulatedRide { duration_s: 5.0, ..SimulatedRide::default() };
/// let friction = Imposed {
///     id: "coulomb_friction".to_owned(),
///     axle: Place::Front,
///     parameters: BTreeMap::from([("friction".to_owned(), 40.0)]),
/// };
/// let plain = simulate(&simulated, &Bike::default(), &[])?;
/// let rubbing = simulate(&simulated, &Bike::default(), &[friction])?;
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
            initial: vec![[0.0; 2]; values.len()],
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
    Ok(simulated_ride.recorded(&fine))
}

/// The fine ride as the diagnosis would see it, with sizes and limits at the logger's rate.
fn dataset(simulated_ride: &SimulatedRide, bike: &Bike, fine: &Ride) -> Dataset {
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::Silent;
    use crate::diagnosis::effects::ALL;
    use crate::diagnosis::law::Need;
    use crate::report::diagnosis::{Diagnosis, Verdict};
    use crate::settings::Settings;
    use crate::simulate::simulated_ride::{SpeedChange, Spring};

    fn bike() -> Bike {
        Bike {
            mass_front_kg: Some(30.0),
            mass_rear_kg: Some(50.0),
            l_front_m: Some(0.6),
            l_rear_m: Some(0.45),
            wheel_radius_front_m: Some(0.34),
            wheel_radius_rear_m: Some(0.34),
            ..Bike::default()
        }
    }

    /// Half a minute with 30 um of noise, at a speed that swings, pedalling.
    fn simulated_ride() -> SimulatedRide {
        let spring = |mass_kg| {
            Some(Spring {
                mass_kg,
                k_n_m: 60e3,
                b_n_s_m: 500.0,
            })
        };
        SimulatedRide {
            duration_s: 30.0,
            speed_change: Some(SpeedChange {
                share: 0.3,
                period_s: 11.0,
            }),
            cadence_rpm: Some(80.0),
            wheelbase_m: 1.05,
            front: spring(30.0),
            rear: spring(50.0),
            noise_displacement_m: 3e-5,
            ..SimulatedRide::default()
        }
    }

    fn imposed(id: &str, axle: Place, parameters: &[(&str, f64)]) -> Imposed {
        Imposed {
            id: id.to_owned(),
            axle,
            parameters: parameters
                .iter()
                .map(|(n, v)| ((*n).to_owned(), *v))
                .collect(),
        }
    }

    fn diagnosed(effect: &Imposed) -> Diagnosis {
        let settings = Settings {
            trials: 1,
            iterations: 2,
            ..Settings::default()
        };
        let ride = ride(&simulated_ride(), &bike(), std::slice::from_ref(effect)).unwrap();
        crate::identify(&ride, &bike(), &settings, &Silent)
            .unwrap()
            .diagnosis
            .unwrap()
    }

    fn is_found(id: &str, axle: Place, parameters: &[(&str, f64)]) {
        let d = diagnosed(&imposed(id, axle, parameters));
        assert_eq!(d.verdict, Verdict::Named, "{}", d.sentence);
        assert_eq!(d.effects.len(), 1, "{}", d.sentence);
        assert_eq!((d.effects[0].id.as_str(), d.effects[0].axle), (id, axle));
        for (name, value) in parameters {
            let found = &d.effects[0].parameters[*name];
            assert!(
                (found.value / value - 1.0).abs() < 0.02,
                "{name}: {found:?}"
            );
        }
    }

    #[test]
    fn a_cubic_spring_is_found_again() {
        is_found("cubic_stiffness", Place::Front, &[("k3", 4e9)]);
    }

    #[test]
    fn a_late_sensor_is_found_again() {
        is_found("sensor_delay", Place::Rear, &[("delay", 0.008)]);
    }

    #[test]
    fn dry_friction_is_found_again() {
        is_found("coulomb_friction", Place::Front, &[("friction", 8.0)]);
    }

    #[test]
    fn a_wheel_out_of_round_is_found_again() {
        let parameters = [
            ("amplitude", 8e-4),
            ("phase", 1.1),
            ("rolling_radius", 0.337),
        ];
        is_found("wheel_out_of_round", Place::Rear, &parameters);
    }

    #[test]
    fn pitch_is_found_again() {
        let balanced = 80.0 * 0.6 * 0.45;
        is_found(
            "pitch_coupling",
            Place::Both,
            &[("pitch_inertia", 1.3 * balanced)],
        );
    }

    /// Every effect with what the first of its physical starts would report: it moves the axle, and values and reports agree.
    #[test]
    fn every_effect_can_be_imposed() {
        let simulated_ride = SimulatedRide {
            duration_s: 6.0,
            noise_displacement_m: 0.0,
            ..simulated_ride()
        };
        let fine = simulated_ride.fine();
        let dataset = dataset(&simulated_ride, &bike(), &fine);
        let plain = simulated_ride.ride();
        let (terms, off) = candidates(&dataset);
        let on_rigs = |kind: &Kind| kind.spec().needs.contains(&Need::PrescribedMotion);
        let rigs = ALL.iter().filter(|kind| on_rigs(kind));
        assert_eq!(off.len(), rigs.count(), "{off:?}");
        for kind in Kind::named().filter(|kind| !on_rigs(kind)) {
            let term = terms.iter().find(|t| t.kind == kind).unwrap();
            let track = dataset
                .tracks
                .iter()
                .find(|t| term.acts_on(t.axle))
                .unwrap();
            let physical = (kind.spec().starts)(&track.scale)
                .iter()
                .map(|start| (kind.spec().report)(start, &track.scale))
                .find(|report| report.iter().all(|p| p.physical))
                .unwrap();
            let parameters: Vec<_> = physical.iter().map(|p| (&*p.name, p.value)).collect();
            let effect = imposed(kind.id(), term.place, &parameters);
            let ride = ride(&simulated_ride, &bike(), &[effect]).unwrap();
            let [before, after] = [&plain, &ride].map(|r| r.axles.get(track.axle).unwrap());
            assert_eq!(before.road, after.road);
            assert!(before.displacement != after.displacement, "{}", kind.id());
        }
    }

    #[test]
    fn what_cannot_be_imposed_is_refused() {
        let steady = SimulatedRide {
            speed_change: None,
            cadence_rpm: None,
            rear: None,
            ..simulated_ride()
        };
        let one = |id, axle, parameters: &[(&str, f64)]| {
            let effect = imposed(id, axle, parameters);
            ride(&steady, &bike(), &[effect]).unwrap_err().to_string()
        };
        let front = Place::Front;
        for (found, expected) in [
            (
                one("square_wheel", front, &[]),
                "no such effect, expected one of cubic_stiffness, ",
            ),
            (
                one("power_damping", front, &[]),
                "no such effect, expected one of cubic_stiffness, ",
            ),
            (
                one("cubic_stiffness", Place::Rear, &[("k3", 1e9)]),
                "the axle can be front here",
            ),
            (one("cubic_stiffness", front, &[]), "k3 is missing"),
            (
                one("cubic_stiffness", front, &[("k4", 1.0)]),
                "no parameter 'k4', only k3",
            ),
            (
                one("cubic_stiffness", front, &[("k3", f64::NAN)]),
                "k3 = NaN is outside",
            ),
            (
                one("sensor_delay", front, &[("delay", 7.0)]),
                "delay = 7 is outside",
            ),
            (
                one("pitch_coupling", Place::Both, &[("pitch_inertia", 9.0)]),
                "both axles with",
            ),
            (
                one("stiffness_drift", Place::Both, &[("rate", 0.01)]),
                "the axle can be front",
            ),
            (
                one("load_transfer", Place::Both, &[("cog_height", 1.0)]),
                "no speed channel",
            ),
            (
                one("pedalling_force", front, &[("amplitude", 9.0)]),
                "no cadence channel",
            ),
        ] {
            assert!(found.contains(expected), "{found}");
        }
        let delay = imposed("sensor_delay", front, &[("delay", 0.01)]);
        let twice = [delay.clone(), delay];
        assert!(ride(&steady, &bike(), &twice).is_err());
    }
}
