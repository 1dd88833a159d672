//! The initial state and rest point that suit given parameters best.

use nalgebra::{Matrix3, Vector3};

use super::linear::{Input, simulate};

/// What the plain model's motion depends on linearly, besides its input.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Start {
    /// z (m) and z' (m/s) at the first sample.
    pub initial: [f64; 2],
    /// Constant force over mass (m/s^2).
    pub constant: f64,
}

/// Least squares of z - simulated z over the valid samples; the model is linear in these unknowns, so
/// this is exact. The constant is fitted where `rest_point` says so, else 0; then only the samples
/// count at which the initial state is not long forgotten.
pub fn start(
    input: &Input,
    [kappa, beta, per_mass]: [f64; 3],
    displacement: &[f64],
    valid: &[bool],
    rest_point: bool,
) -> Start {
    let count = if rest_point {
        input.len()
    } else {
        memory(kappa, beta, input.step).min(input.len())
    };
    let head = input.first(count);
    let forced = simulate(&head, kappa, beta, per_mass, 0.0, [0.0; 2]).0;
    let still = Input {
        step: input.step,
        road: vec![0.0; count],
        road_slope: vec![0.0; count],
        force: None,
        prescribed: false,
    };
    let free = |constant, initial| simulate(&still, kappa, beta, 0.0, constant, initial).0;
    let responses = [
        free(0.0, [1.0, 0.0]),
        free(0.0, [0.0, 1.0]),
        if rest_point {
            free(1.0, [0.0; 2])
        } else {
            Vec::new()
        },
    ];
    let unknowns = if rest_point { 3 } else { 2 };
    let (mut a, mut c) = (Matrix3::identity(), Vector3::zeros());
    a.view_mut((0, 0), (unknowns, unknowns)).fill(0.0);
    for i in (0..count).filter(|i| valid[*i]) {
        let r = displacement[i] - forced[i];
        for p in 0..unknowns {
            c[p] += responses[p][i] * r;
            for q in 0..unknowns {
                a[(p, q)] += responses[p][i] * responses[q][i];
            }
        }
    }
    let scale = Vector3::from_fn(|p, _| a[(p, p)].sqrt().max(f64::MIN_POSITIVE).recip());
    let scaled = Matrix3::from_fn(|p, q| a[(p, q)] * scale[p] * scale[q]);
    let found = scaled
        .try_inverse()
        .map(|inverse| (inverse * c.component_mul(&scale)).component_mul(&scale))
        .filter(|x| x.iter().all(|x| x.is_finite()));
    match found {
        Some(x) => Start {
            initial: [x[0], x[1]],
            constant: x[2],
        },
        None => Start {
            initial: [displacement[0], 0.0],
            constant: 0.0,
        },
    }
}

/// Samples until a free motion has fallen by eight decades.
fn memory(kappa: f64, beta: f64, step: f64) -> usize {
    let half = 0.5 * beta;
    let slowest = half - (half * half - kappa).max(0.0).sqrt();
    let samples = 8.0 * std::f64::consts::LN_10 / (slowest * step);
    if samples > 0.0 {
        samples.ceil() as usize
    } else {
        usize::MAX
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_what_the_motion_began_with() {
        let road: Vec<f64> = (0..500).map(|i| 0.01 * (0.2 * i as f64).sin()).collect();
        let input = Input::new(&road, None, 0.01);
        let theta = [3000.0, 20.0, 0.02];
        let want = Start {
            initial: [0.004, -0.3],
            constant: 1.7,
        };
        let (mut z, _) = simulate(
            &input,
            theta[0],
            theta[1],
            theta[2],
            want.constant,
            want.initial,
        );
        let mut valid = vec![true; z.len()];
        z[77] = 1.0;
        valid[77] = false;
        let found = start(&input, theta, &z, &valid, true);
        assert!((found.initial[0] - want.initial[0]).abs() < 1e-12);
        assert!((found.initial[1] - want.initial[1]).abs() < 1e-10);
        assert!((found.constant - want.constant).abs() < 1e-9);
    }
}
