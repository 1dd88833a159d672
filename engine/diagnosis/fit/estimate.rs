//! Stiffness, damping and mass of an axle under a model.

use super::model::Model;
use super::unit::Slot;
use crate::diagnosis::dataset::Dataset;
use crate::numerics::finite::std_error;
use crate::plant::{Coefficient, Coefficients};
use crate::report::Estimate;

/// k, B and m of one track under a model.
pub fn estimate(dataset: &Dataset, model: &Model, track: usize) -> Estimate {
    let (fit, a) = model.of_track(track);
    let slots = fit.unit.slots(dataset);
    let base = fit.point.base[a];
    let (Coefficients { kappa, beta, .. }, m) = (base, base.mass());
    let moves = dataset.tracks[track].plant.moves();
    let index = |q: Coefficient| slots.iter().position(|s| *s == Slot::Base(a, q));
    let error = |by: [(Coefficient, f64); 2]| {
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
        k_std_n_m: error([
            (Coefficient::Kappa, m),
            (Coefficient::PerMass, -kappa * m * m),
        ]),
        b_std_n_s_m: error([
            (Coefficient::Beta, m),
            (Coefficient::PerMass, -beta * m * m),
        ]),
        mass_kg: if moves { m } else { 0.0 },
        mass_std_kg: index(Coefficient::PerMass)
            .and_then(|_| error([(Coefficient::PerMass, m * m), (Coefficient::Constant, 0.0)])),
        ..Estimate::default()
    }
}
