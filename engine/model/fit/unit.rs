//! Extended models: which effects act where, and the numbers that a fit may move.

use std::ops::Range;

use super::integrate::{AxleLanes, EffectLanes, run, sensed};
use crate::dataset::{Dataset, Track};
use crate::effects::Kind;
use crate::law::{Initial, Scale, Spec, Values};
use veloid_core::bicycle::Axle;
use veloid_core::numerics::lanes::{LANES, Lanes};
use veloid_core::plant::{Coefficient, Coefficients};
use veloid_report::diagnosis::Place;

/// An effect at its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Term {
    pub kind: Kind,
    pub place: Place,
}

impl Term {
    pub fn acts_on(&self, axle: Axle) -> bool {
        self.place.acts_on(axle)
    }

    /// The id in reports.
    pub fn id<'s>(&self, dataset: &'s Dataset) -> &'s str {
        let acted = dataset.tracks.iter().find(|track| self.acts_on(track.axle));
        acted.map_or(self.kind.id(), |track| self.kind.id_on(&track.scale))
    }
}

/// Axles that are fitted together, because an effect acts on both or each for itself.
#[derive(Clone, Debug, PartialEq)]
pub struct Unit {
    /// Indices into [`Dataset::tracks`].
    pub tracks: Vec<usize>,
    /// In the order in which the effects act.
    pub terms: Vec<Term>,
}

impl Unit {
    /// The units of a set of terms.
    pub fn all(dataset: &Dataset, terms: &[Term]) -> Vec<Unit> {
        let mut terms = terms.to_vec();
        terms.sort();
        let indices: Vec<usize> = (0..dataset.tracks.len()).collect();
        if terms.iter().any(|t| t.place == Place::Both) {
            return vec![Unit {
                tracks: indices,
                terms,
            }];
        }
        indices
            .into_iter()
            .map(|i| Unit {
                tracks: vec![i],
                terms: terms
                    .iter()
                    .copied()
                    .filter(|t| t.acts_on(dataset.tracks[i].axle))
                    .collect(),
            })
            .collect()
    }

    fn coupled(&self) -> Option<usize> {
        self.terms
            .iter()
            .position(|t| t.kind == Kind::PitchCoupling)
    }

    /// Coefficients that a fit may move.
    pub fn slots(&self, dataset: &Dataset) -> Vec<Slot> {
        let mut slots = Vec::new();
        for (a, t) in self.tracks.iter().enumerate() {
            let track = &dataset.tracks[*t];
            let free = Coefficient::ALL.into_iter().filter(|n| track.is_free(*n));
            slots.extend(free.map(|number| Slot::Base(a, number)));
        }
        for (i, term) in self.terms.iter().enumerate() {
            let spec = term.kind.spec();
            slots.extend((0..spec.parameters.len()).map(|q| Slot::Value(i, q)));
            // Where nothing drives the axle, where a second mass starts is half of what it does.
            let track = &dataset.tracks[self.tracks[0]];
            let driven = track.has_road || track.input.force.is_some();
            if spec.second_mass && !driven {
                slots.extend([Slot::Initial(i, 0), Slot::Initial(i, 1)]);
            }
        }
        slots
    }

    /// Whether a slot changes the motion of the unit's axle `a`.
    pub fn touches(&self, dataset: &Dataset, slot: Slot, a: usize) -> bool {
        let axle = dataset.tracks[self.tracks[a]].axle;
        match slot {
            _ if self.coupled().is_some() => true,
            Slot::Base(of, _) => of == a,
            Slot::Value(i, _) | Slot::Initial(i, _) => self.terms[i].acts_on(axle),
        }
    }

    /// A typical size and the limits of a slot.
    pub fn range(&self, dataset: &Dataset, slot: Slot) -> (f64, [f64; 2]) {
        match slot {
            Slot::Base(a, number) => dataset.tracks[self.tracks[a]].range(number),
            Slot::Value(i, q) => {
                let scale = self.scale(dataset, i);
                let parameter = &self.terms[i].kind.spec().parameters[q];
                ((parameter.size)(scale), (parameter.limits)(scale))
            }
            Slot::Initial(i, q) => {
                let s = self.scale(dataset, i);
                // Of a second mass; else of an effect's own state, a deflection.
                let size = match (self.terms[i].kind.spec().second_mass, q) {
                    (true, 0) => s.z_rms,
                    (true, _) => s.v_rms,
                    (false, _) => s.d_rms,
                };
                (0.1 * size, [f64::NEG_INFINITY, f64::INFINITY])
            }
        }
    }

    /// The nearest point within the user's limits.
    pub fn within(&self, dataset: &Dataset, mut point: Point) -> Point {
        for (base, t) in point.base.iter_mut().zip(&self.tracks) {
            *base = dataset.tracks[*t].within(*base);
        }
        point
    }

    /// Sizes on the axle that a term acts on; the front's for both.
    pub fn scale<'s>(&self, dataset: &'s Dataset, term: usize) -> &'s Scale {
        let acted = self
            .tracks
            .iter()
            .find(|t| self.terms[term].acts_on(dataset.tracks[**t].axle));
        &dataset.tracks[*acted.unwrap_or(&self.tracks[0])].scale
    }

    /// The stiffest axle's turn (rad/s).
    pub fn fastest(&self, dataset: &Dataset, point: &Point) -> f64 {
        let mut fastest: f64 = 0.0;
        for t in &self.tracks {
            let track = &dataset.tracks[*t];
            if track.input.prescribed {
                continue;
            }
            let s = &track.scale;
            let added = self.added(track, point, |spec, values, s| (spec.stiffens)(values, s));
            fastest = fastest.max((s.k_size().min(4.0 * s.k.abs()) + added) / s.mass);
        }
        fastest.sqrt()
    }

    /// The most damped axle's decay (1/s).
    pub fn decay(&self, dataset: &Dataset, point: &Point) -> f64 {
        let decays = self.tracks.iter().zip(&point.base).map(|(t, base)| {
            let track = &dataset.tracks[*t];
            if track.input.prescribed {
                return 0.0;
            }
            base.beta.abs()
                + self.added(track, point, |spec, values, s| (spec.damps)(values, s))
                    / track.scale.mass
        });
        decays.fold(0.0, f64::max)
    }

    /// What the effects add on a track to some size of it.
    fn added(
        &self,
        track: &Track,
        point: &Point,
        size: impl Fn(&Spec, &Values, &Scale) -> f64,
    ) -> f64 {
        let effects = self.terms.iter().zip(&point.values);
        effects
            .filter(|(term, _)| term.acts_on(track.axle))
            .map(|(term, values)| size(term.kind.spec(), values, &track.scale))
            .sum()
    }

    /// Readings of the displacement sensors, or of the force where the motion is prescribed, for eight points over a span of
    /// samples that begins in the points' starting states, by axle of the unit; only those of `wanted` when one axle is enough.
    pub fn simulate(
        &self,
        dataset: &Dataset,
        points: &[Point; LANES],
        wanted: Option<usize>,
        span: Range<usize>,
        substeps: usize,
    ) -> Vec<Vec<Lanes>> {
        let chosen: Vec<usize> = match wanted {
            Some(a) => vec![a],
            None => (0..self.tracks.len()).collect(),
        };
        let lanes: Vec<AxleLanes> = chosen
            .iter()
            .map(|a| self.lanes(dataset, points, *a))
            .collect();
        let axles: Vec<_> = chosen
            .iter()
            .zip(&lanes)
            .map(|(a, l)| (&dataset.tracks[self.tracks[*a]], l))
            .collect();
        let coupling = self.coupling(points);
        let answers = axles.iter().any(|(track, _)| track.input.prescribed);
        let full = answers || self.terms.iter().any(|t| t.kind.spec().on_sensor);
        let motions = run(
            dataset,
            &axles,
            coupling.as_ref(),
            span.clone(),
            substeps,
            full,
        );
        motions
            .into_iter()
            .zip(&axles)
            .map(|(m, (track, lanes))| {
                sensed(dataset, span.start, track.input.prescribed, lanes, m)
            })
            .collect()
    }

    /// How strongly the axles push each other, where they do.
    pub fn coupling(&self, points: &[Point; LANES]) -> Option<Lanes> {
        self.coupled().map(|i| gather(points, |p| p.values[i][0]))
    }

    pub fn lanes(&self, dataset: &Dataset, points: &[Point; LANES], a: usize) -> AxleLanes {
        let axle = dataset.tracks[self.tracks[a]].axle;
        AxleLanes {
            base: Coefficients::from_fn(|n| gather(points, |p| p.base[a].get(n))),
            effects: (0..self.terms.len())
                .filter(|i| self.terms[*i].acts_on(axle))
                .map(|i| EffectLanes {
                    kind: self.terms[i].kind,
                    values: std::array::from_fn(|q| gather(points, |p| p.values[i][q])),
                    initial: std::array::from_fn(|q| gather(points, |p| p.initial[i][q])),
                })
                .collect(),
        }
    }
}

fn gather(points: &[Point; LANES], of: impl Fn(&Point) -> f64) -> Lanes {
    Lanes(std::array::from_fn(|i| of(&points[i])))
}

/// One number that a fit may move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slot {
    /// Axle of the unit; number of its base model.
    Base(usize, Coefficient),
    /// Term; parameter.
    Value(usize, usize),
    /// Term; height or velocity at the start, relative to the axle's.
    Initial(usize, usize),
}

impl Slot {
    /// Whether it belongs to where a motion starts.
    pub fn is_start(&self) -> bool {
        match self {
            Slot::Base(_, number) => number.is_start(),
            Slot::Initial(..) => true,
            Slot::Value(..) => false,
        }
    }
}

/// All numbers of a unit's model.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    pub base: Vec<Coefficients>,
    pub values: Vec<Values>,
    pub initial: Vec<Initial>,
}

impl Point {
    pub fn get(&self, slot: Slot) -> f64 {
        match slot {
            Slot::Base(a, number) => self.base[a].get(number),
            Slot::Value(i, q) => self.values[i][q],
            Slot::Initial(i, q) => self.initial[i][q],
        }
    }

    pub fn set(&mut self, slot: Slot, value: f64) {
        match slot {
            Slot::Base(a, number) => self.base[a].set(number, value),
            Slot::Value(i, q) => self.values[i][q] = value,
            Slot::Initial(i, q) => self.initial[i][q] = value,
        }
    }

    /// The same with other values in some slots.
    pub fn with(&self, slots: &[Slot], values: &[f64]) -> Point {
        let mut point = self.clone();
        for (slot, value) in slots.iter().zip(values) {
            point.set(*slot, *value);
        }
        point
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::example;
    use crate::law::padded;

    #[test]
    fn axles_are_fitted_together_where_an_effect_acts_on_both() {
        let dataset = example::dataset();
        let cubic = example::term(Kind::CubicStiffness, Axle::Rear);
        let apart = Unit::all(&dataset, &[cubic]);
        let tracks: Vec<_> = apart
            .iter()
            .map(|u| (u.tracks.clone(), u.terms.len()))
            .collect();
        assert_eq!(tracks, [(vec![0], 0), (vec![1], 1)]);
        let both = Term {
            kind: Kind::LoadTransfer,
            place: Place::Both,
        };
        let together = Unit::all(&dataset, &[cubic, both]);
        assert_eq!(together.len(), 1);
        assert_eq!(
            (&together[0].tracks[..], together[0].terms.len()),
            (&[0, 1][..], 2)
        );
    }

    #[test]
    fn what_is_known_is_no_number_to_fit() {
        let mut dataset = example::dataset();
        let unit = Unit {
            tracks: vec![0],
            terms: vec![example::term(Kind::CoulombFriction, Axle::Front)],
        };
        // On a road: k, B and the start, and two of the effect.
        let base = [0, 1, 4, 5].map(|q| Slot::Base(0, Coefficient::ALL[q]));
        let own = [0, 1].map(|q| Slot::Value(0, q));
        assert_eq!(unit.slots(&dataset), [&base[..], &own].concat());
        let track = &mut dataset.tracks[0];
        (track.free_mass, track.rest_point) = (true, true);
        track.plant = &veloid_core::plant::Damper::MOVING;
        let base = [1, 2, 3, 4, 5].map(|q| Slot::Base(0, Coefficient::ALL[q]));
        assert_eq!(unit.slots(&dataset), [&base[..], &own].concat());
    }

    #[test]
    fn a_point_with_other_values_has_these_and_keeps_the_rest() {
        let dataset = example::dataset();
        let unit = Unit {
            tracks: vec![0],
            terms: vec![example::term(Kind::CubicStiffness, Axle::Front)],
        };
        let point = example::point(&dataset, &unit, vec![padded([1.0, 2.0, 3.0, 4.0])]);
        let slots = [
            Slot::Base(0, Coefficient::Beta),
            Slot::Value(0, 2),
            Slot::Initial(0, 1),
        ];
        let other = point.with(&slots, &[5.0, 6.0, 7.0]);
        assert_eq!(slots.map(|slot| other.get(slot)), [5.0, 6.0, 7.0]);
        assert_eq!(
            other.with(&slots, &slots.map(|slot| point.get(slot))),
            point
        );
        assert_eq!(other.values[0], padded([1.0, 2.0, 6.0, 4.0]));
    }

    #[test]
    fn effects_make_an_axle_turn_and_decay_faster() {
        let dataset = example::dataset();
        let [cubic, friction] = [Kind::CubicStiffness, Kind::CoulombFriction]
            .map(|kind| example::term(kind, Axle::Front));
        let unit = Unit {
            tracks: vec![0],
            terms: vec![cubic, friction],
        };
        let of = |k3: f64, force: f64| {
            let values = vec![padded([k3]), padded([force])];
            let point = example::point(&dataset, &unit, values);
            (unit.fastest(&dataset, &point), unit.decay(&dataset, &point))
        };
        let (turn, decay) = of(0.0, 0.0);
        assert!((turn / (example::K / example::FRONT).sqrt() - 1.0).abs() < 1e-9);
        assert!((decay / (example::B / example::FRONT) - 1.0).abs() < 1e-9);
        let scale = &dataset.tracks[0].scale;
        let stiffens = (cubic.kind.spec().stiffens)(&padded([1e9]), scale);
        let damps = (friction.kind.spec().damps)(&padded([9.0]), scale);
        let (turn, decay) = of(1e9, 9.0);
        assert!((turn.powi(2) / ((example::K + stiffens) / example::FRONT) - 1.0).abs() < 1e-9);
        assert!((decay / ((example::B + damps) / example::FRONT) - 1.0).abs() < 1e-9);
    }
}
