//! Exact solution of the plain vertical model, paper eq. (1), divided by the axle mass:
//! z'' = kappa (u - z) + beta (u' - z') + a(t), with kappa = k/m (1/s^2), beta = B/m (1/s) and
//! a = F/m (m/s^2); u and a are cubic splines through the samples, so a step is exact.

use nalgebra::SMatrix;

use veloid_core::numerics::spline::{cubic, lifted, slopes};
use veloid_ride::AxleRecord;

/// What drives one axle: values and spline slopes at the samples.
#[derive(Clone, Debug)]
pub struct Input {
    /// Sample interval (s).
    pub step: f64,
    /// Road height u (m).
    pub road: Vec<f64>,
    /// Slope u' (m/s) of the spline through `road`.
    pub road_slope: Vec<f64>,
    /// Applied force F (N) and F' (N/s).
    pub force: Option<(Vec<f64>, Vec<f64>)>,
    /// Whether the road's height above a mass that does not move is prescribed, and the force that answers is predicted in the
    /// place of a displacement: a rig, with a mass of 1 kg in the equations.
    pub prescribed: bool,
}

impl Input {
    /// What drives an axle on a road of heights u (m), with an applied force F (N) if there is one; one value per
    /// sample interval `step` (s).
    pub fn new(road: &[f64], force: Option<&[f64]>, step: f64) -> Self {
        Self {
            step,
            road: road.to_vec(),
            road_slope: slopes(road, step),
            force: force.map(|f| (f.to_vec(), slopes(f, step))),
            prescribed: false,
        }
    }

    /// Another record of what drives the same axle, sampled every `step` (s).
    pub fn driven_by(&self, road: &[f64], force: Option<&[f64]>, step: f64) -> Self {
        Self {
            prescribed: self.prescribed,
            ..Self::new(road, force, step)
        }
    }

    /// What drives the axle of a record: splines that pass on what moved the axle between samples. Motion that is prescribed is
    /// as it was measured, since the force answers it at the samples.
    pub fn of(record: &AxleRecord, step: f64) -> Self {
        if record.prescribed {
            Self {
                prescribed: true,
                ..Self::new(&record.displacement, None, step)
            }
        } else {
            let force = record.force.as_deref().map(lifted);
            Self::new(&lifted(&record.road), force.as_deref(), step)
        }
    }

    /// Time (s) after which a force is felt in the rate, in steps of `step` (s): never (0) where the motion is prescribed.
    #[inline(always)]
    pub fn felt_after(&self, step: f64) -> f64 {
        if self.prescribed { 0.0 } else { step }
    }

    /// Force (N) that answers at a sample where the motion is prescribed.
    pub fn answer(&self, kappa: f64, beta: f64, constant: f64, i: usize) -> f64 {
        kappa * self.road[i] + beta * self.road_slope[i] + constant
    }

    /// The first `samples` samples.
    pub fn first(&self, samples: usize) -> Self {
        let head = |x: &Vec<f64>| x[..samples].to_vec();
        Self {
            step: self.step,
            road: head(&self.road),
            road_slope: head(&self.road_slope),
            force: self.force.as_ref().map(|(f, s)| (head(f), head(s))),
            prescribed: self.prescribed,
        }
    }

    pub fn len(&self) -> usize {
        self.road.len()
    }

    pub fn is_empty(&self) -> bool {
        self.road.is_empty()
    }
}

/// One exact step: x(t+h) = E x(t) + sum_j J_j g_j for x = [z, z'] and the right-hand side's
/// non-homogeneous part g(s) = sum_j g_j s^j, s = (time in the step)/h.
#[derive(Clone, Copy, Debug)]
pub struct Transition {
    pub e: [[f64; 2]; 2],
    pub j: [[f64; 2]; 4],
}

/// 1/i! and then k!/(i+k+1)! for k = 0 to 3, i from 1: the terms of [`Transition::by_series`].
const WEIGHTS: [[f64; 5]; 39] = {
    let mut weights = [[0.0; 5]; 39];
    let mut factorial = 1.0;
    let mut i = 1;
    while i <= 39 {
        factorial *= i as f64;
        let mut weight = 1.0 / factorial;
        weights[i - 1][0] = weight;
        let mut k = 0;
        while k < 4 {
            // From the one before by k/(i+k+1).
            weight *= if k == 0 { 1.0 } else { k as f64 } / (i + k + 1) as f64;
            weights[i - 1][k + 1] = weight;
            k += 1;
        }
        i += 1;
    }
    weights
};

/// Largest number in a matrix whose exponential is taken: far beyond what any rate and [`crate::output_error::most`] bring.
const TAME: f64 = 1e12;

/// Whether the exponential of a matrix of these numbers can be taken: by squaring as often as its norm has binary
/// digits, which for one that overflows never ends.
pub(super) fn is_tame(matrix: &[f64]) -> bool {
    matrix.iter().all(|x| x.abs() <= TAME)
}

impl Transition {
    /// Any kappa and beta; negative ones give growing solutions.
    pub fn new(kappa: f64, beta: f64, step: f64) -> Self {
        let norm = (kappa.abs().sqrt() + beta.abs()) * step;
        if norm > 3.0 {
            Self::by_squaring(kappa, beta, step)
        } else {
            Self::by_series(kappa, beta, step)
        }
    }

    /// e^{Ah} B and integral of e^{Ah(1-s)} B s^j ds = sum_i (Ah)^i B j!/(i+j+1)!.
    fn by_series(kappa: f64, beta: f64, h: f64) -> Self {
        let (mut y0, mut y1) = (0.0, 1.0);
        let (mut b, mut d) = (0.0, 1.0);
        let mut j = [
            [0.0, 1.0],
            [0.0, 1.0 / 2.0],
            [0.0, 1.0 / 3.0],
            [0.0, 1.0 / 4.0],
        ];
        for weight in &WEIGHTS {
            (y0, y1) = (h * y1, -h * (kappa * y0 + beta * y1));
            b += y0 * weight[0];
            d += y1 * weight[0];
            for (term, weight) in j.iter_mut().zip(&weight[1..]) {
                term[0] += y0 * weight;
                term[1] += y1 * weight;
            }
            if (y0.abs() + y1.abs()) * weight[0] < 1e-18 {
                break;
            }
        }
        for term in &mut j {
            term[0] *= h;
            term[1] *= h;
        }
        Self {
            e: [[d + beta * b, b], [-kappa * b, d]],
            j,
        }
    }

    fn by_squaring(kappa: f64, beta: f64, h: f64) -> Self {
        let mut a = SMatrix::<f64, 6, 6>::zeros();
        a[(0, 1)] = h;
        a[(1, 0)] = -kappa * h;
        a[(1, 1)] = -beta * h;
        a[(1, 2)] = h;
        for k in 2..5 {
            a[(k, k + 1)] = 1.0;
        }
        let x = match is_tame(a.as_slice()) {
            true => a.exp(),
            false => a.map(|_| f64::NAN),
        };
        let mut factorial = 1.0;
        let j = std::array::from_fn(|k| {
            factorial *= if k == 0 { 1.0 } else { k as f64 };
            [x[(0, 2 + k)] * factorial, x[(1, 2 + k)] * factorial]
        });
        Self {
            e: [[x[(0, 0)], x[(0, 1)]], [x[(1, 0)], x[(1, 1)]]],
            j,
        }
    }
}

/// Coefficients in s of g = kappa u + beta u' + F/m on the interval after sample `i`.
#[inline(always)]
pub fn drive(input: &Input, kappa: f64, beta: f64, per_mass: f64, i: usize) -> [f64; 4] {
    let h = input.step;
    let u = cubic(
        input.road[i],
        input.road[i + 1],
        input.road_slope[i],
        input.road_slope[i + 1],
        h,
    );
    let b = beta / h;
    let mut g = [
        kappa * u[0] + b * u[1],
        kappa * u[1] + b * 2.0 * u[2],
        kappa * u[2] + b * 3.0 * u[3],
        kappa * u[3],
    ];
    if let Some((force, slope)) = &input.force {
        let f = cubic(force[i], force[i + 1], slope[i], slope[i + 1], h);
        for (g, f) in g.iter_mut().zip(f) {
            *g += per_mass * f;
        }
    }
    g
}

/// Displacement (m) and velocity (m/s) at every sample from `initial` = [z, z'] at the first one.
/// `per_mass` = 1/m (1/kg) scales the input's force; `constant` (m/s^2) is a constant force over m. Where the motion is
/// prescribed, the force that answers (N) and zeros.
pub fn simulate(
    input: &Input,
    kappa: f64,
    beta: f64,
    per_mass: f64,
    constant: f64,
    initial: [f64; 2],
) -> (Vec<f64>, Vec<f64>) {
    let n = input.len();
    if input.prescribed {
        let force = (0..n).map(|i| input.answer(kappa, beta, constant, i));
        return (force.collect(), vec![0.0; n]);
    }
    let t = Transition::new(kappa, beta, input.step);
    let (mut z, mut v) = (Vec::with_capacity(n), Vec::with_capacity(n));
    let [mut x, mut y] = initial;
    z.push(x);
    v.push(y);
    for i in 0..n.saturating_sub(1) {
        let mut g = drive(input, kappa, beta, per_mass, i);
        g[0] += constant;
        let mut next = [t.e[0][0] * x + t.e[0][1] * y, t.e[1][0] * x + t.e[1][1] * y];
        for (g, j) in g.into_iter().zip(t.j) {
            next[0] += g * j[0];
            next[1] += g * j[1];
        }
        [x, y] = next;
        z.push(x);
        v.push(y);
    }
    (z, v)
}

/// Power gain at `hz` from a force over the mass (m/s^2) to the displacement (m) of an axle with
/// k/m = `kappa` and B/m = `beta`.
pub fn force_answer(kappa: f64, beta: f64, hz: f64) -> f64 {
    let w = std::f64::consts::TAU * hz;
    1.0 / ((kappa - w * w).powi(2) + (w * beta).powi(2))
}

/// The same from the road (m) to the displacement.
pub fn road_answer(kappa: f64, beta: f64, hz: f64) -> f64 {
    let w = std::f64::consts::TAU * hz;
    (kappa * kappa + (w * beta).powi(2)) / ((kappa - w * w).powi(2) + (w * beta).powi(2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_overflows_is_no_number_and_ends() {
        for (kappa, beta, step) in [
            (1e300, 1.0, 0.01),
            (1.0, 1e200, 1.0),
            (1e15, 1e20, 1e3),
            (f64::NAN, 0.0, 1.0),
        ] {
            let t = Transition::new(kappa, beta, step);
            assert!(
                t.e.iter().flatten().any(|x| x.is_nan()),
                "{kappa} {beta} {step}"
            );
        }
        let fast = Transition::new(4e13, 6e6, 1e-6);
        assert!(fast.e.iter().flatten().all(|x| x.is_finite()));
    }

    #[test]
    fn series_and_squaring_agree() {
        for (kappa, beta) in [
            (4782.0, 50.0),
            (1.0, 0.0),
            (20_000.0, 3.0),
            (900.0, 150.0),
            (0.0, 0.0),
            (-30.0, 1.0),
        ] {
            let (a, b) = (
                Transition::by_series(kappa, beta, 0.01),
                Transition::by_squaring(kappa, beta, 0.01),
            );
            let close = |x: f64, y: f64| {
                assert!(
                    (x - y).abs() <= 1e-13 * (1.0 + x.abs().max(y.abs()).max(kappa * 0.01)),
                    "{kappa} {beta}: {x} {y}"
                )
            };
            for r in 0..2 {
                for c in 0..2 {
                    close(a.e[r][c], b.e[r][c]);
                }
            }
            for k in 0..4 {
                close(a.j[k][0], b.j[k][0]);
                close(a.j[k][1], b.j[k][1]);
            }
        }
    }

    /// Steady state of a sine road against the transfer function (beta s + kappa)/(s^2 + beta s + kappa).
    #[test]
    fn val_sine_road_meets_the_transfer_function() {
        let (kappa, beta, step, w) = (4782.0_f64, 50.0_f64, 0.01, 2.0 * std::f64::consts::PI * 1.5);
        let road: Vec<f64> = (0..2000)
            .map(|i| 0.01 * (w * i as f64 * step).sin())
            .collect();
        let (z, _) = simulate(
            &Input::new(&road, None, step),
            kappa,
            beta,
            0.0,
            0.0,
            [0.0, 0.0],
        );
        let (nr, ni, dr, di) = (kappa, beta * w, kappa - w * w, beta * w);
        let gain = (nr.hypot(ni)) / (dr.hypot(di));
        let phase = ni.atan2(nr) - di.atan2(dr);
        for (i, z) in z.iter().enumerate().skip(500).take(1000) {
            let want = 0.01 * gain * (w * i as f64 * step + phase).sin();
            assert!((z - want).abs() < 1e-7, "sample {i}: {z} instead of {want}");
        }
    }

    #[test]
    fn free_decay_is_exact() {
        let (kappa, beta, step) = (400.0_f64, 2.0_f64, 0.05);
        let (z, v) = simulate(
            &Input::new(&[0.0; 100], None, step),
            kappa,
            beta,
            0.0,
            0.0,
            [0.1, 0.0],
        );
        let (s, w) = (beta / 2.0, (kappa - beta * beta / 4.0).sqrt());
        for i in 0..100 {
            let t = i as f64 * step;
            let want = 0.1 * (-s * t).exp() * ((w * t).cos() + s / w * (w * t).sin());
            assert!((z[i] - want).abs() < 1e-14);
            assert!((v[i] + 0.1 * kappa / w * (-s * t).exp() * (w * t).sin()).abs() < 1e-12);
        }
    }
}
