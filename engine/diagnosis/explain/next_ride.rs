//! The quickest ride that parts two models: both are simulated on a catalogue of rides, the rival
//! refitted to what the first would record, and the rides ranked by the time that they take to part them.

use rayon::prelude::*;

use crate::search::Search;
use veloid_core::numerics::autoregressive::NoiseModel;
use veloid_core::numerics::lanes::LANES;
use veloid_model::dataset::Dataset;
use veloid_model::dataset::planned::{Change, planned};
use veloid_model::fit::together::{Common, Together};
use veloid_model::fit::{COARSE, Effort, Fitted, Fitter, Model, Point};
use veloid_report::diagnosis::{NextRide, RidePlan};

/// A ride of the catalogue: what to do, and how the present ride changes by it.
struct Plan {
    what: &'static str,
    change: Change,
}

const fn plan(what: &'static str, rougher: f64, faster: f64) -> Plan {
    let change = Change {
        rougher,
        faster,
        ..Change::NONE
    };
    Plan { what, change }
}

/// What costs least effort first: over a road, on a shaker, and where an axle is let go. Where the rider pedals, coasting too.
const ROADS: [Plan; 9] = [
    plan("ride the same road again", 1.0, 1.0),
    plan("ride the same road a quarter slower", 1.0, 0.75),
    plan("ride the same road a quarter faster", 1.0, 1.25),
    plan(
        "ride the same road at one and a half times the speed",
        1.0,
        1.5,
    ),
    Plan {
        what: "ride the same road at a speed that varies by ±30 % with a period of 20 s",
        change: Change {
            swing: 0.3,
            ..Change::NONE
        },
    },
    Plan {
        what: "coast along the same road",
        change: Change {
            coasting: true,
            ..Change::NONE
        },
    },
    plan("ride a road half as rough", 0.5, 1.0),
    plan("ride a road twice as rough", 2.0, 1.0),
    plan("ride a road four times as rough", 4.0, 1.0),
];
const SHAKERS: [Plan; 5] = [
    plan("shake with the same force again", 1.0, 1.0),
    plan("shake with the same force a quarter slower", 1.0, 0.75),
    plan("shake with the same force a quarter faster", 1.0, 1.25),
    plan("shake half as hard", 0.5, 1.0),
    plan("shake twice as hard", 2.0, 1.0),
];
const RELEASES: [Plan; 3] = [
    plan("release the axle from the same deflection again", 1.0, 1.0),
    plan("release the axle from half the deflection", 0.5, 1.0),
    plan("release the axle from twice the deflection", 2.0, 1.0),
];

/// The rides that whoever recorded this one can record next.
fn catalogue(dataset: &Dataset) -> Vec<&'static Plan> {
    let plans: &[Plan] = if dataset.tracks.iter().any(|t| t.has_road) {
        &ROADS
    } else if dataset.tracks.iter().any(|t| t.input.force.is_some()) {
        &SHAKERS
    } else {
        &RELEASES
    };
    let pedalled = dataset.crank.iter().any(|angle| *angle != dataset.crank[0]);
    let possible = |plan: &&Plan| pedalled || !plan.change.coasting;
    plans.iter().filter(possible).collect()
}

/// Gain in log likelihood that counts as parted: what is measured scatters about it with the deviation sqrt(2 * 20), so that the tie
/// (4) is left behind in 99 % of rides.
const PARTED: f64 = 20.0;

/// Times that a ride is asked for: what ten do not part is not worth the riding.
const MOST_TIMES: f64 = 10.0;

/// What a plan predicts.
struct Prediction {
    plan: &'static Plan,
    /// Times that it has to be ridden, and the time that takes (s).
    times: f64,
    duration_s: f64,
    /// Gain in log likelihood by all of them: rides of their own noise add up.
    separation: f64,
}

/// Names the ride of the catalogue that parts the model from every rival in the least time, judged as one with the present ride.
pub fn propose(search: &Search, model: &Model, rivals: &[Model]) -> Option<NextRide> {
    if rivals.is_empty() {
        return None;
    }
    let plans = catalogue(search.fitter.dataset);
    let predicted = plans.into_par_iter().filter_map(|plan| {
        let dataset = planned(search.fitter.dataset, &plan.change);
        let next = Fitter {
            dataset: &dataset,
            samples: dataset.samples,
        };
        let least = (rivals.iter())
            .map(|rival| separation([&search.fitter, &next], model, rival, &plan.change))
            .fold(f64::INFINITY, f64::min);
        let times = (PARTED / least).ceil().max(1.0);
        (times <= MOST_TIMES).then_some(Prediction {
            plan,
            times,
            duration_s: times * dataset.samples as f64 * dataset.step,
            separation: times * least,
        })
    });
    let predicted: Vec<Prediction> = predicted.collect();
    let quickest = |a: &&Prediction, b: &&Prediction| a.duration_s.total_cmp(&b.duration_s);
    let best = predicted.iter().min_by(quickest)?;
    Some(NextRide {
        why: "several sets of effects explain this ride equally".to_owned(),
        what: match best.times {
            1.0 => format!(
                "{}, and identify it as one with this ride (`veloid study`)",
                best.plan.what
            ),
            times => format!(
                "{}, {times} times, and identify them as one with this ride (`veloid study`)",
                best.plan.what
            ),
        },
        predicted_separation: best.separation,
        plan: Some(RidePlan {
            times: best.times as u32,
            duration_s: best.duration_s,
            rougher: best.plan.change.rougher,
            faster: best.plan.change.faster,
            swing: best.plan.change.swing,
            coasting: best.plan.change.coasting,
        }),
    })
}

/// Where a ride begins on a planned ride: as on the present one, but for what is let go from farther or nearer.
fn begun(dataset: &Dataset, fit: &Fitted, change: &Change) -> Point {
    let mut point = fit.point.clone();
    for (base, t) in point.base.iter_mut().zip(&fit.unit.tracks) {
        let track = &dataset.tracks[*t];
        if !track.has_road && track.input.force.is_none() {
            let rest = if base.kappa > 0.0 {
                base.constant / base.kappa
            } else {
                0.0
            };
            base.height = rest + change.rougher * (base.height - rest);
            base.velocity *= change.rougher;
        }
    }
    point
}

/// Half the whitened squared distance between what `model` records on the planned ride and the nearest that `rival` can come to it with
/// effects whose parameters fit the `present` ride too, less what that ride costs it anyway.
fn separation(
    [present, planned]: [&Fitter; 2],
    model: &Model,
    rival: &Model,
    change: &Change,
) -> f64 {
    let mut dataset = planned.dataset.clone();
    let substeps = model
        .substeps(&dataset, COARSE)
        .max(rival.substeps(&dataset, COARSE));
    for t in 0..dataset.tracks.len() {
        let (fit, a) = model.of_track(t);
        let point = begun(&dataset, fit, change);
        let points: [Point; LANES] = std::array::from_fn(|_| point.clone());
        let read = fit
            .unit
            .simulate(&dataset, &points, None, 0..dataset.samples, substeps)
            .swap_remove(a);
        dataset.tracks[t].measured = read.iter().map(|z| z.0[0]).collect();
    }
    let rides = [
        *present,
        Fitter {
            dataset: &dataset,
            samples: planned.samples,
        },
    ];
    let effort = Effort {
        iterations: 12,
        gain: 0.1,
        substeps,
    };
    let of_unit = |f: &Fitted| {
        let noise = f.unit.tracks.iter().map(|t| model.noise_model(*t).clone());
        let start = begun(&dataset, f, change);
        apart(&rides, f, start, &noise.collect::<Vec<_>>(), effort).unwrap_or(0.0)
    };
    rival.fits.iter().map(of_unit).sum()
}

/// The same of one unit of the rival, which starts the planned ride so.
fn apart(
    [present, planned]: &[Fitter; 2],
    rival: &Fitted,
    start: Point,
    noise: &[NoiseModel],
    effort: Effort,
) -> Option<f64> {
    let now = present.fit(&rival.unit, rival.point.clone(), noise, effort)?;
    let together = Together {
        rides: vec![present, planned],
        units: vec![rival.unit.clone(); 2],
        common: Common::Effects,
        own: &[],
    };
    let noises = [noise.to_vec(), noise.to_vec()];
    let fits = together.fit(&[now.point.clone(), start], &noises, effort)?;
    let [here, there] = &fits[..] else {
        return None;
    };
    let cost = |on: &Fitter, fit: &Fitted| {
        let points: [Point; LANES] = std::array::from_fn(|_| fit.point.clone());
        on.costs(&fit.unit, &points, noise, effort.substeps)[0]
    };
    Some(0.5 * (cost(present, here) + cost(planned, there) - cost(present, &now)))
}
