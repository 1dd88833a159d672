//! Whether a bicycle can be what a model says it is.

use super::estimate::estimate;
use super::model::Model;
use super::unit::{Point, Term, Unit};
use crate::diagnosis::dataset::Dataset;
use crate::diagnosis::policy;

/// Whether the effects are physical and what is left of the plain spring and damper on their axles is one: between stops lies a
/// spring, and no damper pushes.
pub fn is_physical(dataset: &Dataset, plain: &Model, model: &Model) -> bool {
    let effects = (model.fits.iter()).all(|f| has_physical_effects(dataset, &f.unit, &f.point));
    let spring = (0..dataset.tracks.len()).all(|t| {
        let track = &dataset.tracks[t];
        if !model.terms.iter().any(|term| term.acts_on(track.axle)) {
            return true;
        }
        let (before, after) = (estimate(dataset, plain, t), estimate(dataset, model, t));
        let replaced =
            (model.terms.iter()).any(|t| t.kind.spec().replaces_spring && t.acts_on(track.axle));
        (!replaced || after.k_n_m > policy::SPRING_STAYS * before.k_n_m.abs())
            && after.b_n_s_m
                > -policy::PUSHES * after.b_std_n_s_m.unwrap_or(0.0)
                    - policy::PUSHES_A_LITTLE * before.b_n_s_m.abs()
    });
    effects && spring
}

/// Whether the effects' parameters lie in their physical ranges; a tyre does not relax to nothing.
pub fn has_physical_effects(dataset: &Dataset, unit: &Unit, point: &Point) -> bool {
    let is_physical = |(i, term): (usize, &Term)| {
        let values = &point.values[i];
        let reported = (term.kind.spec().report)(values, unit.scale(dataset, i));
        let relaxes = term.kind.spec().relaxes;
        let own = unit.tracks.iter().zip(&point.base);
        let mut own = own.filter(|(t, _)| term.acts_on(dataset.tracks[**t].axle));
        reported.iter().all(|r| r.physical)
            && own.all(|(_, base)| {
                !relaxes || base.kappa >= policy::STATIC * values[0] * base.per_mass
            })
    };
    unit.terms.iter().enumerate().all(is_physical)
}
