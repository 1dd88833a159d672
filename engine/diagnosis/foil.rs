//! Named laws held against general curves: where some other power of the rate explains the ride
//! clearly better with no more terms, the names are only the nearest shapes.

use crate::bicycle::Axle;

use super::effects::{FOILS, Kind};
use super::extend::{Model, Reach, extend, polish, reduce};
use super::fit::Effort;
use super::model::Term;
use super::name::{FINE, Search};
use super::signature::tangent_for;

const SPRINGS: [Kind; 5] = [
    Kind::CubicStiffness,
    Kind::ProgressiveStiffness,
    Kind::BumpStop,
    Kind::FreePlay,
    Kind::WheelLift,
];
const DAMPERS: [Kind; 4] = [
    Kind::CoulombFriction,
    Kind::Hysteresis,
    Kind::QuadraticDamping,
    Kind::AsymmetricDamping,
];
/// Gain in log likelihood by which a general curve must lead.
const LEAD: f64 = 10.0;

/// Whether the model's names stand for a curve that is not in the library.
pub fn is_curve(search: &Search, model: &Model) -> bool {
    [Axle::Front, Axle::Rear].into_iter().any(|axle| {
        let own = |family: &[Kind]| -> Vec<Term> {
            let terms = model.terms.iter().copied();
            terms
                .filter(|t| t.acts_on(axle) && family.contains(&t.kind))
                .collect()
        };
        // Three laws of one variable draw a curve, they are not three causes.
        let dampers = own(&DAMPERS);
        let all: Vec<Term> = model
            .terms
            .iter()
            .copied()
            .filter(|t| t.acts_on(axle))
            .collect();
        own(&SPRINGS).len() >= 3
            || !dampers.is_empty()
                && (led(search, model, &dampers)
                    || all.len() > dampers.len() && led(search, model, &all))
    })
}

/// Whether a general damper in the place of `named` effects leads the model.
fn led(search: &Search, model: &Model, named: &[Term]) -> bool {
    let fitter = &search.fitter;
    let substeps = model.substeps(fitter.scene, FINE);
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
        return false;
    };
    FOILS.iter().any(|kind| {
        let term = Term {
            kind: *kind,
            place: named[0].place,
        };
        let offer = tangent_for(fitter, &less, term, substeps).signatures(fitter, term, substeps);
        if offer.starts.is_empty() {
            return false;
        }
        let found = extend(fitter, &less, &offer, effort, Reach::Near);
        let found = found.and_then(|m| polish(fitter, &m, effort));
        found.is_some_and(|m| m.likelihood > model.likelihood + LEAD)
    })
}
