//! From the fitted models to the report: effects with their uncertainty, held-out errors, what the
//! omission means, what the ride would have shown.

use crate::report::Estimate;

use super::adequacy::Motion;
use super::effects::Values;
use super::extend::Model;
use super::fit::Fitted;
use super::model::{Slot, Term};
use super::scene::{Scale, Scene};
use super::signature::Signatures;
use super::{Consequences, Detectable, EffectName, EffectReport, ParameterReport};

pub fn name(term: &Term) -> EffectName {
    EffectName {
        id: term.kind.id().to_owned(),
        axle: term.place,
    }
}

/// One named effect. `separation` is what the model without it lacks in log likelihood, where that could be fitted.
pub fn effect(
    scene: &Scene,
    model: &Model,
    term: &Term,
    separation: Option<f64>,
    p_value: f64,
) -> Option<EffectReport> {
    let fit = model.fits.iter().find(|f| f.unit.terms.contains(term))?;
    let at = fit.unit.terms.iter().position(|t| t == term)?;
    let spec = term.kind.spec();
    let scale = fit.unit.scale(scene, at);
    let values = fit.point.values[at];
    let reported = (spec.report)(&values, scale);
    let errors = standard_errors(scene, fit, at, &values, scale);
    let inside = reported.iter().all(|r| r.physical);
    let parameters: Vec<(&str, ParameterReport)> = reported
        .into_iter()
        .zip(errors)
        .map(|(r, std_error)| {
            (
                r.name,
                ParameterReport {
                    value: r.value,
                    std_error,
                    unit: r.unit.to_owned(),
                },
            )
        })
        .collect();
    let told = parameters
        .iter()
        .map(|(name, p)| format!("{} {}", name.replace('_', " "), p.quantity(name)))
        .collect::<Vec<_>>()
        .join(", ");
    let place = match term.place {
        super::Place::Front => "on the front axle",
        super::Place::Rear => "on the rear axle",
        super::Place::Both => "on both axles",
    };
    Some(EffectReport {
        id: spec.id.to_owned(),
        axle: term.place,
        parameters: parameters
            .into_iter()
            .map(|(name, p)| (name.to_owned(), p))
            .collect(),
        p_value,
        separation: separation.unwrap_or(f64::NAN).max(0.0),
        inside_physical_range: inside,
        adequate: true,
        material: true,
        sentence: format!("{place}, {}: {told}", spec.words),
    })
}

/// Standard errors of the reported parameters, by the delta method.
fn standard_errors(
    scene: &Scene,
    fit: &Fitted,
    at: usize,
    values: &Values,
    scale: &Scale,
) -> Vec<f64> {
    let spec = fit.unit.terms[at].kind.spec();
    let slots = fit.unit.slots(scene);
    let fitted: Vec<(usize, usize)> = slots
        .iter()
        .enumerate()
        .filter_map(|(i, s)| match s {
            Slot::Value(term, q) if *term == at => Some((i, *q)),
            _ => None,
        })
        .collect();
    let base = (spec.report)(values, scale);
    let derivatives: Vec<Vec<f64>> = fitted
        .iter()
        .map(|(_, q)| {
            let step = 1e-6
                * (spec.parameters[*q].size)(scale)
                    .abs()
                    .max(values[*q].abs());
            let mut moved = *values;
            moved[*q] += step;
            (spec.report)(&moved, scale)
                .iter()
                .zip(&base)
                .map(|(a, b)| (a.value - b.value) / step)
                .collect()
        })
        .collect();
    (0..base.len())
        .map(|r| {
            let mut variance = 0.0;
            for (a, (i, _)) in fitted.iter().enumerate() {
                for (b, (j, _)) in fitted.iter().enumerate() {
                    let (x, y) = (derivatives[a][r], derivatives[b][r]);
                    if x != 0.0 && y != 0.0 {
                        variance += x * y * fit.covariance[(*i, *j)];
                    }
                }
            }
            if variance.is_finite() {
                variance.max(0.0).sqrt()
            } else {
                f64::MAX
            }
        })
        .collect()
}

/// k, B and m of one track under a model.
pub fn estimate(scene: &Scene, model: &Model, track: usize) -> Estimate {
    let (fit, a) = model.of_track(track);
    let slots = fit.unit.slots(scene);
    let [kappa, beta, per_mass, ..] = fit.point.base[a];
    let m = 1.0 / per_mass;
    let index = |q: usize| slots.iter().position(|s| *s == Slot::Base(a, q));
    let error = |by: [(usize, f64); 2]| {
        let mut variance = 0.0;
        for (p, x) in by {
            for (q, y) in by {
                if let (Some(i), Some(j)) = (index(p), index(q)) {
                    variance += x * y * fit.covariance[(i, j)];
                }
            }
        }
        variance.max(0.0).sqrt()
    };
    Estimate {
        k_n_m: kappa * m,
        b_n_s_m: beta * m,
        k_std_n_m: error([(0, m), (2, -kappa * m * m)]),
        b_std_n_s_m: error([(1, m), (2, -beta * m * m)]),
        mass_kg: m,
        mass_std_kg: index(2).map(|_| error([(2, m * m), (3, 0.0)])),
        k_bias_percent: None,
        b_bias_percent: None,
    }
}

/// What the omission changes for the rider.
pub fn consequences(
    scene: &Scene,
    track: usize,
    plain: (&Estimate, &Motion),
    extended: (&Estimate, &Motion),
) -> Consequences {
    let s = &scene.tracks[track].scale;
    let load = |m: &Motion, by_law: bool| -> Vec<f64> {
        let constant = scene.tracks[track].input.force.is_some();
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
    let (before, after) = (load(plain.1, false), load(extended.1, true));
    let peak = |x: &[f64]| x.iter().copied().fold(0.0, f64::max);
    let airborne = after
        .iter()
        .filter(|f| **f <= 1e-3 * s.static_load.abs())
        .count() as f64
        / after.len().max(1) as f64;
    let percent = |a: f64, b: f64| if b != 0.0 { 100.0 * (a / b - 1.0) } else { 0.0 };
    let resonance = |e: &Estimate| (e.k_n_m.max(0.0) / e.mass_kg).sqrt() / std::f64::consts::TAU;
    Consequences {
        k_change_percent: percent(extended.0.k_n_m, plain.0.k_n_m),
        b_change_percent: percent(extended.0.b_n_s_m, plain.0.b_n_s_m),
        peak_load_plain_n: peak(&before),
        peak_load_extended_n: peak(&after),
        airborne_share: if scene.tracks[track].has_road {
            airborne
        } else {
            0.0
        },
        resonance_plain_hz: resonance(plain.0),
        resonance_extended_hz: resonance(extended.0),
    }
}

/// The smallest size of each offered effect that this ride would have shown: its expected score
/// reaches the family-wise threshold `bound` (standard deviations) with 95 % power.
pub fn detectable(scene: &Scene, offers: &[Signatures], bound: f64) -> Vec<Detectable> {
    offers
        .iter()
        .filter_map(|offer| {
            let spec = offer.term.kind.spec();
            let clearest = offer
                .starts
                .iter()
                .max_by(|a, b| a.size.total_cmp(&b.size))?;
            let track = scene.tracks.iter().find(|t| offer.term.acts_on(t.axle))?;
            let share = (bound + 1.65) / clearest.size;
            let mut values = clearest.unit;
            let amplitude = spec.amplitudes.first().copied().unwrap_or(0);
            values[amplitude] *= share;
            let reported = (spec.report)(&values, &track.scale).into_iter().next()?;
            Some(Detectable {
                id: spec.id.to_owned(),
                axle: offer.term.place,
                parameter: reported.name.to_owned(),
                smallest_detectable: reported.value.abs(),
                unit: reported.unit.to_owned(),
            })
        })
        .collect()
}
