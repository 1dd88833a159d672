//! The work that other implementations are timed on: ten trials of 20 iterations of 30 particles on
//! the `gradient` objective, in a fixed linear box, with the constants of that comparison.

use std::time::Instant;

use rayon::prelude::*;
use serde::Serialize;

use super::kernel::{Kernel, Width};
use super::search::{Axis, Rules, minimise};
use super::target::Target;
use veloid_core::bicycle::Axle;
use veloid_core::settings::{Objective, Settings};
use veloid_core::{EngineError, RideProblem};
use veloid_ride::Ride;

/// Bounds of k_F/m_F (1/s^2), B_F/m_F (1/s), k_R/m_R and B_R/m_R.
const BOX: [(f64, f64); 4] = [
    (500.0, 15_000.0),
    (2.0, 200.0),
    (200.0, 6_000.0),
    (1.0, 100.0),
];
const TRIALS: u64 = 10;
const RULES: Rules = Rules {
    particles: 30,
    iterations: 20,
    cognitive: 1.49618,
    social: 1.49618,
    inertia: (0.4, 0.9),
    ratio: (0.8, 0.95),
};

/// One line of JSON that can be compared with those of the other implementations.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Line {
    /// Name of the implementation: `veloid`.
    pub peer: String,
    /// Length of the ride (s).
    #[serde(rename = "T")]
    pub duration_s: f64,
    /// Computing alone, without reading the ride (s).
    pub inner_s: f64,
    /// Best position of every trial: k_F/m_F (1/s^2), B_F/m_F (1/s), k_R/m_R and B_R/m_R.
    pub thetas: Vec<Vec<f64>>,
    /// Best cost of every trial.
    pub costs: Vec<f64>,
    /// Simulations of both axles over the whole ride.
    pub evals: usize,
    /// Number of trials.
    pub trials: usize,
    /// Width of the vector instructions and number of threads.
    pub note: String,
}

/// Runs all trials in parallel on the current rayon pool.
///
/// # Errors
/// A ride without both axles, or one that holds nothing to compare with.
pub fn benchmark(ride: &Ride) -> Result<Line, EngineError> {
    let settings = Settings {
        objective: Objective::Gradient,
        ..Settings::default()
    };
    let width = Width::widest();
    let begin = Instant::now();
    let kernels = Axle::BOTH
        .into_iter()
        .map(|axle| {
            let record = ride.axles.get(axle).ok_or(EngineError::Ride {
                axle,
                problem: RideProblem::NotBothAxles,
            })?;
            let target = Target::new(axle, record, ride, &settings, [1.0, 1.0, 1.0])?;
            Ok(Kernel::new(&target, width))
        })
        .collect::<Result<Vec<_>, EngineError>>()?;
    let axes = BOX.map(|(low, high)| Axis::Linear { low, high });
    let courses = (1..=TRIALS)
        .into_par_iter()
        .map(|seed| {
            minimise(
                &axes,
                &[axes.len()],
                &RULES,
                seed,
                |values, costs| {
                    costs.fill(0.0);
                    for (i, kernel) in kernels.iter().enumerate() {
                        let particles = values.chunks(4);
                        let thetas: Vec<_> =
                            particles.map(|x| [x[2 * i], x[2 * i + 1], 0.0]).collect();
                        kernel.add_costs(&thetas, costs);
                    }
                },
                |_, _| Ok(()),
            )
        })
        .collect::<Result<Vec<_>, EngineError>>()?;
    let inner_s = begin.elapsed().as_secs_f64();
    Ok(Line {
        peer: "veloid".to_owned(),
        duration_s: ride.samples as f64 * ride.step_s,
        inner_s,
        thetas: courses
            .iter()
            .filter_map(|c| c.best_position.last().cloned())
            .collect(),
        costs: courses
            .iter()
            .filter_map(|c| c.best_cost.last().copied())
            .collect(),
        evals: TRIALS as usize * RULES.particles * RULES.iterations,
        trials: TRIALS as usize,
        note: format!("{width:?}, {} threads", rayon::current_num_threads()),
    })
}
