//! The cheapest ride that parts two models: both are simulated on a catalogue of rides, the rival
//! refitted to what the first would record, and the rides ranked by the separation that is left.

use crate::simulate::lanes::LANES;
use crate::simulate::linear::Input;

use super::NextRide;
use super::extend::Model;
use super::fit::{Effort, Fitter};
use super::model::Point;
use super::name::{COARSE, Search};
use super::scene::Scene;

/// A ride of the catalogue: what to do, and how the present ride's inputs change.
struct Plan {
    what: &'static str,
    /// Factor on road and force.
    rougher: f64,
    /// Factor on the rate at which the inputs pass, and on the speed.
    faster: f64,
}

const CATALOGUE: [Plan; 6] = [
    Plan {
        what: "repeat this ride once as it was and identify both together",
        rougher: 1.0,
        faster: 1.0,
    },
    Plan {
        what: "ride the same road a quarter slower",
        rougher: 1.0,
        faster: 0.75,
    },
    Plan {
        what: "ride the same road a quarter faster",
        rougher: 1.0,
        faster: 1.25,
    },
    Plan {
        what: "ride the same road at one and a half times the speed",
        rougher: 1.0,
        faster: 1.5,
    },
    Plan {
        what: "ride a road half as rough (or shake half as hard)",
        rougher: 0.5,
        faster: 1.0,
    },
    Plan {
        what: "ride a road twice as rough (or shake twice as hard)",
        rougher: 2.0,
        faster: 1.0,
    },
];

/// Gain in log likelihood that counts as parted.
const PARTED: f64 = 20.0;

/// Names the first ride of the catalogue that parts the model from every rival, or else the best one.
pub fn propose(search: &Search, model: &Model, rivals: &[&Model]) -> Option<NextRide> {
    let mut best: Option<(f64, &Plan)> = None;
    for plan in &CATALOGUE {
        let scene = planned(search.fitter.scene, plan);
        let least = rivals
            .iter()
            .map(|r| separation(search, &scene, model, r))
            .fold(f64::INFINITY, f64::min);
        if least.is_finite() && best.is_none_or(|b| least > b.0) {
            best = Some((least, plan));
        }
        if least >= PARTED {
            break;
        }
    }
    let (predicted_separation, plan) = best?;
    Some(NextRide {
        why: "several sets of effects explain this ride equally".to_owned(),
        what: plan.what.to_owned(),
        predicted_separation,
    })
}

fn planned(scene: &Scene, plan: &Plan) -> Scene {
    let mut next = scene.clone();
    let stretch = |x: &[f64]| -> Vec<f64> {
        (0..x.len())
            .map(|i| {
                let at = (i as f64 * plan.faster).min((x.len() - 1) as f64);
                let j = (at as usize).min(x.len().saturating_sub(2));
                x[j] + (at - j as f64) * (x[j + 1] - x[j])
            })
            .collect()
    };
    next.speed.iter_mut().for_each(|v| *v *= plan.faster);
    for track in &mut next.tracks {
        let scaled =
            |x: &[f64]| -> Vec<f64> { stretch(x).iter().map(|x| x * plan.rougher).collect() };
        let road = scaled(&track.input.road);
        let force = track.input.force.as_ref().map(|(f, _)| scaled(f));
        track.input = Input::new(&road, force.as_deref(), scene.step);
    }
    next
}

/// Half the whitened squared distance between what `model` records on the ride and the nearest that
/// `rival` can come to it.
fn separation(search: &Search, scene: &Scene, model: &Model, rival: &Model) -> f64 {
    let mut scene = scene.clone();
    let samples = search.fitter.samples;
    let substeps = model
        .substeps(&scene, COARSE)
        .max(rival.substeps(&scene, COARSE));
    for t in 0..scene.tracks.len() {
        let (fit, a) = model.of_track(t);
        let points: [Point; LANES] = std::array::from_fn(|_| fit.point.clone());
        let read = fit
            .unit
            .simulate(&scene, &points, None, scene.samples, substeps)
            .swap_remove(a);
        scene.tracks[t].measured = read.iter().map(|z| z.0[0]).collect();
    }
    let fitter = Fitter {
        scene: &scene,
        samples,
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
            let Some(refit) = fitter.fit(&f.unit, f.point.clone(), &colours, effort) else {
                return 0.0;
            };
            let points: [Point; LANES] = std::array::from_fn(|_| refit.point.clone());
            0.5 * fitter.costs(&f.unit, &points, &colours, substeps)[0]
        })
        .sum()
}
