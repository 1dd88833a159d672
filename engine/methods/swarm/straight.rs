//! The objective in its plainest form: one particle, one sample, one error at a time. The kernels
//! are held to it.

use super::target::{Target, gradient};
use crate::simulate::linear::{Transition, simulate};
use veloid_core::settings::Objective;

/// J_i of paper eq. (25) for theta = [k/m, B/m, 1/m].
pub fn cost(target: &Target, theta: [f64; 3]) -> f64 {
    residuals(target, theta).iter().map(|e| e * e).sum()
}

/// The errors that count, each times the square root of its weight.
pub fn residuals(target: &Target, theta: [f64; 3]) -> Vec<f64> {
    let mut all = Vec::new();
    for (d, e) in errors(target, theta).iter().enumerate() {
        let (margin, weight) = (target.margins()[d], target.weights[d].sqrt());
        for run in &target.runs {
            let inner = &e[run.start + margin..run.end - margin];
            all.extend(inner.iter().map(|e| weight * e));
        }
    }
    all
}

/// Errors of position, velocity and acceleration at every sample, paper eq. (26).
fn errors(target: &Target, [kappa, beta, per_mass]: [f64; 3]) -> [Vec<f64>; 3] {
    let minus =
        |a: &[f64], b: &[f64]| -> Vec<f64> { a.iter().zip(b).map(|(a, b)| a - b).collect() };
    let input = &target.input;
    let step = input.step;
    let (z, v, road_slope) = match target.objective {
        Objective::Consistent | Objective::Paper => {
            let (z, v) = simulate(input, kappa, beta, per_mass, 0.0, target.initial);
            (z, v, input.road_slope.clone())
        }
        Objective::Gradient => {
            let (z, v) = linear_road(target, [kappa, beta, per_mass]);
            (z, v, gradient(&input.road, step))
        }
    };
    let position = minus(&target.position, &z);
    if target.objective == Objective::Consistent {
        let velocity = gradient(&position, step);
        let acceleration = gradient(&velocity, step);
        return [position, velocity, acceleration];
    }
    let model: Vec<f64> = (0..z.len())
        .map(|i| {
            kappa * (input.road[i] - z[i])
                + beta * (road_slope[i] - v[i])
                + per_mass * input.force.as_ref().map_or(0.0, |(f, _)| f[i])
        })
        .collect();
    let velocity = minus(&target.velocity, &v);
    let acceleration = minus(&target.acceleration, &model);
    [position, velocity, acceleration]
}

/// Displacement and velocity with road and force linear between the samples. At the sample before
/// the first the road is 0 and the state the initial one, as in a filter started from rest.
fn linear_road(target: &Target, [kappa, beta, per_mass]: [f64; 3]) -> (Vec<f64>, Vec<f64>) {
    let input = &target.input;
    let h = input.step;
    let t = Transition::new(kappa, beta, h);
    let (mut z, mut v) = (Vec::new(), Vec::new());
    let [mut x, mut y] = target.initial;
    let mut before = [0.0; 2];
    for i in 0..input.len() {
        let now = [
            input.road[i],
            input.force.as_ref().map_or(0.0, |(f, _)| f[i]),
        ];
        let (du, df) = (now[0] - before[0], now[1] - before[1]);
        let constant = kappa * before[0] + beta * du / h + per_mass * before[1];
        let rise = kappa * du + per_mass * df;
        [x, y] =
            [0, 1].map(|r| t.e[r][0] * x + t.e[r][1] * y + t.j[0][r] * constant + t.j[1][r] * rise);
        before = now;
        z.push(x);
        v.push(y);
    }
    (z, v)
}
