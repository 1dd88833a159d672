//! The missing force where it has no name.

use crate::residual::omnibus::Remainder;
use veloid_core::numerics::finite::finite;
use veloid_model::dataset::Dataset;
use veloid_model::fit::Motion;
use veloid_report::diagnosis::FreeForm;

/// The missing force without a name, on a grid of deflection and rate and along the ride. Empty where the model
/// runs away.
pub fn free_form(dataset: &Dataset, m: &Motion, left: &Remainder, t: usize) -> FreeForm {
    const CELLS: usize = 11;
    const POINTS: usize = 400;
    let mass = dataset.tracks[t].scale.mass;
    let force: Vec<f64> = (0..dataset.samples)
        .map(|i| mass * (m.acceleration[i] - m.linear[i] + left.force[i]))
        .collect();
    if force.iter().chain(&m.d).chain(&m.w).any(|x| !x.is_finite()) {
        return FreeForm::default();
    }
    let rms = |x: &[f64]| (x.iter().map(|x| x * x).sum::<f64>() / x.len().max(1) as f64).sqrt();
    let axis = |x: &[f64]| -> Vec<f64> {
        let top = 2.5 * rms(x);
        (0..CELLS)
            .map(|i| top * (2.0 * i as f64 / (CELLS - 1) as f64 - 1.0))
            .collect()
    };
    let (deflection_m, rate_m_s) = (axis(&m.d), axis(&m.w));
    let cell = |grid: &[f64], x: f64| ((x - grid[0]) / (grid[1] - grid[0])).round();
    let mut sums = vec![vec![(0.0, 0_usize); CELLS]; CELLS];
    for (i, f) in force.iter().enumerate() {
        let (c, r) = (cell(&deflection_m, m.d[i]), cell(&rate_m_s, m.w[i]));
        let inside = |x: f64| (0.0..CELLS as f64).contains(&x);
        if inside(c) && inside(r) {
            let sum = &mut sums[r as usize][c as usize];
            sum.0 += f;
            sum.1 += 1;
        }
    }
    let total = force
        .iter()
        .map(|f| f * f)
        .sum::<f64>()
        .max(f64::MIN_POSITIVE);
    let explained: f64 = sums
        .iter()
        .flatten()
        .filter(|s| s.1 > 0)
        .map(|s| s.0 * s.0 / s.1 as f64)
        .sum();
    let thin = (dataset.samples / POINTS).max(1);
    FreeForm {
        against: if explained > 0.5 * total {
            "deflection and rate"
        } else {
            "time"
        }
        .to_owned(),
        deflection_m,
        rate_m_s,
        force_n: sums
            .iter()
            .map(|r| {
                r.iter()
                    .map(|s| if s.1 > 0 { s.0 / s.1 as f64 } else { 0.0 })
                    .collect()
            })
            .collect(),
        t_s: (0..dataset.samples)
            .step_by(thin)
            .map(|i| i as f64 * dataset.step)
            .collect(),
        force_along_n: force.iter().copied().step_by(thin).collect(),
        held_out_rms_m: finite(left.held_after),
    }
}
