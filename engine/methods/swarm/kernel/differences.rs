//! Kernel of the consistent objective: position errors r of the simulated model, and the squares of
//! r, D r and D^2 r.
//!
//! The compression d = z - u alone obeys
//! d_n = tr d_{n-1} - det d_{n-2} + sum_j R_j u''_{n-2+j} + sum_j F_j c_{n-2+j},
//! the state form with the velocity eliminated (u'' the spline's curvature, c the B-spline
//! coefficients of the force). On a road that is 5 multiply-adds a sample; the errors take 3 more and
//! 3 subtractions.

use std::ops::Range;

use super::block::{Block, MOST_LANES, SIDE_BY_SIDE, unpack};
use super::lanes::Lanes;
use super::streams::{b_spline, curvature, linear_gains, spline_gains};
use crate::simulate::linear::Transition;
use crate::swarm::target::Target;

/// The record of one axle.
#[derive(Clone, Debug)]
pub struct Differences {
    pub(super) step: f64,
    /// -u'' at the samples (m/s^2).
    pub(super) road: Vec<f64>,
    /// B-spline coefficients of the force (N), from the one before the first sample; without a force
    /// zeros.
    pub(super) force: Vec<f64>,
    pub(super) forced: bool,
    /// x1 - u (m).
    pub(super) compression: Vec<f64>,
    /// d (m) and d' (m/s) at the first sample.
    initial: [f64; 2],
    pub(super) runs: Vec<Range<usize>>,
    /// Weights of the squares of r, r_n - r_{n-2} and its difference over two samples again.
    pub(super) weights: [f64; 3],
}

/// Taps of the road and of the force.
pub(super) const ROAD: usize = 3;
pub(super) const FORCE: usize = 5;
/// tr, -det, the taps, d_0 and d_1.
pub(super) const COEFFICIENTS: usize = 4 + ROAD + FORCE;

impl Differences {
    pub fn new(target: &Target) -> Self {
        let input = &target.input;
        let step = input.step;
        let [r, d, dd] = target.weights;
        let over = 1.0 / (4.0 * step * step);
        let bend = curvature(&input.road, &input.road_slope, step);
        let force = match &input.force {
            Some((force, slope)) => b_spline(force, slope, step),
            None => vec![0.0; input.len() + 2],
        };
        let position = target.position.iter().zip(&input.road);
        Self {
            step,
            road: bend.into_iter().map(|b| -b).collect(),
            force,
            forced: input.force.is_some(),
            compression: position.map(|(z, u)| z - u).collect(),
            initial: [
                target.initial[0] - input.road[0],
                target.initial[1] - input.road_slope[0],
            ],
            runs: target.runs.clone(),
            weights: [r, d * over, dd * over * over],
        }
    }

    #[inline(always)]
    pub fn costs<L: Lanes>(&self, thetas: &[[f64; 3]]) -> [f64; MOST_LANES] {
        let lanes = L::WIDTH * SIDE_BY_SIDE;
        let block = Block::new(lanes, thetas, |theta| self.coefficients(theta));
        let k = block.vectors::<L>();
        let mut motion = [[L::splat(0.0); 2]; SIDE_BY_SIDE];
        let mut sums = [Sums::new(); SIDE_BY_SIDE];
        let mut done = 0;
        for run in &self.runs {
            self.through(done, run, &k, &mut motion, &mut sums);
            done = run.end;
        }
        let mut costs = [L::splat(0.0); SIDE_BY_SIDE];
        for (cost, sums) in costs.iter_mut().zip(sums) {
            *cost = self.weigh(sums);
        }
        unpack(costs)
    }

    /// The weighted sum of the squares.
    #[inline(always)]
    pub(super) fn weigh<L: Lanes>(&self, sums: Sums<L>) -> L {
        let ([a, b, c], [r, d, dd]) = (self.weights, sums.squares);
        let sum = L::splat(b).mul_add(d, L::splat(a).mul(r));
        L::splat(c).mul_add(dd, sum)
    }

    /// Simulates from sample `from` to the end of `run`, and adds the run's squares.
    #[inline(always)]
    pub(super) fn through<L: Lanes>(
        &self,
        from: usize,
        run: &Range<usize>,
        k: &[[L; COEFFICIENTS]; SIDE_BY_SIDE],
        motion: &mut [[L; 2]; SIDE_BY_SIDE],
        sums: &mut [Sums<L>; SIDE_BY_SIDE],
    ) {
        let mut errors = [[L::splat(0.0); SIDE_BY_SIDE]; CHUNK];
        let mut done = from;
        for end in [run.start, run.end] {
            while done < end {
                let samples = done..end.min(done + CHUNK);
                let errors = &mut errors[..samples.len()];
                if self.forced {
                    self.simulate::<L, true>(samples.clone(), k, motion, errors);
                } else {
                    self.simulate::<L, false>(samples.clone(), k, motion, errors);
                }
                if end == run.end {
                    for v in 0..SIDE_BY_SIDE {
                        sums[v].add(errors, v, done == run.start);
                    }
                }
                done = samples.end;
            }
        }
    }

    /// Position errors of one model at every sample (m).
    pub(super) fn errors_of(&self, theta: [f64; 3]) -> Vec<f64> {
        let k = Block::new(SIDE_BY_SIDE, &[theta], |theta| self.coefficients(theta));
        let k = k.vectors::<f64>();
        let mut errors = vec![[0.0; SIDE_BY_SIDE]; self.compression.len()];
        let mut motion = [[0.0; 2]; SIDE_BY_SIDE];
        let all = 0..errors.len();
        if self.forced {
            self.simulate::<f64, true>(all, &k, &mut motion, &mut errors);
        } else {
            self.simulate::<f64, false>(all, &k, &mut motion, &mut errors);
        }
        errors.into_iter().map(|[e, ..]| e).collect()
    }

    pub(super) fn coefficients(&self, theta: [f64; 3]) -> [f64; COEFFICIENTS] {
        let [kappa, beta, per_mass] = theta;
        let t = Transition::new(kappa, beta, self.step);
        let [[e11, e12], [e21, e22]] = t.e;
        let mut all = [0.0; COEFFICIENTS];
        all[0] = e11 + e22;
        all[1] = e12 * e21 - e11 * e22;
        let mut next = e11 * self.initial[0] + e12 * self.initial[1];
        let (road, force) = all[2..].split_at_mut(ROAD);
        for (j, [d, rate]) in linear_gains(&t).into_iter().enumerate() {
            road[j + 1] += d;
            road[j] += e12 * rate - e22 * d;
            next += d * self.road[j];
        }
        if self.forced {
            for (j, gain) in spline_gains(&t).into_iter().enumerate() {
                let [d, rate] = gain.map(|g| per_mass * g);
                force[j + 1] += d;
                force[j] += e12 * rate - e22 * d;
                next += d * self.force[j];
            }
        }
        all[COEFFICIENTS - 2] = self.initial[0];
        all[COEFFICIENTS - 1] = next;
        all
    }

    /// Simulates `samples` and writes their position errors; `motion` is d one and two samples before.
    #[inline(always)]
    fn simulate<L: Lanes, const FORCED: bool>(
        &self,
        samples: Range<usize>,
        k: &[[L; COEFFICIENTS]; SIDE_BY_SIDE],
        motion: &mut [[L; 2]; SIDE_BY_SIDE],
        errors: &mut [[L; SIDE_BY_SIDE]],
    ) {
        let Range { mut start, end } = samples;
        let mut rest = errors;
        // The first two positions come from the initial state.
        while start < end.min(2) {
            for v in 0..SIDE_BY_SIDE {
                motion[v] = [k[v][COEFFICIENTS - 2 + start], motion[v][0]];
                rest[0][v] = L::splat(self.compression[start]).sub(motion[v][0]);
            }
            rest = &mut rest[1..];
            start += 1;
        }
        if start == end {
            return;
        }
        let road = self.road[start - 2..].windows(ROAD);
        let force = self.force[start - 2..].windows(FORCE);
        let measured = &self.compression[start..end];
        let mut m = *motion;
        for (((error, y), road), force) in rest.iter_mut().zip(measured).zip(road).zip(force) {
            let y = L::splat(*y);
            for v in 0..SIDE_BY_SIDE {
                let k = &k[v];
                let [d1, d2] = m[v];
                let mut d = k[2].mul(L::splat(road[0]));
                for j in 1..ROAD {
                    d = k[2 + j].mul_add(L::splat(road[j]), d);
                }
                if FORCED {
                    for j in 0..FORCE {
                        d = k[2 + ROAD + j].mul_add(L::splat(force[j]), d);
                    }
                }
                d = k[1].mul_add(d2, d);
                d = k[0].mul_add(d1, d);
                m[v] = [d, d1];
                error[v] = y.sub(d);
            }
        }
        *motion = m;
    }
}

/// Samples between which the position errors are written down: the sums then find all registers
/// free. Even, and few enough for the first-level cache.
pub(super) const CHUNK: usize = 128;

/// Sums of squares over runs of position errors r.
#[derive(Clone, Copy)]
pub(super) struct Sums<L> {
    /// r and r_n - r_{n-2}, for the even and the odd samples of a run.
    r: [L; 2],
    d: [L; 2],
    /// Of r, r_n - r_{n-2} and the difference of that over two samples.
    pub(super) squares: [L; 3],
}

impl<L: Lanes> Sums<L> {
    #[inline(always)]
    pub(super) fn new() -> Self {
        let zero = L::splat(0.0);
        Self {
            r: [zero; 2],
            d: [zero; 2],
            squares: [zero; 3],
        }
    }

    /// Vector `v` of the next errors of a run, or of its first ones (at least four).
    #[inline(always)]
    fn add(&mut self, errors: &[[L; SIDE_BY_SIDE]], v: usize, first: bool) {
        let mut s = *self;
        let mut rest = errors;
        if first {
            for p in 0..2 {
                let r = [errors[p][v], errors[p + 2][v]];
                s.r[p] = r[1];
                s.d[p] = r[1].sub(r[0]);
                s.squares[0] = r[0].mul_add(r[0], s.squares[0]);
                s.squares[0] = r[1].mul_add(r[1], s.squares[0]);
                s.squares[1] = s.d[p].mul_add(s.d[p], s.squares[1]);
            }
            rest = &errors[4..];
        }
        let mut pairs = rest.chunks_exact(2);
        for pair in &mut pairs {
            s.count(0, pair[0][v]);
            s.count(1, pair[1][v]);
        }
        if let [last] = pairs.remainder() {
            s.count(0, last[v]);
        }
        *self = s;
    }

    #[inline(always)]
    pub(super) fn count(&mut self, parity: usize, r: L) {
        let d = r.sub(self.r[parity]);
        let dd = d.sub(self.d[parity]);
        self.squares[0] = r.mul_add(r, self.squares[0]);
        self.squares[1] = d.mul_add(d, self.squares[1]);
        self.squares[2] = dd.mul_add(dd, self.squares[2]);
        self.r[parity] = r;
        self.d[parity] = d;
    }
}
