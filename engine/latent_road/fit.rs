//! The most likely unknowns: Fisher's scoring with a damped step (Levenberg and Marquardt).

use nalgebra::{DMatrix, DVector, Vector2};

use super::likelihood::{Evaluation, Likelihood, Own, PATCHES, Part, UNSTEADY};
use veloid_core::numerics::levenberg_marquardt::{Damping, Descent, minimise};

/// Where a fit ended.
pub struct Fit {
    pub theta: DVector<f64>,
    pub own: Vec<Own>,
    pub at: Evaluation,
    /// Curvature by the unknowns, the windows' own at their best.
    pub curvature: DMatrix<f64>,
}

/// Gain in log likelihood that a further step is not worth: a twentieth of a standard error.
const SETTLED: f64 = 1e-3;
/// Longest steps: of an unknown (a logarithm), and of what the sensors do not share, of which little is known at the start.
const LONGEST: f64 = 1.0;
const LONGEST_NOISE: f64 = 2.5;
const DAMPING: Damping = Damping {
    first: 1e-3,
    least: 1e-9,
    after_failure: 1e-3,
    most: 1e8,
};

/// Curvature and gradient by the unknowns, the windows' own eliminated.
pub fn reduced(at: &Evaluation) -> (DMatrix<f64>, DVector<f64>) {
    let (mut curvature, mut gradient) = (at.curvature.clone(), at.gradient.clone());
    for part in &at.windows {
        gradient -= part.projected(&part.gradient);
        let Some(inverse) = part.curvature.try_inverse() else {
            continue;
        };
        for i in 0..2 {
            for j in 0..2 {
                curvature.ger(-inverse[(i, j)], &part.across[i], &part.across[j], 1.0);
            }
        }
    }
    (curvature, gradient)
}

impl Part {
    /// What of a gradient by the window's own unknowns is felt by the others.
    pub fn projected(&self, gradient: &Vector2<f64>) -> DVector<f64> {
        let by = self.curvature.try_inverse().unwrap_or_default() * gradient;
        &self.across[0] * by[0] + &self.across[1] * by[1]
    }

    /// The window's own unknowns after a step of the others.
    fn moved(&self, own: &Own, step: &DVector<f64>) -> Own {
        let across = Vector2::new(self.across[0].dot(step), self.across[1].dot(step));
        let by = self.curvature.try_inverse().unwrap_or_default() * (self.gradient + across);
        [
            own[0] - by[0].clamp(-PATCHES, PATCHES),
            own[1] - by[1].clamp(-UNSTEADY, UNSTEADY),
        ]
    }
}

/// Unknowns, and the likelihood there.
pub struct At {
    theta: DVector<f64>,
    own: Vec<Own>,
    at: Evaluation,
}

impl Descent for Likelihood<'_> {
    type Point = At;

    fn cost(&self, point: &At) -> f64 {
        point.at.value
    }

    fn equations(&self, point: &At) -> (DMatrix<f64>, DVector<f64>) {
        let (curvature, gradient) = reduced(&point.at);
        (curvature, -gradient)
    }

    fn moved(&self, point: &At, mut step: DVector<f64>) -> Option<At> {
        limit(self, &mut step);
        let theta = &point.theta + &step;
        let parts = point.own.iter().zip(&point.at.windows);
        let own: Vec<Own> = parts.map(|(own, part)| part.moved(own, &step)).collect();
        let at = self.evaluate(&theta, &own)?;
        Some(At { theta, own, at })
    }

    fn is_settled(&self, gained: f64, predicted: f64, _cost: f64) -> bool {
        gained < SETTLED && predicted < SETTLED
    }

    fn gives_up(&self, predicted: f64) -> bool {
        !(predicted >= SETTLED)
    }
}

/// Climbs from `theta` in at most `most` steps; nothing where the likelihood is none.
pub fn fit(problem: &Likelihood, theta: DVector<f64>, own: Vec<Own>, most: usize) -> Option<Fit> {
    let at = problem.evaluate(&theta, &own)?;
    let At { theta, own, at } = minimise(problem, At { theta, own, at }, DAMPING, most)?;
    let (curvature, _) = reduced(&at);
    at.value.is_finite().then_some(Fit {
        theta,
        own,
        at,
        curvature,
    })
}

/// Keeps a step within what the curvature at its start can know.
fn limit(problem: &Likelihood, step: &mut DVector<f64>) {
    let is_noise = |i: usize| problem.layout.is_noise(i);
    let longest = (0..step.len()).filter(|i| !is_noise(*i));
    let longest = longest.map(|i| step[i].abs()).fold(0.0, f64::max);
    if longest > LONGEST {
        *step *= LONGEST / longest;
    }
    for i in (0..step.len()).filter(|i| is_noise(*i)) {
        step[i] = step[i].clamp(-LONGEST_NOISE, LONGEST_NOISE);
    }
}
