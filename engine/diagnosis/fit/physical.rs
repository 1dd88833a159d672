//! Whether a bicycle can be what a model says it is.

use super::estimate::estimate;
use super::model::Model;
use crate::bicycle::Axle;
use crate::diagnosis::dataset::Scene;
use crate::diagnosis::effects::Kind;
use crate::diagnosis::policy;

/// Whether the effects' parameters lie in their physical ranges and what is left of the plain spring
/// and damper on their axles is one: between stops lies a spring, a tyre does not relax to nothing, and no damper
/// pushes.
pub fn is_physical(scene: &Scene, plain: &Model, model: &Model) -> bool {
    let effects = model.fits.iter().all(|f| {
        f.unit.terms.iter().enumerate().all(|(i, term)| {
            (term.kind.spec().report)(&f.point.values[i], f.unit.scale(scene, i))
                .iter()
                .all(|r| r.physical)
        })
    });
    let spring = (0..scene.tracks.len()).all(|t| {
        let track = &scene.tracks[t];
        if !model.terms.iter().any(|term| term.acts_on(track.axle)) {
            return true;
        }
        let (before, after) = (estimate(scene, plain, t), estimate(scene, model, t));
        let replaces = |kind| matches!(kind, Kind::BumpStop | Kind::ViscoelasticTyre);
        let relaxing = relaxing(model, track.axle);
        let replaced = (model.terms.iter()).any(|t| replaces(t.kind) && t.acts_on(track.axle));
        after.k_n_m >= policy::STATIC * relaxing
            && (!replaced || after.k_n_m > policy::SPRING_STAYS * before.k_n_m.abs())
            && after.b_n_s_m
                > -policy::PUSHES * after.b_std_n_s_m.unwrap_or(0.0)
                    - policy::PUSHES_A_LITTLE * before.b_n_s_m.abs()
    });
    effects && spring
}

/// Stiffness (N/m) that acts only while the deflection changes.
fn relaxing(model: &Model, axle: Axle) -> f64 {
    let all = model.fits.iter();
    all.flat_map(|f| f.unit.terms.iter().zip(&f.point.values))
        .filter(|(term, _)| term.kind == Kind::ViscoelasticTyre && term.acts_on(axle))
        .map(|(_, values)| values[0])
        .sum()
}
