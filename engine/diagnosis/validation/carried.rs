//! A model's numbers carried over to another ride.

use std::borrow::Cow;
use std::sync::Arc;

use super::Incomparable;
use crate::prepare::slower;
use veloid_core::bicycle::{Axle, Bike, PerAxle};
use veloid_core::plant::Coefficients;
use veloid_methods::output_error::AxleFit;
use veloid_model::dataset::Dataset;
use veloid_model::effects::{Kind, Shape, set_sizes};
use veloid_model::fit::{Point, Term, Unit};
use veloid_model::law::{AT_REST, Need, OwnLaw, Values};
use veloid_report::IdentifiedModel;
use veloid_report::diagnosis::{Base, EffectReport, Place};
use veloid_report::simulation::ActingEffect;
use veloid_ride::{AxleRecord, Ride};

/// Effects whose numbers say when or where something happened along the ride that they were found on.
const OF_ONE_RIDE: [Kind; 5] = [
    Kind::MassStep,
    Kind::StiffnessDrift,
    Kind::SensorDrift,
    Kind::WheelOutOfRound,
    Kind::PedallingForce,
];

/// Properties of the ride that an effect acts by; others only make it findable.
const ACTS_BY: [Need; 5] = [
    Need::Road,
    Need::Speed,
    Need::Cadence,
    Need::Geometry,
    Need::WheelRadius,
];

/// A ride with a model of it.
pub struct Carried {
    pub dataset: Dataset,
    pub terms: Vec<(Term, Values)>,
    /// What was not carried over, and why.
    pub left_out: Vec<String>,
}

impl Carried {
    pub fn new(model: &IdentifiedModel, ride: &Ride, bike: &Bike) -> Result<Self, Incomparable> {
        if ride.has_no_road() {
            return Err(Incomparable::NoInput);
        }
        let mut left_out = Vec::new();
        let model = &named(model, &mut left_out)?;
        let slower = slower(ride);
        let quieter = slower
            .as_ref()
            .map_or(1.0, |s| (ride.step_s / s.step_s).sqrt());
        let ride = slower.as_ref().unwrap_or(ride);
        let mut bike = Bike {
            noise_displacement_m: bike.noise_displacement_m.map(|noise| quieter * noise),
            ..bike.clone()
        };
        let mut fits = PerAxle::default();
        for axle in Axle::BOTH {
            let record = ride.axles.get(axle);
            match (numbers(model, axle, &bike, record), record) {
                (Ok(plain), Some(record)) => {
                    set_mass(&mut bike, axle, record, plain);
                    fits.set(axle, AxleFit::exact(plain, ride.samples));
                }
                (Ok(_), None) => {}
                // Neither the model nor the ride has it.
                (Err(_), None) if !is_in(model, axle) => {}
                (Err(why), _) => left_out.push(format!("{axle} axle: {why}")),
            }
        }
        if fits.iter().next().is_none() {
            return Err(Incomparable::NothingLeft(left_out));
        }
        let mut carried = Self {
            dataset: Dataset::new(ride, &bike, &fits, ride.samples),
            terms: Vec::new(),
            left_out,
        };
        for (track, record) in carried.dataset.tracks.iter_mut().filter_map(|track| {
            let record = ride.axles.get(track.axle)?;
            Some((track, record))
        }) {
            track.valid.clone_from(&record.valid);
        }
        if model.base == Base::Damper {
            carried.dataset.remove_springs();
        }
        carried.add_effects(model)?;
        Ok(carried)
    }

    fn add_effects(&mut self, model: &IdentifiedModel) -> Result<(), Incomparable> {
        let law = model
            .law
            .as_deref()
            .map(OwnLaw::read)
            .transpose()?
            .map(Arc::new);
        if let Some(law) = &law {
            self.dataset.set_law(law);
        }
        let simulated = model.simulation.iter().flat_map(|s| s.axles.iter());
        for (axle, effect) in
            simulated.flat_map(|(axle, s)| s.effects.iter().map(move |e| (axle, e)))
        {
            let kind = kind(effect, law.as_deref())?;
            let values = kind.values_numbered(&effect.numbers, law.as_deref());
            let values = values.map_err(|number| Incomparable::NoNumber {
                effect: effect.id.clone(),
                number,
            })?;
            let on_both = |e: &EffectReport| e.id == effect.id && e.axle == Place::Both;
            let place = match model.effects.iter().any(on_both) {
                true => Place::Both,
                false => Place::from(axle),
            };
            self.add(Term { kind, place }, values, axle, effect);
        }
        self.terms.sort_by_key(|(term, _)| *term);
        Ok(())
    }

    fn add(&mut self, term: Term, values: Values, axle: Axle, effect: &ActingEffect) {
        let Some(at) = self.dataset.tracks.iter().position(|t| t.axle == axle) else {
            return;
        };
        set_sizes(&mut self.dataset.tracks[at].scale, &effect.numbers);
        let track = &self.dataset.tracks[at];
        let name = format!("{} ({})", effect.id.replace('_', " "), term.place.name());
        if OF_ONE_RIDE.contains(&term.kind) {
            self.left_out.push(format!(
                "{name} is not in the comparison: its numbers say when or where on its own ride it acted"
            ));
            return;
        }
        let needs = term.kind.needs(&track.scale);
        let lacking = (needs.into_iter())
            .filter(|need| ACTS_BY.contains(need))
            .find_map(|need| self.dataset.lacks(track, need));
        match lacking {
            Some(why) => self
                .left_out
                .push(format!("{name} is not in the comparison: {why}")),
            None if self.terms.iter().all(|(known, _)| *known != term) => {
                self.terms.push((term, values));
            }
            None => {}
        }
    }

    /// Axles that move together, each with the model's numbers and a start at rest.
    pub fn units(&self, terms: &[(Term, Values)]) -> Vec<(Unit, Point)> {
        let names: Vec<Term> = terms.iter().map(|(term, _)| *term).collect();
        let units = Unit::all(&self.dataset, &names).into_iter();
        let with_start = |unit: Unit| {
            let values = unit.terms.iter().filter_map(|term| {
                let known = terms.iter().find(|(known, _)| known == term);
                known.map(|(_, values)| *values)
            });
            let point = Point {
                base: unit.tracks.iter().map(|t| self.start(*t)).collect(),
                values: values.collect(),
                initial: vec![AT_REST; unit.terms.len()],
            };
            (unit, point)
        };
        units.map(with_start).collect()
    }

    /// The same with the plain model, without effects.
    pub fn plain_units(&self, model: &IdentifiedModel) -> Vec<(Unit, Point)> {
        let mut units = self.units(&[]);
        for (unit, point) in &mut units {
            for (t, base) in unit.tracks.iter().zip(&mut point.base) {
                if let Some(plain) = model.plain.get(self.dataset.tracks[*t].axle) {
                    base.kappa = plain.k_n_m * base.per_mass;
                    base.beta = plain.b_n_s_m * base.per_mass;
                }
            }
        }
        units
    }

    fn start(&self, track: usize) -> Coefficients {
        let track = &self.dataset.tracks[track];
        let first = track.valid.iter().position(|valid| *valid).unwrap_or(0);
        let height = match track.plant.moves() {
            true => track.measured[first],
            false => 0.0,
        };
        Coefficients {
            height,
            ..track.plain()
        }
    }
}

/// The model without effects that did not explain the ride that they come from.
fn named<'m>(
    model: &'m IdentifiedModel,
    left_out: &mut Vec<String>,
) -> Result<Cow<'m, IdentifiedModel>, Incomparable> {
    let acting = (model.simulation.iter()).flat_map(|s| s.axles.iter());
    let acts = acting.into_iter().any(|(_, axle)| !axle.effects.is_empty());
    let is_named = model.effects.iter().all(|effect| effect.adequate);
    if !model.effects.is_empty() && is_named && !acts {
        return Err(Incomparable::NoSimulation);
    }
    if is_named || model.effects.is_empty() {
        return Ok(Cow::Borrowed(model));
    }
    left_out.push(
        "the effects that come nearest do not explain the ride that the model comes from: the plain model is compared"
            .to_owned(),
    );
    Ok(Cow::Owned(IdentifiedModel {
        effects: Vec::new(),
        simulation: None,
        ..model.clone()
    }))
}

fn kind(effect: &ActingEffect, law: Option<&OwnLaw>) -> Result<Kind, Incomparable> {
    let own = law.filter(|law| law.id == effect.id);
    let own = own.map(|law| Kind::Own(Shape::of(law)));
    own.or_else(|| Kind::by_id(&effect.id))
        .ok_or_else(|| Incomparable::UnknownEffect(effect.id.clone()))
}

fn is_in(model: &IdentifiedModel, axle: Axle) -> bool {
    let simulated = model.simulation.as_ref().and_then(|s| s.axles.get(axle));
    simulated.is_some() || model.plain.get(axle).is_some()
}

/// The plain numbers of an axle on this ride, or why there are none.
fn numbers(
    model: &IdentifiedModel,
    axle: Axle,
    bike: &Bike,
    record: Option<&AxleRecord>,
) -> Result<Coefficients, String> {
    let of_result = model.result.get(axle);
    let withheld = |name: &str| of_result.and_then(|result| result.withheld(name));
    if let Some(why) = withheld("k").or_else(|| withheld("B")) {
        return Err(format!(
            "the model has no number that could be compared: {why}"
        ));
    }
    let simulated = model.simulation.as_ref().and_then(|s| s.axles.get(axle));
    let [k, b, mass] = match (simulated, model.plain.get(axle)) {
        (Some(s), _) if s.prescribed => [s.k_n_m, s.b_n_s_m, 0.0],
        (Some(s), _) => [s.k_n_m, s.b_n_s_m, s.mass_kg],
        (None, Some(e)) => [e.k_n_m, e.b_n_s_m, e.mass_kg],
        (None, None) => return Err("not in the model".to_owned()),
    };
    let record = record.ok_or("not recorded on this ride with what drives it")?;
    let mass = match record.prescribed {
        true => 1.0,
        false => bike.mass(axle).unwrap_or(mass),
    };
    if !(mass > 0.0) {
        return Err("its mass is neither in the model nor in the bike file".to_owned());
    }
    Ok(Coefficients {
        kappa: k / mass,
        beta: b / mass,
        per_mass: 1.0 / mass,
        ..Coefficients::default()
    })
}

/// Has the bicycle carry the mass of the comparison, so that no fit moves it.
fn set_mass(bike: &mut Bike, axle: Axle, record: &AxleRecord, plain: Coefficients) {
    let mass = match axle {
        Axle::Front => &mut bike.mass_front_kg,
        Axle::Rear => &mut bike.mass_rear_kg,
    };
    if !record.prescribed && mass.is_none() {
        *mass = Some(plain.mass());
    }
}
