//! What windows of the record affirm although no model explains the ride.

use super::affirm::{Claim, reported};
use super::partly::{Partly, Predictions, Rest, of_squares, search_by_squares};
use super::twice::{Sights, is_little, look_twice};
use super::windows::{Supported, parameters};
use crate::policy;
use crate::search::Search;
use crate::search::in_windows::Seen;
use crate::search::weak_form;
use veloid_core::EngineError;
use veloid_core::bicycle::PerAxle;
use veloid_core::numerics::finite::finite;
use veloid_core::plant::Coefficient;
use veloid_model::dataset::Dataset;
use veloid_model::dataset::windows::dominant_period;
use veloid_model::fit::{Effort, Fitted, Model, Point, Term};
use veloid_report::diagnosis::Support;

/// What windows see of every track where something is left and that no road passes below: what a tyre does to a road is damped, so that one
/// simulation of all of it does not drift.
pub fn sighted(
    search: &Search,
    record: &Dataset,
    rest: &Rest,
    until: u64,
) -> Result<Vec<Option<Sights>>, EngineError> {
    let benches = record.tracks.iter().zip(&rest.remains);
    let asked: Vec<bool> = benches
        .map(|(t, remains)| *remains && !record.is_ridden(t))
        .collect();
    let nothing = || Ok(asked.iter().map(|_| None).collect());
    if !asked.contains(&true) {
        return nothing();
    }
    let dataset = of_squares(record);
    let Some(again) = search_by_squares(search, &dataset, &rest.remains, until) else {
        return nothing();
    };
    let of_track = |(t, asked): (usize, &bool)| {
        if !asked {
            return Ok(None);
        }
        look_twice(&again, t, missed(&dataset, t), None)
    };
    asked.iter().enumerate().map(of_track).collect()
}

pub fn missed(dataset: &Dataset, t: usize) -> Option<f64> {
    let track = &dataset.tracks[t];
    weak_form::missed(dataset, track, dataset.samples, dominant_period(track)?)
}

/// Whether no road drives any axle, and the plain model misses hardly anything of the force on them.
pub fn misses_little(record: &Dataset) -> bool {
    let little = |t| missed(record, t).is_some_and(is_little);
    let mut tracks = record.tracks.iter().enumerate();
    tracks.all(|(t, track)| !track.has_road && little(t))
}

/// A model with fewer numbers that windows of both lengths support on an axle in the place of several effects of `model`, and that
/// leaves as little there; nothing where there is none.
pub fn simpler(
    search: &Search,
    record: &Dataset,
    model: &Model,
) -> Result<Option<Model>, EngineError> {
    let dataset = of_squares(record);
    for fit in &model.fits {
        let ([t], [_, _, ..]) = (&fit.unit.tracks[..], &fit.unit.terms[..]) else {
            continue;
        };
        if dataset.is_ridden(&dataset.tracks[*t]) {
            continue;
        }
        let remains: Vec<bool> = (0..dataset.tracks.len()).map(|other| other == *t).collect();
        let until = dataset.work.done() + search.budget.steps;
        let Some(again) = search_by_squares(search, &dataset, &remains, until) else {
            continue;
        };
        let Some(sights) = look_twice(&again, *t, missed(&dataset, *t), Some(fit))? else {
            continue;
        };
        let own = |e: &Supported| fit.unit.terms.contains(&e.term);
        let terms = sights.models.first().map_or(&[][..], Seen::terms);
        let others = !sights.agreed.iter().all(own);
        let fewer = parameters(terms) < parameters(&fit.unit.terms);
        if others && fewer && leave_as_little(&sights.models, &sights.known) {
            return Ok(beside(search, model, fit, &sights.models[0]));
        }
    }
    Ok(None)
}

/// Whether models leave as little as what is known at every length, and at one at least.
fn leave_as_little(simple: &[Seen], known: &[Seen]) -> bool {
    let mut pairs = simple.iter().zip(known).peekable();
    pairs.peek().is_some()
        && pairs.all(|(simple, known)| simple.left() <= policy::MARGIN * known.left())
}

/// The model with what windows see on one axle in the place of a fit.
fn beside(search: &Search, model: &Model, fit: &Fitted, seen: &Seen) -> Option<Model> {
    let mut point = seen.point.clone();
    point.base[0] = point.base[0].starting_as(&fit.point.base[0]);
    let effort = Effort {
        substeps: (seen.unit).fine_substeps(search.fitter.dataset, &seen.point),
        ..search.thorough(model)
    };
    let fitted = search
        .fitter
        .fit(&seen.unit, point, &fit.noise_models, effort)?;
    Some(model.with(fitted))
}

/// The effects that windows of both lengths support, and the model with these alone, whose common numbers are those of the longer
/// windows; nothing where there are none.
pub fn by_windows(
    search: &Search,
    record: &Dataset,
    rest: &Rest,
    sighted: &[Option<Sights>],
) -> Option<Partly> {
    if !sighted.iter().flatten().any(|s| !s.agreed.is_empty()) {
        return None;
    }
    let dataset = of_squares(record);
    let again = search_by_squares(search, &dataset, &rest.remains, search.until)?;
    let (mut fits, mut claims, mut effect_errors) = (Vec::new(), Vec::new(), Vec::new());
    let (mut base_errors, mut in_windows) = (PerAxle::default(), PerAxle::default());
    for (t, sighted) in sighted.iter().enumerate() {
        let (plain, _) = again.plain.of_track(t);
        let agreed = sighted.as_ref().filter(|s| !s.agreed.is_empty());
        let Some(sights) = agreed else {
            fits.push(plain.clone());
            continue;
        };
        let fit = whole(&again, plain, &sights.models[0])?;
        for effect in &sights.agreed {
            effect_errors.push(effect_error(&dataset, &fit, effect.term, &sights.models));
            claims.push(claim(&dataset, effect, sights.of_length[0].length));
        }
        let axle = dataset.tracks[t].axle;
        base_errors.set(axle, base_error(&sights.models));
        in_windows.set(axle, predictions(sights, dataset.tracks[t].spread()));
        fits.push(fit);
    }
    let terms: Vec<Term> = fits
        .iter()
        .flat_map(|f| f.unit.terms.iter().copied())
        .collect();
    Some(Partly {
        model: Model::new(terms, fits),
        plain: again.plain,
        claims,
        effect_errors,
        base_errors,
        in_windows,
    })
}

/// What one simulation of the whole record affirms, less what windows contradict.
pub fn uncontradicted(mut found: Partly, record: &Dataset, sighted: &[Option<Sights>]) -> Partly {
    for (track, sighted) in record.tracks.iter().zip(sighted) {
        let own: Vec<&mut Claim> = (found.claims.iter_mut())
            .filter(|claim| claim.holds && claim.term.acts_on(track.axle))
            .collect();
        let claimed: Vec<Term> = own.iter().map(|claim| claim.term).collect();
        let contradicted = sighted.as_ref().is_some_and(|s| s.contradict(&claimed));
        if contradicted && !claimed.is_empty() {
            own.into_iter().for_each(|claim| claim.holds = false);
        }
    }
    found
}

/// The model along the whole record, with a start of its own.
fn whole(again: &Search, plain: &Fitted, seen: &Seen) -> Option<Fitted> {
    let dataset = again.fitter.dataset;
    let mut point = seen.point.clone();
    point.base[0] = point.base[0].starting_as(&plain.point.base[0]);
    let effort = Effort {
        iterations: 8,
        gain: 1e-2,
        substeps: seen.unit.fine_substeps(dataset, &seen.point),
    };
    again
        .fitter
        .started(&seen.unit, &point, &plain.noise_models, effort)
}

fn claim(dataset: &Dataset, effect: &Supported, window: f64) -> Claim {
    let [blocks, blocks_led] = effect.unseen.unwrap_or(effect.blocks);
    Claim {
        term: effect.term,
        holds: true,
        holds_as_limit: true,
        support: Support {
            removed_share: effect.share,
            blocks,
            blocks_led,
            selected_apart: effect.unseen.is_some(),
            rival: effect.rival.map(|(term, _)| term.id(dataset).to_owned()),
            rival_ratio: effect.rival.and_then(|(_, ratio)| finite(ratio)),
            disagreement: None,
            window_s: Some(window),
        },
    }
}

/// What the longer windows leave, where the record's standard deviation is `spread`.
fn predictions(sights: &Sights, spread: f64) -> Predictions {
    let sight = &sights.of_length[0];
    let rms = |seen: &Seen| spread * seen.left().sqrt();
    Predictions {
        horizon: 0.5 * sight.length,
        plain: rms(&sight.plain),
        extended: rms(&sights.models[0]),
    }
}

/// All points at which windows have a model: by length those of all windows and of each fold.
fn points(models: &[Seen]) -> impl Iterator<Item = &Point> {
    models.iter().flat_map(|seen| seen.folds.iter())
}

/// Standard error of a number that every fold of every length shows: half of what they spread.
fn spread(values: impl Iterator<Item = f64>) -> f64 {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
        (low.min(x), high.max(x))
    });
    0.5 * (high - low)
}

/// Standard errors of what is reported of an effect.
fn effect_error(dataset: &Dataset, fit: &Fitted, term: Term, models: &[Seen]) -> Vec<f64> {
    let reported = |point: &Point| {
        let at = Fitted {
            point: point.clone(),
            ..fit.clone()
        };
        reported(dataset, &at, term).unwrap_or_default()
    };
    let all: Vec<Vec<f64>> = points(models).map(reported).collect();
    let count = all.first().map_or(0, Vec::len);
    (0..count)
        .map(|r| spread(all.iter().map(|reported| reported[r])))
        .collect()
}

/// The same of k (N/m) and B (N s/m).
fn base_error(models: &[Seen]) -> [f64; 2] {
    [Coefficient::Kappa, Coefficient::Beta].map(|number| {
        let per_mass = |p: &Point| p.base[0].get(number) / p.base[0].per_mass;
        spread(points(models).map(per_mass))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::example;

    /// A model without effects that leaves so much of its windows.
    fn seen(left: f64) -> Seen {
        let dataset = example::dataset();
        let unit = veloid_model::fit::Unit {
            tracks: vec![0],
            terms: Vec::new(),
        };
        let point = example::point(&dataset, &unit, Vec::new());
        Seen {
            unit,
            folds: [point.clone(), point.clone()],
            point,
            errors: vec![left; 4],
        }
    }

    #[test]
    fn a_simpler_model_leaves_as_little_at_every_length() {
        let simple = |times: f64| seen(times * policy::MARGIN * 0.2);
        let known = [seen(0.2), seen(0.2)];
        assert!(leave_as_little(&[simple(0.99), simple(0.99)], &known));
        assert!(!leave_as_little(&[simple(0.99), simple(1.01)], &known));
        assert!(!leave_as_little(&[], &known));
    }

    #[test]
    fn an_error_is_half_of_what_folds_spread() {
        assert_eq!(spread([3.0, -1.0, 2.0].into_iter()), 2.0);
        assert_eq!(spread([3.0].into_iter()), 0.0);
    }
}
