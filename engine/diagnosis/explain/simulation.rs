//! What simulates the model that was found, for exports.

use std::ops::Range;

use veloid_core::bicycle::PerAxle;
use veloid_core::numerics::lanes::LANES;
use veloid_core::plant::Coefficients;
use veloid_methods::output_error::AxleFit;
use veloid_model::dataset::{Dataset, Track};
use veloid_model::effects::Kind;
use veloid_model::fit::{FINE, Fitted, Model, Point, Term, rest};
use veloid_report::simulation::{ActingEffect, AxleSimulation, Pitch, Simulation};

/// Largest angle (rad) through which an axle without effects turns in one step: the plain model's own solution is exact.
const PLAIN: f64 = 0.05;

/// The model on the record, whose axles without effects move by their plain fits; `held` are the held-out samples.
pub fn simulation(
    record: &Dataset,
    model: &Model,
    fits: &PerAxle<AxleFit>,
    held: Range<usize>,
) -> Simulation {
    let mut axles = PerAxle::default();
    for (t, track) in record.tracks.iter().enumerate() {
        let named = model.terms.iter().any(|term| term.acts_on(track.axle));
        let plain = fits.get(track.axle).filter(|_| !named);
        let found = match plain {
            Some(fit) => plain_axle(record, track, &fit.plain, &held),
            None => extended_axle(record, model, t, &held),
        };
        axles.set(track.axle, found);
    }
    Simulation {
        step_s: record.step,
        samples: record.samples,
        held_out: [held.start, held.end],
        axles,
        pitch: pitch(record, model),
    }
}

fn plain_axle(
    record: &Dataset,
    track: &Track,
    base: &Coefficients,
    held: &Range<usize>,
) -> AxleSimulation {
    let turns = base.kappa.abs().sqrt().max(base.beta.abs()) * record.step / PLAIN;
    let steps = match track.input.prescribed {
        true => 1,
        false => (turns.ceil() as usize).clamp(1, 20),
    };
    axle(track, base, held, steps)
}

fn extended_axle(record: &Dataset, model: &Model, t: usize, held: &Range<usize>) -> AxleSimulation {
    let (fit, a) = model.of_track(t);
    let track = &record.tracks[t];
    let points: [Point; LANES] = std::array::from_fn(|_| fit.point.clone());
    let lanes = fit.unit.lanes(record, &points, a);
    let base = &fit.point.base[a];
    AxleSimulation {
        rest_m: rest(track, &lanes).0[0],
        effects: effects(track, fit, base),
        ..axle(track, base, held, model.substeps(record, FINE))
    }
}

/// The axle without effects.
fn axle(track: &Track, base: &Coefficients, held: &Range<usize>, steps: usize) -> AxleSimulation {
    let mass = 1.0 / base.per_mass;
    let counted = held.clone().filter(|i| track.valid[*i]);
    let squares: Vec<f64> = counted.map(|i| track.measured[i].powi(2)).collect();
    AxleSimulation {
        prescribed: track.input.prescribed,
        mass_kg: mass,
        k_n_m: base.kappa * mass,
        b_n_s_m: base.beta * mass,
        constant_n: base.constant * mass,
        rest_m: 0.0,
        height_m: base.height,
        velocity_m_s: base.velocity,
        steps,
        road: track.has_road,
        force: track.input.force.is_some(),
        effects: Vec::new(),
        left_out: stretches(&track.valid, held),
        measured_rms: (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt(),
    }
}

fn effects(track: &Track, fit: &Fitted, base: &Coefficients) -> Vec<ActingEffect> {
    let terms = fit.unit.terms.iter().enumerate();
    terms
        .filter(|(_, term)| term.acts_on(track.axle))
        .map(|(i, term)| {
            let spec = term.kind.spec();
            let own = fit.point.initial[i];
            let initial = (0..spec.states).map(|q| match (spec.second_mass, q) {
                (true, 0) => base.height + own[0],
                (true, _) => base.velocity + own[1],
                (false, _) => own[q],
            });
            ActingEffect {
                id: term.kind.id_on(&track.scale).to_owned(),
                numbers: term.kind.numbers(&fit.point.values[i], &track.scale),
                law: term.kind.law(&track.scale),
                initial: initial.collect(),
                on_tyre: spec.carries,
            }
        })
        .collect()
}

/// How the axles push each other, if they do.
fn pitch(record: &Dataset, model: &Model) -> Option<Pitch> {
    let coupled = |fit: &&Fitted| fit.unit.terms.iter().any(is_pitch);
    let fit = model.fits.iter().find(coupled)?;
    let i = fit.unit.terms.iter().position(is_pitch)?;
    let [l_front_m, l_rear_m, mass_front_kg, mass_rear_kg] = record.geometry?;
    Some(Pitch {
        coupling: fit.point.values[i][0],
        l_front_m,
        l_rear_m,
        mass_front_kg,
        mass_rear_kg,
    })
}

fn is_pitch(term: &Term) -> bool {
    term.kind == Kind::PitchCoupling
}

/// Stretches of a range of samples that are not valid.
fn stretches(valid: &[bool], range: &Range<usize>) -> Vec<[usize; 2]> {
    let mut found: Vec<[usize; 2]> = Vec::new();
    for i in range.clone().filter(|i| !valid[*i]) {
        match found.last_mut() {
            Some(last) if last[1] == i => last[1] = i + 1,
            _ => found.push([i, i + 1]),
        }
    }
    found
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::example;
    use veloid_core::bicycle::Axle;

    #[test]
    fn stretches_that_do_not_count_are_listed() {
        let valid = [false, true, false, false, true, false];
        assert_eq!(stretches(&valid, &(1..6)), [[2, 4], [5, 6]]);
    }

    #[test]
    fn a_model_is_written_down_with_all_its_numbers() {
        let record = example::dataset();
        let friction = example::term(Kind::CoulombFriction, Axle::Front);
        let model = example::model(&record, &[(friction, 7.0)]);
        let simulation = simulation(&record, &model, &PerAxle::default(), 360..600);
        let front = simulation.axles.front.unwrap();
        let [base] = model.fits[0].point.base[..] else {
            panic!("one axle")
        };
        assert!((front.k_n_m - example::K).abs() < 1e-6);
        assert_eq!(
            (front.height_m, front.mass_kg),
            (base.height, example::FRONT)
        );
        let [effect] = &front.effects[..] else {
            panic!("{:?}", front.effects)
        };
        assert_eq!(effect.id, "coulomb_friction");
        assert_eq!(effect.numbers["friction"], 7.0);
        assert!(effect.numbers.contains_key("width"));
        assert_eq!(front.steps, model.substeps(&record, FINE));
        assert!(simulation.axles.rear.unwrap().effects.is_empty());
    }
}
