//! Sets of effects that are proposed for an axle: by a search of its windows, and by what fits of the whole record have found.

use rayon::prelude::*;

use crate::policy;
use crate::search::Search;
use crate::search::in_parts::{InParts, Seen};
use veloid_core::EngineError;
use veloid_model::effects::Kind;
use veloid_model::fit::{Fitted, Term};
use veloid_model::law::{Family, MAX_PARAMETERS, Scale};

/// Best sets of a round to which one more effect is added, effects that are added to each, and sets beside which general laws are tried.
const FRONT: usize = 3;
const BESIDE: usize = 12;
const GENERALISED: usize = 3;

/// The sets that are tried, each once; nothing where the plain model has no fit.
pub fn proposals(
    search: &Search,
    axle: &InParts,
    proposed: &[&Fitted],
) -> Result<Option<Vec<Seen>>, EngineError> {
    let Some(plain) = axle.plain() else {
        return Ok(None);
    };
    let mut all = Sets(vec![plain.clone()]);
    let first = added(axle, &[&plain], &axle.candidates);
    let beside: Vec<Term> = first
        .iter()
        .take(BESIDE)
        .map(|seen| seen.terms()[0])
        .collect();
    let mut front = front_of(&first);
    all.extend(first);
    let known: Vec<Seen> = proposed
        .par_iter()
        .filter_map(|fit| axle.known(fit))
        .collect();
    all.extend(known);
    while has_room(front.first()) {
        search.check()?;
        if search.is_spent() {
            break;
        }
        let parents: Vec<&Seen> = front.iter().collect();
        let next = added(axle, &parents, &beside);
        front = front_of(&next);
        all.extend(next);
    }
    let parts = all.without_each(axle);
    all.extend(parts);
    let general = all.generalised(axle);
    all.extend(general);
    Ok(Some(all.0))
}

/// Whether one more effect may be added to a model.
fn has_room(seen: Option<&Seen>) -> bool {
    seen.is_some_and(|seen| seen.terms().len() < policy::MOST_BY_WINDOWS)
}

/// Coefficients that are reported of effects: what only shapes a corner does not count.
pub fn parameters(terms: &[Term]) -> usize {
    let reported = |t: &Term| match t.kind {
        Kind::Own(_) => t.kind.spec().parameters.len(),
        _ => (t.kind.spec().report)(&[0.0; MAX_PARAMETERS], &Scale::TYPICAL).len(),
    };
    terms.iter().map(reported).sum()
}

/// Models with one effect more than their parents, those that leave least first.
fn added(axle: &InParts, parents: &[&Seen], terms: &[Term]) -> Vec<Seen> {
    let pairs: Vec<(&Seen, Term)> = (parents.iter())
        .flat_map(|parent| terms.iter().map(move |term| (*parent, *term)))
        .filter(|(parent, term)| !parent.terms().contains(term))
        .filter(|(parent, term)| !has_limit(&[parent.terms(), &[*term]].concat()))
        .collect();
    let mut found = Sets(
        (pairs.par_iter())
            .filter_map(|(p, term)| axle.with(p, *term))
            .collect(),
    );
    found.0.retain(|seen| axle.is_physical(seen));
    found.sort();
    found.0
}

/// Whether a law and its limit act at once: what the model leaves without one of them says nothing of either.
pub fn has_limit(terms: &[Term]) -> bool {
    let is_limit = |narrow: &Term| terms.iter().any(|wide| narrow.kind.is_limit_of(wide.kind));
    terms.iter().any(is_limit)
}

/// Of sets that leave least first, the best of each number of parameters that leaves less than all with fewer.
fn front_of(sorted: &[Seen]) -> Vec<Seen> {
    let mut front: Vec<Seen> = Vec::new();
    for seen in sorted {
        let own = parameters(seen.terms());
        if front
            .last()
            .is_none_or(|better| own < parameters(better.terms()))
        {
            front.push(seen.clone());
        }
    }
    front.truncate(FRONT);
    front
}

/// Sets of effects, each once.
struct Sets(Vec<Seen>);

impl Sets {
    fn sort(&mut self) {
        self.0.sort_by(|a, b| a.left().total_cmp(&b.left()));
        let mut kept: Vec<Seen> = Vec::new();
        for seen in self.0.drain(..) {
            if kept.iter().all(|other| other.terms() != seen.terms()) {
                kept.push(seen);
            }
        }
        self.0 = kept;
    }

    fn extend(&mut self, others: Vec<Seen>) {
        self.0.extend(others);
        self.sort();
    }

    /// What the best sets are without each of their effects, where that was not tried.
    fn without_each(&self, axle: &InParts) -> Vec<Seen> {
        let less = |seen: &Seen| -> Vec<Vec<Term>> {
            let without = |t: &Term| seen.terms().iter().filter(|o| *o != t).copied().collect();
            seen.terms().iter().map(without).collect()
        };
        let wanted = self.0.iter().take(GENERALISED).flat_map(less).collect();
        self.untried(wanted, axle)
    }

    /// The best sets with general laws in the places of their named ones.
    fn generalised(&self, axle: &InParts) -> Vec<Seen> {
        let best = self.0.iter().take(GENERALISED);
        let wanted = best.flat_map(|seen| wider(seen.terms())).collect();
        self.untried(wanted, axle)
    }

    /// Of some sets those that were not tried, each fitted from the largest tried set that it contains.
    fn untried(&self, mut wanted: Vec<Vec<Term>>, axle: &InParts) -> Vec<Seen> {
        wanted.sort();
        wanted.dedup();
        wanted.retain(|terms| self.0.iter().all(|seen| seen.terms() != terms));
        let fitted = |terms: &Vec<Term>| {
            let is_part = |seen: &&Seen| seen.terms().iter().all(|t| terms.contains(t));
            let parts = self.0.iter().rev().filter(is_part);
            let largest = parts.max_by_key(|seen| seen.terms().len())?;
            let more = terms.iter().filter(|t| !largest.terms().contains(t));
            more.copied()
                .try_fold(largest.clone(), |seen, term| axle.with(&seen, term))
        };
        wanted.par_iter().filter_map(fitted).collect()
    }
}

/// Sets with a general law in the place of a named one that is a case of it, or of all of one variable, or with a limit of a law in its
/// place.
fn wider(terms: &[Term]) -> Vec<Vec<Term>> {
    let in_place = |replaced: &dyn Fn(&Term) -> bool, law: Kind| -> Option<Vec<Term>> {
        let place = terms.iter().find(|t| replaced(t))?.place;
        let mut wide: Vec<Term> = terms.iter().filter(|t| !replaced(t)).copied().collect();
        wide.push(Term { kind: law, place });
        wide.sort();
        wide.dedup();
        Some(wide)
    };
    let of_family = |family: Family| {
        Kind::general(family).filter_map(move |law| in_place(&|t| t.kind.is_named(family), law))
    };
    let of_case = |term: &Term| in_place(&|t| t == term, term.kind.case_of()?);
    let mut found: Vec<Vec<Term>> = [Family::Spring, Family::Damper]
        .into_iter()
        .flat_map(of_family)
        .collect();
    found.extend(terms.iter().filter_map(of_case));
    let limits = |term: &Term| {
        let is_limit = |kind: &Kind| kind.is_limit_of(term.kind);
        in_place(&|t| t == term, Kind::named().find(is_limit)?)
    };
    found.extend(terms.iter().filter_map(limits));
    // A spring of two powers in the place of any that bends once.
    let is_spring = |t: &Term| t.kind.is_named(Family::Spring);
    found.extend(in_place(&is_spring, Kind::PowerStiffness).map(|mut curve| {
        let place = terms
            .iter()
            .find(|t| is_spring(t))
            .map_or(curve[0].place, |t| t.place);
        curve.push(Term {
            kind: Kind::CubicStiffness,
            place,
        });
        curve.sort();
        curve
    }));
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use veloid_core::plant::Coefficients;
    use veloid_model::fit::{Point, Unit};
    use veloid_report::diagnosis::Place;

    /// A model with some effects that leaves so much.
    fn seen(kinds: &[Kind], left: f64) -> Seen {
        let point = Point {
            base: vec![Coefficients::default()],
            values: Vec::new(),
            initial: Vec::new(),
        };
        let place = Place::Front;
        Seen {
            unit: Unit {
                tracks: vec![0],
                terms: kinds
                    .iter()
                    .map(|kind| Term { kind: *kind, place })
                    .collect(),
            },
            folds: [point.clone(), point.clone()],
            point,
            errors: vec![left],
        }
    }

    #[test]
    fn sets_hold_so_many_effects() {
        let with = |count: usize| seen(&vec![Kind::CubicStiffness; count], 1.0);
        assert!(has_room(Some(&with(policy::MOST_BY_WINDOWS - 1))));
        assert!(!has_room(Some(&with(policy::MOST_BY_WINDOWS))));
        assert!(!has_room(None));
    }

    #[test]
    fn the_front_holds_the_best_set_of_each_number_of_parameters() {
        let (mass, cubic, drag) = (
            Kind::SprungMass,
            Kind::CubicStiffness,
            Kind::QuadraticDamping,
        );
        let sorted = [seen(&[mass], 0.1), seen(&[cubic], 0.2), seen(&[drag], 0.3)];
        let front: Vec<f64> = front_of(&sorted).iter().map(Seen::left).collect();
        assert_eq!(front, [0.1, 0.2]);
    }

    #[test]
    fn a_law_is_not_tried_beside_its_limit() {
        let both = |kinds: [Kind; 2]| has_limit(seen(&kinds, 1.0).terms());
        assert!(both([Kind::Hysteresis, Kind::CoulombFriction]));
        assert!(!both([Kind::CubicStiffness, Kind::CoulombFriction]));
    }

    #[test]
    fn wider_and_narrower_laws_are_tried_in_the_place_of_named_ones() {
        let place = Place::Front;
        let term = |kind| Term { kind, place };
        let tried = wider(&[term(Kind::Hysteresis)]);
        assert!(
            tried.contains(&vec![term(Kind::CoulombFriction)]),
            "{tried:?}"
        );
        let tried = wider(&[term(Kind::CubicStiffness)]);
        assert!(
            tried.contains(&vec![term(Kind::PowerStiffness)]),
            "{tried:?}"
        );
    }
}
