//! From the fitted models to the report: effects with their uncertainty, held-out errors, what the
//! omission means.

use crate::verdict::by_parts::Claim;
use crate::verdict::effect_report::{HAS_TWIN, RESTS_ON_PRIOR, reported, twin, unlearned};
use veloid_core::numerics::finite::finite;
use veloid_model::dataset::Dataset;
use veloid_model::fit::estimate::estimate;
use veloid_model::fit::{Model, Motion, Term};
use veloid_report::Estimate;
use veloid_report::diagnosis::{Consequences, EffectName, EffectReport};

pub fn name(dataset: &Dataset, term: &Term) -> EffectName {
    EffectName {
        id: term.id(dataset).to_owned(),
        axle: term.place,
    }
}

/// An effect that acts although something else is left: its intervals are those of the jackknife, where these are wider.
pub fn supported(
    dataset: &Dataset,
    model: &Model,
    claim: &Claim,
    errors: &[f64],
) -> Option<EffectReport> {
    let mut effect = reported(dataset, model, &claim.term, (None, None), errors)?;
    effect.affirmed = claim.holds;
    effect.support = Some(claim.support.clone());
    Some(effect)
}

/// k, B and m under a model, without intervals where they rest on what was only expected: along a flat and curved ridge they are far
/// too narrow.
pub fn reported_estimate(dataset: &Dataset, model: &Model, track: usize) -> Estimate {
    let mut reported = estimate(dataset, model, track);
    let axle = dataset.tracks[track].axle;
    let (fit, _) = model.of_track(track);
    if unlearned(dataset, fit).any(|(term, ..)| term.acts_on(axle)) {
        (reported.k_std_n_m, reported.b_std_n_s_m) = (None, None);
        reported.k_not_identifiable = Some(RESTS_ON_PRIOR.to_owned());
        reported.b_not_identifiable = Some(RESTS_ON_PRIOR.to_owned());
    }
    if twin(fit).is_some() {
        (reported.k_std_n_m, reported.b_std_n_s_m) = (None, None);
        reported.k_not_identifiable = Some(HAS_TWIN.to_owned());
        reported.b_not_identifiable = Some(HAS_TWIN.to_owned());
    }
    reported
}

/// What the omission changes for the rider.
pub fn consequences(
    dataset: &Dataset,
    track: usize,
    plain: (&Estimate, &Motion),
    extended: (&Estimate, &Motion),
) -> Consequences {
    let s = &dataset.tracks[track].scale;
    let load = |m: &Motion, by_law: bool| -> Vec<f64> {
        let constant = dataset.tracks[track].input.force.is_some();
        let force = if by_law && !constant {
            &m.acceleration
        } else {
            &m.linear
        };
        let static_load = if s.static_load.is_finite() {
            s.static_load
        } else {
            0.0
        };
        force.iter().map(|a| static_load + s.mass * a).collect()
    };
    // What a model does where nothing was recorded, or before it has forgotten its start, is nobody's load.
    let recorded = |load: Vec<f64>| -> Vec<f64> {
        let known = load.into_iter().zip(&dataset.tracks[track].valid);
        known.filter(|(_, valid)| **valid).map(|(f, _)| f).collect()
    };
    let before = recorded(load(plain.1, false));
    let after = recorded(load(extended.1, true));
    let peak = |x: &[f64]| {
        let known = x.iter().all(|f| f.is_finite());
        known.then(|| x.iter().copied().fold(0.0, f64::max))
    };
    let airborne = after
        .iter()
        .filter(|f| **f <= 1e-3 * s.static_load.abs())
        .count() as f64
        / after.len().max(1) as f64;
    let percent = |a: f64, b: f64| finite(100.0 * (a / b - 1.0));
    // What a rig presses carries no bicycle.
    let moves = dataset.tracks[track].plant.moves();
    let resonance =
        |e: &Estimate| finite((e.k_n_m.max(0.0) / e.mass_kg).sqrt() / std::f64::consts::TAU);
    Consequences {
        k_change_percent: percent(extended.0.k_n_m, plain.0.k_n_m),
        b_change_percent: percent(extended.0.b_n_s_m, plain.0.b_n_s_m),
        peak_load_plain_n: peak(&before).filter(|_| moves),
        peak_load_extended_n: peak(&after).filter(|_| moves),
        airborne_share: dataset.tracks[track].has_road.then_some(airborne),
        resonance_plain_hz: resonance(plain.0),
        resonance_extended_hz: resonance(extended.0),
    }
}
