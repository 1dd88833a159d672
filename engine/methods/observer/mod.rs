//! High-order sliding-mode observer, paper eqs. (12) to (18): position, velocity and acceleration of
//! one axle from its measured displacement y alone.
//!
//! With v1 = x1^ - y the three lines of eq. (12) are
//!
//! ```text
//! x1^' = x2^ - l0 |v1|^(2/3) sign(v1)
//! x2^' = x3^ - l1 l0^(1/2) |v1|^(1/3) sign(v1)
//! x3^' =     - l2 sign(v1)
//! ```
//!
//! because v2 = x2^ - x1^' and v3 = x3^ - x2^' are the correction terms of the line above.
//!
//! **Discretisation.** Explicit Euler chatters at 100 Hz. Here every step is implicit: the
//! corrections are taken at the end of the step, where sign(v1) may be any value of [-1, 1] if
//! v1 = 0. That makes one cubic equation in |v1|^(1/3), which has exactly one root, and v1 = 0 is
//! reached and held without chatter (Brogliato, Polyakov, Efimov, "The implicit discretization of
//! the supertwisting sliding-mode control algorithm", IEEE TAC 65, 2020). Between two samples y is
//! the cubic spline, taken in two steps. In sliding an implicit step gives backward
//! differences: x2^ is half a step late and x3^ a whole one, so both are read that much later.
//!
//! **Noise.** For noise of size e on y and a jerk bound f the errors of x1^, x2^, x3^ are of the
//! order e, e^(2/3) f^(1/3), e^(1/3) f^(2/3). On the paper's bicycle 0.05 mm give 0.2 mm, 0.03 m/s
//! and 10 m/s^2 at most.

mod jerk;

pub use jerk::bound as jerk_bound;

use rayon::prelude::*;

use veloid_core::numerics::spline::slopes;

/// Implicit steps per sample interval. The second takes the velocity error of a noisy 100 Hz ride
/// from 0.06 to 0.02 m/s; further ones gain nothing.
pub const SUB_STEPS: usize = 2;

/// l0, l1, l2 of eq. (15) over f^(1/3), f^(1/2) and f.
pub const GAINS: [f64; 3] = [3.0, 1.2, 1.1];

/// What the observer gives at every sample.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct States {
    /// x1^ (m): the displacement.
    pub position: Vec<f64>,
    /// x2^ (m/s).
    pub velocity: Vec<f64>,
    /// x3^ (m/s^2).
    pub acceleration: Vec<f64>,
}

/// Runs one observer per signal, each with its own jerk bound f (> 0), from rest. Four go side by side:
/// a step waits for its own divisions, not for the processor.
///
/// All signals are equally long; `step` is their sample interval (s).
pub fn differentiate_all(signals: &[(&[f64], f64)], step: f64) -> Vec<States> {
    let mut all = Vec::with_capacity(signals.len());
    for signals in signals.chunks(4) {
        match *signals {
            [(a, f)] => all.extend(differentiate([a], [f], step)),
            [(a, f), (b, g)] => all.extend(differentiate([a, b], [f, g], step)),
            [(a, f), (b, g), (c, h)] => all.extend(differentiate([a, b, c], [f, g, h], step)),
            [(a, f), (b, g), (c, h), (d, i)] => {
                all.extend(differentiate([a, b, c, d], [f, g, h, i], step));
            }
            _ => {}
        }
    }
    all
}

/// As [`differentiate_all`], for a number of signals known beforehand.
pub fn differentiate<const N: usize>(
    signals: [&[f64]; N],
    jerk_bounds: [f64; N],
    step: f64,
) -> [States; N] {
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("avx2") {
        // SAFETY: the processor has what the function is compiled for.
        return unsafe { follow_avx2(signals, jerk_bounds, step) };
    }
    follow(signals, jerk_bounds, step)
}

/// The same operations, so the same bits, in wider vectors.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn follow_avx2<const N: usize>(
    signals: [&[f64]; N],
    jerk_bounds: [f64; N],
    step: f64,
) -> [States; N] {
    follow(signals, jerk_bounds, step)
}

#[inline(always)]
fn follow<const N: usize>(signals: [&[f64]; N], jerk_bounds: [f64; N], step: f64) -> [States; N] {
    let n = signals.first().map_or(0, |s| s.len());
    let spline: Vec<_> = signals.par_iter().map(|s| slopes(s, step)).collect();
    let mut lanes = Lanes::new(signals.map(|s| s[0]), jerk_bounds, step / SUB_STEPS as f64);
    let mut states = signals.map(|_| States {
        position: vec![0.0; n],
        velocity: vec![0.0; n],
        acceleration: vec![0.0; n],
    });
    for i in 0..n {
        let now = lanes;
        let mut later = lanes;
        if i + 1 < n {
            for sub in 1..=SUB_STEPS {
                let s = sub as f64 / SUB_STEPS as f64;
                let mut y = [0.0; N];
                for l in 0..N {
                    let (y01, m) = (&signals[l][i..i + 2], &spline[l][i..i + 2]);
                    y[l] = between(y01[0], y01[1], m[0] * step, m[1] * step, s);
                }
                lanes.advance(y);
                if sub == 1 {
                    later = lanes;
                }
            }
        }
        // The states at a sample, from the observer there and one sub-step later.
        for l in 0..N {
            states[l].position[i] = now.x1[l];
            states[l].velocity[i] = 0.5 * (now.x2[l] + later.x2[l]);
            states[l].acceleration[i] = later.x3[l];
        }
    }
    states
}

/// Hermite's cubic at s of [0, 1] from end values and end slopes times the interval.
#[inline(always)]
fn between(y0: f64, y1: f64, a: f64, b: f64, s: f64) -> f64 {
    let r = 1.0 - s;
    y0 * r * r * (1.0 + 2.0 * s) + y1 * s * s * (3.0 - 2.0 * s) + (a * r - b * s) * r * s
}

/// N observers in step.
#[derive(Clone, Copy)]
struct Lanes<const N: usize> {
    step: f64,
    x1: [f64; N],
    x2: [f64; N],
    x3: [f64; N],
    /// f h, f h^2, f h^3 and 1/(f h^3).
    fh: [[f64; N]; 3],
    unit: [f64; N],
}

impl<const N: usize> Lanes<N> {
    fn new(start: [f64; N], jerk_bound: [f64; N], step: f64) -> Self {
        let fh = [1, 2, 3].map(|power| jerk_bound.map(|f| f * step.powi(power)));
        Self {
            step,
            x1: start,
            x2: [0.0; N],
            x3: [0.0; N],
            fh,
            unit: fh[2].map(f64::recip),
        }
    }

    /// One implicit step to the measurements `y`.
    ///
    /// With q = |v1|^(1/3) / (h f^(1/3)) the new v1 solves
    /// q^3 + l0 q^2 + l1 l0^(1/2) q + l2 xi = |b| / (h^3 f), xi = 1 if q > 0, else in [0, 1].
    #[inline(always)]
    fn advance(&mut self, y: [f64; N]) {
        const L1: f64 = GAINS[1] * SQRT_3;
        let h = self.step;
        for l in 0..N {
            let b = self.x1[l] + h * (self.x2[l] + h * self.x3[l]) - y[l];
            let rho = b.abs() * self.unit[l];
            let q = root(rho.max(GAINS[2]));
            let xi = (rho * (1.0 / GAINS[2])).min(1.0);
            let sign = 1.0_f64.copysign(b);
            self.x3[l] -= GAINS[2] * self.fh[0][l] * xi * sign;
            self.x2[l] += h * self.x3[l] - L1 * self.fh[1][l] * q * sign;
            self.x1[l] = y[l] + self.fh[2][l] * q * q * q * sign;
        }
    }
}

const SQRT_3: f64 = 1.732_050_807_568_877_2;

/// The root q >= 0 of q^3 + l0 q^2 + l1 l0^(1/2) q + l2 = rho, for rho >= l2.
///
/// As l0 = 3, p = q + 1 solves p^3 - c p = rho - d without a square; two of Halley's steps from a
/// cube root of the exponent give 1e-12.
#[inline(always)]
fn root(rho: f64) -> f64 {
    const C: f64 = 3.0 - GAINS[1] * SQRT_3;
    const D: f64 = GAINS[2] + 2.0 - GAINS[1] * SQRT_3;
    let r = rho - D;
    let mut p = rough_cube_root(r + C);
    for _ in 0..2 {
        let (value, slope, half_bend) = (p * (p * p - C) - r, 3.0 * p * p - C, 3.0 * p);
        p -= value * slope / (slope * slope - value * half_bend);
    }
    p - 1.0
}

/// Cube root of a positive normal number within 4 %: a third of its exponent and mantissa bits.
#[inline(always)]
fn rough_cube_root(x: f64) -> f64 {
    const BIAS: u64 = 715_094_163;
    f64::from_bits(((((x.to_bits() >> 32) * 0x5555_5556) >> 32) + BIAS) << 32)
}

#[cfg(test)]
mod tests;
