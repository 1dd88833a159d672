//! The cheapest ride that parts two models: both are simulated on a catalogue of rides, the rival
//! refitted to what the first would record, and the rides ranked by the separation that is left.

use crate::diagnosis::dataset::Scene;
use crate::diagnosis::dataset::planned::{Change, planned};
use crate::diagnosis::fit::{COARSE, Effort, Fitted, Fitter, Model, Point};
use crate::diagnosis::search::Search;
use crate::numerics::lanes::LANES;
use crate::report::diagnosis::NextRide;

/// A ride of the catalogue: what to do, and how the present ride changes by it.
struct Plan {
    what: &'static str,
    change: Change,
}

const fn plan(what: &'static str, rougher: f64, faster: f64, back: bool) -> Plan {
    Plan {
        what,
        change: Change {
            rougher,
            faster,
            back,
        },
    }
}

/// Cheapest first: over a road, on a shaker, and where an axle is let go.
const ROADS: [Plan; 6] = [
    plan(
        "record a ride over the same road there and back",
        1.0,
        1.0,
        true,
    ),
    plan("ride the same road a quarter slower", 1.0, 0.75, false),
    plan("ride the same road a quarter faster", 1.0, 1.25, false),
    plan(
        "ride the same road at one and a half times the speed",
        1.0,
        1.5,
        false,
    ),
    plan("ride a road half as rough", 0.5, 1.0, false),
    plan("ride a road twice as rough", 2.0, 1.0, false),
];
const SHAKERS: [Plan; 5] = [
    plan("shake twice as long with the same force", 1.0, 1.0, true),
    plan(
        "shake with the same force a quarter slower",
        1.0,
        0.75,
        false,
    ),
    plan(
        "shake with the same force a quarter faster",
        1.0,
        1.25,
        false,
    ),
    plan("shake half as hard", 0.5, 1.0, false),
    plan("shake twice as hard", 2.0, 1.0, false),
];
const RELEASES: [Plan; 2] = [
    plan("let the axle go from half as far", 0.5, 1.0, false),
    plan("let the axle go from twice as far", 2.0, 1.0, false),
];

/// The rides that whoever recorded this one can record next.
fn catalogue(scene: &Scene) -> &'static [Plan] {
    if scene.tracks.iter().any(|t| t.has_road) {
        &ROADS
    } else if scene.tracks.iter().any(|t| t.input.force.is_some()) {
        &SHAKERS
    } else {
        &RELEASES
    }
}

/// Gain in log likelihood that counts as parted.
const PARTED: f64 = 20.0;

/// Gain in log likelihood below which a ride parts nothing: odds of twenty to one.
const HOPELESS: f64 = 3.0;

/// Names the first ride of the catalogue that parts the model from every rival, or else the best one that may.
pub fn propose(search: &Search, model: &Model, rivals: &[Model]) -> Option<NextRide> {
    if rivals.is_empty() {
        return None;
    }
    let mut best: Option<(f64, &Plan)> = None;
    for plan in catalogue(search.fitter.scene) {
        let scene = planned(search.fitter.scene, &plan.change);
        let samples = plan.change.samples(search.fitter.samples);
        let fitter = Fitter {
            scene: &scene,
            samples: samples.min(scene.samples),
        };
        let least = rivals
            .iter()
            .map(|r| separation(&fitter, model, r, &plan.change))
            .fold(f64::INFINITY, f64::min);
        if least.is_finite() && best.is_none_or(|b| least > b.0) {
            best = Some((least, plan));
        }
        if least >= PARTED {
            break;
        }
    }
    let (predicted_separation, plan) = best.filter(|(least, _)| *least >= HOPELESS)?;
    Some(NextRide {
        why: "several sets of effects explain this ride equally".to_owned(),
        what: plan.what.to_owned(),
        predicted_separation,
    })
}

/// Where a ride begins on a planned ride: as on the present one, but for what is let go from farther or nearer.
fn begun(scene: &Scene, fit: &Fitted, change: &Change) -> Point {
    let mut point = fit.point.clone();
    for (base, t) in point.base.iter_mut().zip(&fit.unit.tracks) {
        let track = &scene.tracks[*t];
        if !track.has_road && track.input.force.is_none() {
            let [kappa, _, _, constant, height, rate] = base;
            let rest = if *kappa > 0.0 {
                *constant / *kappa
            } else {
                0.0
            };
            *height = rest + change.rougher * (*height - rest);
            *rate *= change.rougher;
        }
    }
    point
}

/// Half the whitened squared distance between what `model` records on the planned ride and the nearest that
/// `rival` can come to it.
fn separation(on: &Fitter, model: &Model, rival: &Model, change: &Change) -> f64 {
    let mut scene = on.scene.clone();
    let substeps = model
        .substeps(&scene, COARSE)
        .max(rival.substeps(&scene, COARSE));
    for t in 0..scene.tracks.len() {
        let (fit, a) = model.of_track(t);
        let point = begun(&scene, fit, change);
        let points: [Point; LANES] = std::array::from_fn(|_| point.clone());
        let read = fit
            .unit
            .simulate(&scene, &points, None, scene.samples, substeps)
            .swap_remove(a);
        scene.tracks[t].measured = read.iter().map(|z| z.0[0]).collect();
    }
    let fitter = Fitter {
        scene: &scene,
        samples: on.samples,
    };
    let effort = Effort {
        iterations: 12,
        gain: 0.1,
        substeps,
    };
    rival
        .fits
        .iter()
        .map(|f| {
            let colours: Vec<_> = f
                .unit
                .tracks
                .iter()
                .map(|t| model.colour(*t).clone())
                .collect();
            let Some(refit) = fitter.fit(&f.unit, begun(&scene, f, change), &colours, effort)
            else {
                return 0.0;
            };
            let points: [Point; LANES] = std::array::from_fn(|_| refit.point.clone());
            0.5 * fitter.costs(&f.unit, &points, &colours, substeps)[0]
        })
        .sum()
}
