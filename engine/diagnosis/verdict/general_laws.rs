//! Named laws held against general curves: where some other power of the rate or of the deflection explains the ride
//! clearly better with no more terms, the names are only the nearest shapes.

use rayon::prelude::*;

use crate::policy;
use crate::search::Search;
use crate::search::criteria::explains_nearly_all;
use crate::search::extend::{Reach, extend};
use crate::search::score_test::{Along, signatures};
use veloid_core::bicycle::Axle;
use veloid_model::effects::Kind;
use veloid_model::fit::polish::{polish, reduce};
use veloid_model::fit::tangent::tangent_for;
use veloid_model::fit::{Effort, FINE, Model, Term};
use veloid_model::law::Family;

/// Whether on every axle that has a name one effect alone takes nearly all off the held-out squares: what a
/// general curve adds to that is physics of another size.
pub fn dominates(search: &Search, model: &Model) -> bool {
    [Axle::Front, Axle::Rear].into_iter().all(|axle| {
        let mut own = model.terms.iter().filter(|t| t.acts_on(axle)).peekable();
        own.peek().is_none()
            || own.any(|term| {
                let kept = |t: &Term| t == term || !t.acts_on(axle);
                let terms: Vec<Term> = model.terms.iter().copied().filter(kept).collect();
                let alone = if terms == model.terms {
                    Some(model.clone())
                } else {
                    reduce(&search.fitter, model, &terms, search.thorough(model))
                };
                alone.is_some_and(|m| explains_nearly_all(search.left(axle, &m)))
            })
    })
}

/// Whether the model's names stand for a curve that is not in the library.
pub fn is_curve(search: &Search, model: &Model) -> bool {
    [Axle::Front, Axle::Rear].into_iter().any(|axle| {
        let own = |family: Family| -> Vec<Term> {
            let terms = model.terms.iter().copied();
            terms
                .filter(|t| t.acts_on(axle) && t.kind.is_named(family))
                .collect()
        };
        // Three laws of one variable draw a curve, they are not three causes; two do where one law is better.
        let springs = own(Family::Spring);
        let dampers = own(Family::Damper);
        let all: Vec<Term> = model
            .terms
            .iter()
            .copied()
            .filter(|t| t.acts_on(axle))
            .collect();
        springs.len() >= 3
            || springs.len() == 2 && led(search, model, &springs, Family::Spring)
            || !dampers.is_empty()
                && (led(search, model, &dampers, Family::Damper)
                    || all.len() > dampers.len() && led(search, model, &all, Family::Damper))
    })
}

/// Whether a named law is outgrown by one of which it is a special case: where the road is noisy also in the held-out
/// error, since that noise alone has led by 13 on the fitted part.
pub fn is_outgrown(search: &Search, model: &Model) -> bool {
    let fitter = &search.fitter;
    let effort = Effort {
        iterations: 30,
        gain: 0.05,
        substeps: model.substeps(fitter.dataset, FINE),
    };
    cases(model).any(|(named, wider)| {
        let Some(wide) = widened(model, named, wider) else {
            return false;
        };
        let mut named = model.terms.iter().filter(|t| t.kind == named);
        let noisy = named.any(|t| search.has_noisy_road(*t));
        let settled = |m: &Model| polish(fitter, m, effort);
        let (model, wide) = rayon::join(|| settled(model), || settled(&wide));
        model.zip(wide).is_some_and(|(model, wide)| {
            leads(search, &model, &wide) && (!noisy || search.shows(&model, &wide))
        })
    })
}

/// The effects of a model that are cases of general laws, in the library's order, and these.
fn cases(model: &Model) -> impl Iterator<Item = (Kind, Kind)> {
    let mut kinds: Vec<Kind> = model.terms.iter().map(|t| t.kind).collect();
    kinds.sort();
    kinds.dedup();
    (kinds.into_iter()).filter_map(|kind| Some((kind, kind.case_of()?)))
}

/// Whether a wider model leads by a clear gain, and on the held-out part too.
fn leads(search: &Search, model: &Model, wider: &Model) -> bool {
    wider.likelihood > model.likelihood + policy::CURVE_LEADS
        && search.held_score(wider) > search.held_score(model)
}

/// The model with a wider law in the place of every `named` one, where it moves the same; nothing if it has none.
fn widened(model: &Model, named: Kind, wider: Kind) -> Option<Model> {
    let widen = |terms: &mut [Term]| {
        for term in terms.iter_mut().filter(|t| t.kind == named) {
            term.kind = wider;
        }
    };
    let mut wide = model.clone();
    widen(&mut wide.terms);
    wide.fits.iter_mut().for_each(|f| widen(&mut f.unit.terms));
    (wide.terms != model.terms).then_some(wide)
}

/// Whether a general law of a family in the place of `named` effects leads the model.
fn led(search: &Search, model: &Model, named: &[Term], family: Family) -> bool {
    curves(search, model, named, family)
        .iter()
        .any(|m| leads(search, model, m))
}

/// The model with each general law of a family in the place of `named` effects.
fn curves(search: &Search, model: &Model, named: &[Term], family: Family) -> Vec<Model> {
    let fitter = &search.fitter;
    let substeps = model.substeps(fitter.dataset, FINE);
    let effort = Effort {
        iterations: 20,
        gain: 0.05,
        substeps,
    };
    let rest: Vec<Term> = model
        .terms
        .iter()
        .copied()
        .filter(|t| !named.contains(t))
        .collect();
    let Some(less) = reduce(fitter, model, &rest, effort) else {
        return Vec::new();
    };
    let in_place = |kind: Kind| {
        let term = Term {
            kind,
            place: named[0].place,
        };
        let tangent = tangent_for(fitter, &less, term, substeps);
        let along = Along {
            fitter,
            tangent: &tangent,
            substeps,
        };
        let offer = signatures(&[along], term);
        if offer.starts.is_empty() {
            return None;
        }
        let found = extend(fitter, &less, &offer, effort, Reach::Near)?;
        polish(fitter, &found, effort)
    };
    let laws: Vec<Kind> = Kind::general(family).collect();
    laws.into_par_iter().filter_map(in_place).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::example;

    #[test]
    fn a_curve_leads_clearly_and_on_the_held_out_part_too() {
        let dataset = example::dataset();
        let search = example::search(&dataset);
        let cubic = example::term(Kind::CubicStiffness, Axle::Front);
        // The ride has no cubic spring, so that a model with one errs more on the held-out part.
        let model = |k3: f64| example::model(&dataset, &[(cubic, k3)]);
        let (worse, better) = (model(1e9), model(0.0));
        let ahead = |times: f64| times * policy::CURVE_LEADS;
        let led = |named: &Model, wider: &Model, times: f64| {
            leads(
                &search,
                named,
                &example::likely(wider.clone(), ahead(times)),
            )
        };
        assert!(led(&worse, &better, 1.01) && !led(&worse, &better, 0.99));
        assert!(!led(&better, &worse, 1.01));
    }

    #[test]
    fn one_effect_dominates_where_it_alone_leaves_next_to_nothing() {
        let dataset = example::dataset();
        let mut search = example::search(&dataset);
        // What is missing from this plain model is what it puts in: a gain of the sensor that the ride does not have.
        let gain = example::term(Kind::SensorGain, Axle::Front);
        search.plain = example::model(&dataset, &[(gain, 0.3)]);
        let one = example::model(&dataset, &[(gain, 0.0)]);
        assert!(search.left(Axle::Front, &one) < 0.1 * (1.0 - policy::ADEQUATE));
        assert!(dominates(&search, &one));
        assert!(!dominates(&search, &search.plain));
    }

    #[test]
    fn a_law_is_widened_where_it_has_a_wider_one() {
        let dataset = example::dataset();
        let [hysteresis, cubic] =
            [Kind::Hysteresis, Kind::CubicStiffness].map(|kind| example::term(kind, Axle::Front));
        let model = example::model(&dataset, &[(hysteresis, 1.0), (cubic, 0.0)]);
        let wide = widened(&model, Kind::Hysteresis, Kind::RateHysteresis).unwrap();
        let kinds: Vec<Kind> = wide.terms.iter().map(|t| t.kind).collect();
        assert!(kinds.contains(&Kind::RateHysteresis) && kinds.contains(&Kind::CubicStiffness));
        assert!(!kinds.contains(&Kind::Hysteresis));
        assert!(widened(&model, Kind::SprungMass, Kind::HardeningMass).is_none());
    }
}
