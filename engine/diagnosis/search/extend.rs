//! Sets of effects and their exact refits when one is added, dropped or replaced.

use rayon::prelude::*;

use super::score_test::{Prediction, Signatures};
use super::weak_form;
use crate::policy;
use veloid_core::bicycle::Axle;
use veloid_core::numerics::autoregressive::NoiseModel;
use veloid_model::dataset::Dataset;
use veloid_model::effects::{ALL, Kind, Shape};
use veloid_model::fit::Model;
use veloid_model::fit::integrate::BESIDE_OWN;
use veloid_model::fit::{Effort, Fitted, Fitter, Point, Term, Unit};
use veloid_model::law::{Acts, Values, padded};
use veloid_report::diagnosis::{Place, SwitchedOff};

/// Everything that may be named on this ride, and what may not, with the reason.
pub fn candidates(dataset: &Dataset) -> (Vec<Term>, Vec<SwitchedOff>) {
    let mut terms = Vec::new();
    let mut off: Vec<SwitchedOff> = Vec::new();
    let library = ALL.iter().copied().filter(|kind| !kind.spec().is_general);
    for kind in library.chain(own_law(dataset)) {
        let mut why = None;
        let mut allowed = Vec::new();
        for track in &dataset.tracks {
            let needs = kind.needs(&track.scale);
            match needs.iter().find_map(|need| dataset.lacks(track, *need)) {
                Some(lacking) => why = Some(lacking),
                None => allowed.push(track.axle),
            }
        }
        let places = places(kind.spec().acts, &allowed);
        if places.is_empty() && why.is_none() {
            why = match kind.spec().acts {
                Acts::Both => Some("both axles are needed"),
                Acts::Front => Some("the front axle was not recorded"),
                Acts::Rear => Some("the rear axle was not recorded"),
                Acts::OneAxle => None,
            };
        }
        terms.extend(places.into_iter().map(|place| Term { kind, place }));
        if let (Some(why), Some(track)) = (why, dataset.tracks.first()) {
            off.push(SwitchedOff {
                id: kind.id_on(&track.scale).to_owned(),
                why: why.to_owned(),
            });
        }
    }
    (terms, off)
}

// The integrator has room for the user's law beside the rest of a set.
const _: () = assert!(policy::MOST_TERMS <= BESIDE_OWN + 1);
const _: () = assert!(policy::MOST_BY_WINDOWS <= BESIDE_OWN + 1);

/// The user's own law, where there is one.
fn own_law(dataset: &Dataset) -> Option<Kind> {
    let law = dataset.tracks.first()?.scale.own.as_ref()?;
    Some(Kind::Own(Shape::of(law)))
}

/// Where an effect may act, given on which axles the ride has what it needs.
fn places(acts: Acts, allowed: &[Axle]) -> Vec<Place> {
    let each = allowed.iter().copied().map(Place::from);
    match acts {
        Acts::OneAxle => each.collect(),
        Acts::Front => each.filter(|place| *place == Place::Front).collect(),
        Acts::Rear => each.filter(|place| *place == Place::Rear).collect(),
        Acts::Both if allowed.len() == 2 => vec![Place::Both],
        Acts::Both => Vec::new(),
    }
}

/// Whether the model is so far from the ride on the axles of `unit` that its own stiffness and
/// damping may be wrong by factors, and linear predictions mean little.
pub fn is_far(dataset: &Dataset, model: &Model, unit: &Unit) -> bool {
    unit.tracks.iter().any(|t| {
        let track = &dataset.tracks[*t];
        let (fit, a) = model.of_track(*t);
        let noise = track.noise_variance(&fit.point.base[a]);
        let excess = fit.noise_models[a].total_variance() - 1.5 * noise;
        excess > (FAR * track.scale.d_rms).powi(2)
    })
}

/// A residual larger than this share of the deflection is far.
const FAR: f64 = 0.03;
/// Samples on which distant starts are tried.
const SHORT: usize = 1000;

/// The unit that a term joins when it is added to a model.
pub fn joined(dataset: &Dataset, model: &Model, term: Term) -> Option<Unit> {
    let mut terms = model.terms.clone();
    terms.push(term);
    Unit::all(dataset, &terms)
        .into_iter()
        .find(|u| u.terms.contains(&term))
}

/// Where a refit starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reach {
    /// At the most promising linear step from the model.
    Near,
    /// At full size beside other stiffnesses.
    Far,
}

/// Refits `model` with a term added.
pub fn extend(
    fitter: &Fitter,
    model: &Model,
    signatures: &Signatures,
    effort: Effort,
    reach: Reach,
) -> Option<Model> {
    let dataset = fitter.dataset;
    let term = signatures.term;
    let unit = joined(dataset, model, term)?;
    let at = unit.terms.iter().position(|t| *t == term)?;
    let (base, noise_models) = model.carried(&unit);
    let white: Vec<NoiseModel> = noise_models.iter().map(NoiseModel::bleached).collect();
    let mut order: Vec<&Prediction> = signatures.starts.iter().collect();
    order.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    let spec = unit.terms[at].kind.spec();
    // A linear prediction says little of an effect with states of its own.
    let near = if spec.amplitudes.is_empty() || spec.states > 1 {
        3
    } else {
        1
    };
    let starts: Vec<Point> = match reach {
        Reach::Near => order
            .iter()
            .take(near)
            .map(|p| with_values(&base, at, p.values))
            .collect(),
        Reach::Far => far_starts(fitter, &unit, at, &base, &white, effort),
    };
    let fit = (starts.into_par_iter())
        .filter_map(|start| fitter.fit(&unit, start, &white, effort))
        .collect::<Vec<Fitted>>()
        .into_iter()
        .max_by(|a, b| a.likelihood.total_cmp(&b.likelihood))?;
    Some(model.with(fit))
}

fn with_values(base: &Point, at: usize, values: Values) -> Point {
    let mut point = base.clone();
    point.values[at] = values;
    point
}

/// The two best of short fits on a short part of the ride, from the effect's starts at several sizes
/// beside several stiffnesses.
fn far_starts(
    fitter: &Fitter,
    unit: &Unit,
    at: usize,
    base: &Point,
    white: &[NoiseModel],
    effort: Effort,
) -> Vec<Point> {
    let spec = unit.terms[at].kind.spec();
    if spec.local || spec.amplitudes.len() == 2 {
        return Vec::new();
    }
    let scale = unit.scale(fitter.dataset, at);
    let short = Fitter {
        dataset: fitter.dataset,
        samples: fitter.samples.min(SHORT),
    };
    let starts = (spec.starts)(scale);
    let sizes: &[f64] = match (spec.amplitudes.len(), starts.len()) {
        (0, _) => &[1.0],
        (_, 1) => &[1.0, 4.0, 16.0],
        _ => &[3.0],
    };
    let stiffer: &[f64] = if starts.len() > 6 {
        &[1.0, 1.4]
    } else {
        &[0.1, 0.35, 1.0, 2.0]
    };
    let quick = Effort {
        iterations: 7,
        gain: 1.0,
        ..effort
    };
    let fitted = |point: Point| {
        let fit = short.fit(unit, point, white, quick)?;
        let cost: f64 = fit.residuals.iter().flatten().map(|r| r * r).sum();
        Some((cost, fit.point))
    };
    let mut points = weak_form::starts(fitter, unit, at, base);
    for start in starts {
        for size in sizes {
            let mut values = start;
            for a in spec.amplitudes {
                let [low, high] = (spec.parameters[*a].limits)(scale);
                values[*a] = (values[*a] * size).max(low).min(0.9 * high);
            }
            for stiffer in stiffer {
                let mut point = with_values(base, at, values);
                point.base.iter_mut().for_each(|b| b.kappa *= stiffer);
                points.push(point);
            }
        }
    }
    let mut ranked: Vec<(f64, Point)> = points.into_par_iter().filter_map(fitted).collect();
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
    ranked.truncate(2);
    ranked.into_iter().map(|(_, p)| p).collect()
}

/// Refits a model with free play in the place of its stops on both sides, starting from the line that their force and the spring's
/// follow beyond them; nothing where the spring between them is stiffer than they are.
pub fn unstopped(fitter: &Fitter, model: &Model, play: Term, effort: Effort) -> Option<Model> {
    let stop = Term {
        kind: Kind::BumpStop,
        ..play
    };
    let (i, fit) = model
        .fits
        .iter()
        .find_map(|f| f.unit.terms.iter().position(|t| *t == stop).map(|i| (i, f)))?;
    let [gap, stiffness, side, ..] = fit.point.values[i];
    let track = fit
        .unit
        .tracks
        .iter()
        .position(|t| play.acts_on(fitter.dataset.tracks[*t].axle))?;
    let mut point = fit.point.clone();
    let (spring, stop) = (
        point.base[track].kappa.max(0.0),
        stiffness * point.base[track].per_mass,
    );
    if side != 0.0 || spring > stop {
        return None;
    }
    let mut unit = fit.unit.clone();
    unit.terms[i] = play;
    let beyond = spring + stop;
    point.values[i] = padded([2.0 * gap * stop / beyond]);
    point.base[track].kappa = beyond;
    let fitted = fitter.fit(&unit, point, &fit.noise_models, effort)?;
    Some(model.with(fitted))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::example;

    #[test]
    fn an_effect_acts_where_the_ride_has_what_it_needs() {
        let (front, rear) = (Axle::Front, Axle::Rear);
        assert_eq!(
            places(Acts::OneAxle, &[front, rear]),
            [Place::Front, Place::Rear]
        );
        assert_eq!(places(Acts::OneAxle, &[rear]), [Place::Rear]);
        assert_eq!(places(Acts::Front, &[front, rear]), [Place::Front]);
        assert!(places(Acts::Rear, &[front]).is_empty());
        assert_eq!(places(Acts::Both, &[front, rear]), [Place::Both]);
        assert!(places(Acts::Both, &[front]).is_empty());
    }

    #[test]
    fn a_term_joins_the_unit_of_its_axle() {
        let dataset = example::dataset();
        let [cubic, gain] =
            [Kind::CubicStiffness, Kind::SensorGain].map(|kind| example::term(kind, Axle::Rear));
        let model = example::model(&dataset, &[(cubic, 0.0)]);
        let unit = joined(&dataset, &model, gain);
        let mut terms = vec![cubic, gain];
        terms.sort();
        let tracks = vec![1];
        assert_eq!(unit, Some(Unit { tracks, terms }));
    }

    #[test]
    fn a_model_is_far_that_leaves_more_than_a_share_of_the_deflection() {
        let mut dataset = example::dataset();
        dataset.tracks[0].sensor_floor = 0.0;
        dataset.tracks[0].road_floor = 0.0;
        let far = |times: f64| {
            let mut model = example::model(&dataset, &[]);
            let left = times * FAR * dataset.tracks[0].scale.d_rms;
            model.fits[0].noise_models = vec![NoiseModel::white(left * left)];
            is_far(&dataset, &model, &model.fits[0].unit)
        };
        assert!(far(1.01) && !far(0.99));
    }
}
