//! Sets of effects that are proposed for an axle: by a search of its windows, and by what fits of the whole record have found.

use rayon::prelude::*;

use crate::policy;
use crate::search::Search;
use crate::search::in_windows::{InWindows, Seen};
use crate::verdict::windows::parameters;
use veloid_core::EngineError;
use veloid_model::effects::Kind;
use veloid_model::fit::{Fitted, Term};
use veloid_model::law::Family;

/// Best sets of a round to which one more effect is added, effects that are added to each, and sets beside which general laws are tried.
const FRONT: usize = 3;
const BESIDE: usize = 12;
const GENERALISED: usize = 3;

/// The sets that are tried, each once; nothing where the plain model has no fit.
pub fn proposals(
    search: &Search,
    axle: &InWindows,
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
    for _ in 1..policy::MOST_BY_WINDOWS {
        search.check()?;
        if search.is_spent() {
            break;
        }
        let parents: Vec<&Seen> = front.iter().collect();
        let next = added(axle, &parents, &beside);
        front = front_of(&next);
        all.extend(next);
    }
    let parts = all.without_each(axle, &plain);
    all.extend(parts);
    let general = all.generalised(axle, &plain);
    all.extend(general);
    Ok(Some(all.0))
}

/// Models with one effect more than their parents, those that leave least first.
fn added(axle: &InWindows, parents: &[&Seen], terms: &[Term]) -> Vec<Seen> {
    let pairs: Vec<(&Seen, Term)> = (parents.iter())
        .flat_map(|parent| terms.iter().map(move |term| (*parent, *term)))
        .filter(|(parent, term)| !parent.terms().contains(term))
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
    fn without_each(&self, axle: &InWindows, plain: &Seen) -> Vec<Seen> {
        let less = |seen: &Seen| -> Vec<Vec<Term>> {
            let without = |t: &Term| seen.terms().iter().filter(|o| *o != t).copied().collect();
            seen.terms().iter().map(without).collect()
        };
        let wanted = self.0.iter().take(GENERALISED).flat_map(less).collect();
        self.untried(wanted, axle, plain)
    }

    /// The best sets with general laws in the places of their named ones.
    fn generalised(&self, axle: &InWindows, plain: &Seen) -> Vec<Seen> {
        let best = self.0.iter().take(GENERALISED);
        let wanted = best.flat_map(|seen| wider(seen.terms())).collect();
        self.untried(wanted, axle, plain)
    }

    /// Of some sets those that were not tried, fitted.
    fn untried(&self, mut wanted: Vec<Vec<Term>>, axle: &InWindows, plain: &Seen) -> Vec<Seen> {
        wanted.sort();
        wanted.dedup();
        wanted.retain(|terms| self.0.iter().all(|seen| seen.terms() != terms));
        let fitted = |terms: &Vec<Term>| axle.of_set(plain, terms);
        wanted.par_iter().filter_map(fitted).collect()
    }
}

/// Sets with a general law in the place of a named one that is a case of it, or of all of one variable.
fn wider(terms: &[Term]) -> Vec<Vec<Term>> {
    let in_place = |replaced: &dyn Fn(&Term) -> bool, law: Kind| -> Option<Vec<Term>> {
        let place = terms.iter().find(|t| replaced(t))?.place;
        let mut wide: Vec<Term> = terms.iter().filter(|t| !replaced(t)).copied().collect();
        wide.push(Term { kind: law, place });
        wide.sort();
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
