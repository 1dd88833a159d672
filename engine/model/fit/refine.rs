//! The chosen model once more, with steps so short that the integrator's error is far below what the
//! ride can show.

use rayon::prelude::*;

use super::damped::Effort;
use super::fitter::{Fitted, Fitter};
use super::model::{FINE, Model};
use super::unit::Point;
use veloid_core::numerics::lanes::LANES;

/// Steps of the search that make one step of the last fit.
const FINER: usize = 3;
/// Zooms at which starts between those of the search are tried.
const ZOOMS: [u32; 2] = [3, 4];

/// The model at its best under its own noise, with finer steps.
pub fn refined(fitter: &Fitter, model: &Model) -> Model {
    let substeps = FINER * model.substeps(fitter.dataset, FINE);
    let fits = model
        .fits
        .par_iter()
        .map(|fit| {
            if fit.unit.terms.is_empty() {
                return fit.clone();
            }
            let effort = Effort {
                iterations: 8,
                gain: 1e-3,
                substeps,
            };
            let start = as_expected(fitter, fit, closer(fitter, fit, substeps), effort);
            fitter
                .fit(&fit.unit, start, &fit.noise_models, effort)
                .unwrap_or_else(|| fit.clone())
        })
        .collect();
    Model::new(model.terms.clone(), fits)
}

/// The better of `start` and the best point at which what is expected of a parameter is so.
fn as_expected(fitter: &Fitter, fit: &Fitted, start: Point, effort: Effort) -> Point {
    let patient = Effort {
        iterations: 30,
        gain: 1e-4,
        ..effort
    };
    let Some(other) = fitter.fit_as_expected(&fit.unit, &start, &fit.noise_models, patient) else {
        return start;
    };
    let points = std::array::from_fn(|lane| if lane == 0 { &start } else { &other }.clone());
    let costs = fitter.costs(&fit.unit, &points, &fit.noise_models, effort.substeps);
    if costs[1] < costs[0] { other } else { start }
}

/// The best of the fitted point and those near it that the effects propose, where a fit would not get
/// from one to the other (the edges of a window in time).
fn closer(fitter: &Fitter, fit: &Fitted, substeps: usize) -> Point {
    let mut best = fit.point.clone();
    for (i, term) in fit.unit.terms.iter().enumerate() {
        let spec = term.kind.spec();
        for zoom in ZOOMS {
            let near = (spec.nearer)(&best.values[i], fit.unit.scale(fitter.dataset, i), zoom);
            let mut tried = vec![best.clone()];
            tried.extend(near.into_iter().map(|mut values| {
                for q in spec.amplitudes {
                    values[*q] = best.values[i][*q];
                }
                let mut point = best.clone();
                point.values[i] = values;
                point
            }));
            let mut least = f64::INFINITY;
            for some in tried.chunks(LANES) {
                let points = std::array::from_fn(|lane| some[lane.min(some.len() - 1)].clone());
                let costs = fitter.costs(&fit.unit, &points, &fit.noise_models, substeps);
                for (point, cost) in some.iter().zip(costs) {
                    if cost < least {
                        (least, best) = (cost, point.clone());
                    }
                }
            }
        }
    }
    best
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::effects::Kind;
    use crate::example;
    use veloid_core::bicycle::Axle;

    #[test]
    fn the_last_fit_errs_less_and_leaves_plain_axles_alone() {
        let dataset = example::dataset();
        let fitter = example::fitter(&dataset);
        let cubic = example::term(Kind::CubicStiffness, Axle::Front);
        let mut known = example::model(&dataset, &[(cubic, 1e9)]);
        known.fits[1].likelihood = 123.0;
        let finest = refined(&fitter, &known);
        assert_eq!(finest.fits[1].likelihood, 123.0);
        // The ride has no cubic spring.
        let k3 = finest.of_track(0).0.point.values[0][0];
        assert!(k3.abs() < 1e7, "{k3}");
    }
}
