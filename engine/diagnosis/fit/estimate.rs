//! Stiffness, damping and mass of an axle under a model.

use super::model::Model;
use super::unit::Slot;
use crate::diagnosis::dataset::Dataset;
use crate::numerics::finite::std_error;
use crate::report::Estimate;

/// k, B and m of one track under a model.
pub fn estimate(dataset: &Dataset, model: &Model, track: usize) -> Estimate {
    let (fit, a) = model.of_track(track);
    let slots = fit.unit.slots(dataset);
    let [kappa, beta, per_mass, ..] = fit.point.base[a];
    let m = 1.0 / per_mass;
    let moves = !dataset.tracks[track].input.prescribed;
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
        std_error(variance)
    };
    Estimate {
        k_n_m: kappa * m,
        b_n_s_m: beta * m,
        k_std_n_m: error([(0, m), (2, -kappa * m * m)]),
        b_std_n_s_m: error([(1, m), (2, -beta * m * m)]),
        mass_kg: if moves { m } else { 0.0 },
        mass_std_kg: index(2).and_then(|_| error([(2, m * m), (3, 0.0)])),
        ..Estimate::default()
    }
}
