//! The most likely unknowns: Fisher's scoring with a damped step (Levenberg and Marquardt).

use nalgebra::{Cholesky, DMatrix, DVector, Vector2};

use super::likelihood::{Evaluation, Likelihood, Own, PATCHES, Part, UNSTEADY};

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
/// Damping at the start, at least and at most.
const DAMPING: [f64; 3] = [1e-3, 1e-9, 1e8];

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

/// Climbs from `theta` in at most `most` steps; nothing where the likelihood is none.
pub fn fit(problem: &Likelihood, theta: DVector<f64>, own: Vec<Own>, most: usize) -> Option<Fit> {
    let (mut theta, mut own) = (theta, own);
    let mut at = problem.evaluate(&theta, &own)?;
    let (mut curvature, mut gradient) = reduced(&at);
    let mut damping = DAMPING[0];
    for _ in 0..most {
        let mut damped = curvature.clone();
        for i in 0..damped.nrows() {
            damped[(i, i)] *= 1.0 + damping;
        }
        let mut step = Cholesky::new(damped)?.solve(&-&gradient);
        let predicted = -0.5 * gradient.dot(&step);
        limit(problem, &mut step);
        let moved = &theta + &step;
        let parts = own.iter().zip(&at.windows);
        let shifted: Vec<Own> = parts.map(|(own, part)| part.moved(own, &step)).collect();
        let next = problem.evaluate(&moved, &shifted);
        if let Some(next) = next.filter(|n| n.value <= at.value) {
            let gained = at.value - next.value;
            (theta, own, at) = (moved, shifted, next);
            (curvature, gradient) = reduced(&at);
            damping = (0.1 * damping).max(DAMPING[1]);
            if gained < SETTLED && predicted < SETTLED {
                break;
            }
        } else {
            if damping > DAMPING[2] || !(predicted >= SETTLED) {
                break;
            }
            damping = 10.0 * damping.max(DAMPING[0]);
        }
    }
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
