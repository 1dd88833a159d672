//! On which rides an effect acts.

use rayon::prelude::*;

use super::rounds::{Joint, Rides, settled, sum};
use crate::search::Search;
use crate::search::criteria::cost;
use crate::search::extend::joined;
use veloid_core::numerics::finite::finite;
use veloid_core::numerics::statistics::chi_square_tail;
use veloid_model::fit::polish::reduce;
use veloid_model::fit::together::Common;
use veloid_model::fit::{Effort, FINE, Fitted, Model, Term};
use veloid_report::diagnosis::{EffectReport, Place};

/// How the rides, in their order, support an effect of their common model.
pub struct Support {
    pub term: Term,
    /// Each ride's fit with parameters of the effect of its own; nothing where it does not act.
    pub alone: Vec<Option<Fitted>>,
    /// What each ride's likelihood loses without the effect.
    pub gains: Vec<f64>,
    /// How often rides with the same effect differ by as much as these do (chi-square); nothing for an effect that was not looked for
    /// in all.
    pub differs: Option<f64>,
    /// Whether the effect acts on each ride: on all, unless they differ in it.
    pub acts: Vec<bool>,
}

/// The common model with each effect on the rides that show it, and how they support it.
///
/// Effects in which the rides differ by more than chance have parameters of each ride's own and are gone from the rides that do not show
/// them. What a ride shows by itself and the rides do not have in common acts on that ride.
pub fn acting(study: &Rides, mut joint: Joint, alone: &[&[EffectReport]]) -> (Joint, Vec<Support>) {
    let terms = joint.terms().to_vec();
    let mut supports = Vec::new();
    for term in terms {
        let Some((mut support, without)) = support(study, &joint, term) else {
            continue;
        };
        if support.differs.is_some_and(|p| p < study.alpha) {
            match separated(study, &joint, &support, &without) {
                Some(apart) => joint = apart,
                None => support.acts.fill(true),
            }
        }
        supports.push(support);
    }
    let own = own_effects(study, &mut joint, alone);
    supports.extend(own);
    (joint, supports)
}

/// What supports a common effect, and each ride's model without it.
fn support(study: &Rides, joint: &Joint, term: Term) -> Option<(Support, Vec<Model>)> {
    let effort = effort(study, joint);
    let fits: Vec<&Fitted> = (joint.models.iter())
        .map(|m| of_term(m, term))
        .collect::<Option<_>>()?;
    let alone = |(search, fit): (&Search, &&Fitted)| {
        let fitter = &search.fitter;
        let found = fitter.fit(&fit.unit, fit.point.clone(), &fit.noise_models, effort)?;
        Some(match found.likelihood > fit.likelihood {
            true => found,
            false => (*fit).clone(),
        })
    };
    let alone: Vec<Fitted> = (study.searches.par_iter().zip(&fits))
        .map(alone)
        .collect::<Option<_>>()?;
    let less = |(search, model): (&Search, &Model)| {
        let less = without(search, model, term)?;
        finite(model.likelihood - less.likelihood).map(|gain| (less, gain))
    };
    let without: Vec<(Model, f64)> = (study.searches.par_iter().zip(&joint.models))
        .map(less)
        .collect::<Option<_>>()?;
    let (without, gains): (Vec<Model>, Vec<f64>) = without.into_iter().unzip();
    let parameters = fits[0].unit.terms.iter();
    let parameters: usize = parameters.map(|t| t.kind.spec().parameters.len()).sum();
    let freedom = parameters * (study.searches.len() - 1);
    let common: f64 = fits.iter().map(|f| f.likelihood).sum();
    let differs = chi_square_tail(2.0 * (sum(&alone) - common).max(0.0), freedom as f64);
    let shows = |r: usize| {
        let gain = gains[r] + alone[r].likelihood - fits[r].likelihood;
        pays(study, r, term, gain)
    };
    let shown: Vec<bool> = (0..gains.len()).map(shows).collect();
    let is_everywhere = differs >= study.alpha || !shown.contains(&true);
    let support = Support {
        term,
        acts: match is_everywhere {
            true => vec![true; gains.len()],
            false => shown,
        },
        alone: alone.into_iter().map(Some).collect(),
        gains,
        differs: Some(differs),
    };
    Some((support, without))
}

/// The fit of the axles that an effect acts on.
fn of_term(model: &Model, term: Term) -> Option<&Fitted> {
    model.fits.iter().find(|f| f.unit.terms.contains(&term))
}

fn without(search: &Search, model: &Model, term: Term) -> Option<Model> {
    let kept: Vec<Term> = model.terms.iter().copied().filter(|t| *t != term).collect();
    reduce(&search.fitter, model, &kept, search.thorough(model))
}

/// Whether a gain in log likelihood of one ride is more than the effect's parameters cost.
fn pays(study: &Rides, ride: usize, term: Term, gain: f64) -> bool {
    gain >= cost(&[term], study.searches[ride].fitter.samples)
}

/// The rides with an effect at each one's own size where it acts, and gone elsewhere.
fn separated(study: &Rides, joint: &Joint, support: &Support, without: &[Model]) -> Option<Joint> {
    let model = |r: usize| match (support.acts[r], &support.alone[r]) {
        (true, Some(fit)) => joint.models[r].with(fit.clone()),
        _ => without[r].clone(),
    };
    let mut own = joint.own.clone();
    own.push(support.term);
    let apart = Joint {
        models: (0..without.len()).map(model).collect(),
        own,
        ..joint.clone()
    };
    let tracks = &support.alone.iter().flatten().next()?.unit.tracks;
    refitted(study, &apart, tracks)
}

/// The rides with the fit of some axles brought to rest again.
fn refitted(study: &Rides, joint: &Joint, tracks: &[usize]) -> Option<Joint> {
    let fits = of_tracks(joint, tracks)?;
    let effort = effort(study, joint);
    let units = fits.iter().map(|f| f.unit.clone()).collect();
    let together = study.together(units, Common::Effects, &joint.own);
    let fits = fits.into_iter().cloned().collect();
    Some(joint.with(settled(&together, fits, effort)?))
}

/// Each ride's fit of some axles; nothing where one fits others with them.
pub fn of_tracks<'j>(joint: &'j Joint, tracks: &[usize]) -> Option<Vec<&'j Fitted>> {
    let of = |model: &'j Model| model.fits.iter().find(|f| f.unit.tracks == tracks);
    joint.models.iter().map(of).collect()
}

/// Adds to each ride what it shows by itself beyond the common model, from where that left it.
fn own_effects(study: &Rides, joint: &mut Joint, alone: &[&[EffectReport]]) -> Vec<Support> {
    let mut supports: Vec<Support> = Vec::new();
    for (r, effects) in alone.iter().enumerate() {
        for effect in *effects {
            let Some((term, model)) = with_own(study, joint, r, effect) else {
                continue;
            };
            let at = supports.iter().position(|s| s.term == term);
            let at = at.unwrap_or_else(|| {
                supports.push(Support::nowhere(term, joint.models.len()));
                supports.len() - 1
            });
            let support = &mut supports[at];
            support.acts[r] = true;
            support.gains[r] = model.likelihood - joint.models[r].likelihood;
            support.alone[r] = of_term(&model, term).cloned();
            joint.models[r] = model;
            if !joint.own.contains(&term) {
                joint.own.push(term);
            }
        }
    }
    supports
}

impl Support {
    fn nowhere(term: Term, rides: usize) -> Self {
        Self {
            term,
            alone: vec![None; rides],
            gains: vec![0.0; rides],
            differs: None,
            acts: vec![false; rides],
        }
    }
}

/// A ride's model with an effect that its own diagnosis affirms and that the rides do not have in common.
fn with_own(
    study: &Rides,
    joint: &Joint,
    r: usize,
    effect: &EffectReport,
) -> Option<(Term, Model)> {
    let search = &study.searches[r];
    let (dataset, model) = (search.fitter.dataset, &joint.models[r]);
    // Both axles at once would be fitted otherwise than on the other rides.
    let is_own =
        |t: &&Term| t.place == effect.axle && t.place != Place::Both && t.id(dataset) == effect.id;
    let term = *search.candidates.iter().find(is_own)?;
    if !effect.affirmed || model.terms.contains(&term) {
        return None;
    }
    let unit = joined(dataset, model, term)?;
    let at = unit.terms.iter().position(|t| *t == term)?;
    let (mut point, noise_models) = model.carried(&unit);
    let parameter = |name: &str| effect.parameters.get(name).map(|p| p.value);
    let values = term.kind.values_named(parameter, unit.scale(dataset, at));
    point.values[at] = values.ok()?;
    let noise_models: Vec<_> = noise_models.iter().map(|n| n.bleached()).collect();
    let effort = effort(study, joint);
    let fit = |point, noise: &[_]| search.fitter.fit(&unit, point, noise, effort);
    let first = fit(point, &noise_models)?;
    let larger = model.with(fit(first.point, &first.noise_models)?);
    pays(study, r, term, larger.likelihood - model.likelihood).then_some((term, larger))
}

/// How hard the last fits of a study try.
pub fn effort(study: &Rides, joint: &Joint) -> Effort {
    Effort {
        iterations: 20,
        gain: 0.01,
        substeps: study.substeps(joint, FINE),
    }
}
