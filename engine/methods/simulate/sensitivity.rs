//! Exact sensitivities of the plain model's displacement: the derivative of every exact step of
//! [`super::linear`] with respect to kappa and beta, carried along with the state.

use nalgebra::SMatrix;

use super::linear::{Input, Transition, drive, is_tame};
use veloid_core::numerics::spline::cubic;
use veloid_core::plant::Coefficients;

/// Count of [`Coefficients`]; here they go by their order.
pub const PARAMETERS: usize = 6;

/// Derivatives of a [`Transition`] with respect to kappa and beta.
fn derivatives(kappa: f64, beta: f64, h: f64) -> (Transition, Transition) {
    (
        derivative(kappa, beta, h, [-h, 0.0]),
        derivative(kappa, beta, h, [0.0, -h]),
    )
}

/// exp of [[M, M'], [0, M]] holds the derivative of exp(M) in its upper right block.
fn derivative(kappa: f64, beta: f64, h: f64, direction: [f64; 2]) -> Transition {
    let mut m = SMatrix::<f64, 12, 12>::zeros();
    for block in [0, 6] {
        m[(block, block + 1)] = h;
        m[(block + 1, block)] = -kappa * h;
        m[(block + 1, block + 1)] = -beta * h;
        m[(block + 1, block + 2)] = h;
        for k in 2..5 {
            m[(block + k, block + k + 1)] = 1.0;
        }
    }
    m[(1, 6)] = direction[0];
    m[(1, 7)] = direction[1];
    let x = match is_tame(m.as_slice()) {
        true => m.exp(),
        false => m.map(|_| f64::NAN),
    };
    let mut factorial = 1.0;
    Transition {
        e: [[x[(0, 6)], x[(0, 7)]], [x[(1, 6)], x[(1, 7)]]],
        j: std::array::from_fn(|k| {
            factorial *= if k == 0 { 1.0 } else { k as f64 };
            [x[(0, 8 + k)] * factorial, x[(1, 8 + k)] * factorial]
        }),
    }
}

/// Calls `each(sample, z, dz)` at the first `samples` samples, with dz the derivatives of z with
/// respect to kappa, beta, 1/m, constant, z(0) and z'(0); of the force that answers where the motion is prescribed.
pub fn walk(
    input: &Input,
    p: &Coefficients,
    samples: usize,
    mut each: impl FnMut(usize, f64, &[f64; PARAMETERS]),
) {
    if input.prescribed {
        for i in 0..samples.min(input.len()) {
            let force = input.answer(p.kappa, p.beta, p.constant, i);
            let by = [input.road[i], input.road_slope[i], 0.0, 1.0, 0.0, 0.0];
            each(i, force, &by);
        }
        return;
    }
    let step = Transition::new(p.kappa, p.beta, input.step);
    let (by_kappa, by_beta) = derivatives(p.kappa, p.beta, input.step);
    let mut x = p.start();
    // Derivatives of z and of z'.
    let mut dz = [0.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let mut dv = [0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    for i in 0..samples {
        each(i, x[0], &dz);
        if i + 1 == samples.min(input.len()) {
            break;
        }
        let mut g = drive(input, p.kappa, p.beta, p.per_mass, i);
        g[0] += p.constant;
        for q in 0..PARAMETERS {
            (dz[q], dv[q]) = (
                step.e[0][0] * dz[q] + step.e[0][1] * dv[q],
                step.e[1][0] * dz[q] + step.e[1][1] * dv[q],
            );
        }
        for (q, t) in [&by_kappa, &by_beta].into_iter().enumerate() {
            let direct = apply(t, x, g);
            dz[q] += direct[0];
            dv[q] += direct[1];
        }
        let h = input.step;
        let u = cubic(
            input.road[i],
            input.road[i + 1],
            input.road_slope[i],
            input.road_slope[i + 1],
            h,
        );
        add(&step, u, 0, &mut dz, &mut dv);
        add(
            &step,
            [u[1] / h, 2.0 * u[2] / h, 3.0 * u[3] / h, 0.0],
            1,
            &mut dz,
            &mut dv,
        );
        if let Some((force, slope)) = &input.force {
            let f = cubic(force[i], force[i + 1], slope[i], slope[i + 1], h);
            add(&step, f, 2, &mut dz, &mut dv);
        }
        add(&step, [1.0, 0.0, 0.0, 0.0], 3, &mut dz, &mut dv);
        x = apply(&step, x, g);
    }
}

#[inline(always)]
fn apply(t: &Transition, x: [f64; 2], g: [f64; 4]) -> [f64; 2] {
    let mut next = [
        t.e[0][0] * x[0] + t.e[0][1] * x[1],
        t.e[1][0] * x[0] + t.e[1][1] * x[1],
    ];
    for (g, j) in g.into_iter().zip(t.j) {
        next[0] += g * j[0];
        next[1] += g * j[1];
    }
    next
}

#[inline(always)]
fn add(
    t: &Transition,
    g: [f64; 4],
    q: usize,
    dz: &mut [f64; PARAMETERS],
    dv: &mut [f64; PARAMETERS],
) {
    for (g, j) in g.into_iter().zip(t.j) {
        dz[q] += g * j[0];
        dv[q] += g * j[1];
    }
}

#[cfg(test)]
mod tests {
    use super::super::linear::simulate;
    use super::*;

    #[test]
    fn sensitivities_are_the_derivatives() {
        let n = 300;
        let wave = |f: f64| -> Vec<f64> { (0..n).map(|i| 0.01 * (f * i as f64).sin()).collect() };
        let force: Vec<f64> = wave(0.31).iter().map(|x| x * 1e4).collect();
        let input = Input::new(&wave(0.17), Some(&force), 0.01);
        let p = Coefficients {
            kappa: 3000.0,
            beta: 25.0,
            per_mass: 0.03,
            constant: 0.4,
            height: 0.001,
            velocity: -0.02,
        };
        let run = |p: &Coefficients| {
            simulate(&input, p.kappa, p.beta, p.per_mass, p.constant, p.start()).0
        };
        let shifted = |q: usize, by: f64| {
            let mut s = p;
            match q {
                0 => s.kappa += by,
                1 => s.beta += by,
                2 => s.per_mass += by,
                3 => s.constant += by,
                4 => s.height += by,
                _ => s.velocity += by,
            }
            s
        };
        let base = run(&p);
        for (q, by) in [
            (0, 0.3),
            (1, 0.01),
            (2, 1e-4),
            (3, 1e-3),
            (4, 1e-5),
            (5, 1e-4),
        ] {
            let (up, down) = (run(&shifted(q, by)), run(&shifted(q, -by)));
            walk(&input, &p, n, |i, z, dz| {
                assert!((z - base[i]).abs() < 1e-15);
                let want = (up[i] - down[i]) / (2.0 * by);
                let scale = 1e-7 * (1.0 + dz[q].abs()) + 1e-9 / by * 1e-3;
                assert!(
                    (dz[q] - want).abs() < scale.max(1e-6 * want.abs()),
                    "parameter {q} sample {i}: {} {want}",
                    dz[q]
                );
            });
        }
    }
}
