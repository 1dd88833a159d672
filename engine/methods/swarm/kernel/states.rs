//! Kernel of the objectives that compare with the model's own states: paper eq. (26) with xm1, xm2
//! simulated and xm3 = Psi X.
//!
//! In the compression d = z - u, xm3 is F/m - (k/m) d - (B/m) d', so a sample costs 4 multiply-adds
//! for the state, 2 for the acceleration and 3 for the squares. A spline road adds 4 more. A linear
//! one adds none: its u'' is zero between the samples, and at a sample d' falls by what u' rises.

use std::ops::Range;

use super::block::{Block, MOST_LANES, SIDE_BY_SIDE, unpack};
use super::lanes::Lanes;
use super::streams::{b_spline, curvature, linear_gains, spline_gains};
use crate::simulate::linear::Transition;
use crate::swarm::target::{Target, gradient};
use veloid_core::settings::Objective;

/// The record of one axle.
#[derive(Clone, Debug)]
pub struct States {
    step: f64,
    /// Whether road and force are linear between samples, else cubic splines.
    linear: bool,
    forced: bool,
    rows: Vec<Row>,
    /// -u'' at the ends of the step to a sample, on a spline road.
    road: Vec<[f64; 2]>,
    /// What makes up the force in the step to a sample: two values or four B-spline coefficients (N).
    force: Vec<[f64; FORCE]>,
    /// d (m) and d' (m/s) before the first step.
    initial: [f64; 2],
    runs: Vec<Range<usize>>,
    weights: [f64; 3],
}

/// What one sample is compared with.
#[derive(Clone, Copy, Debug)]
struct Row {
    /// x1 - u (m), x2 - u' (m/s) with u' as before the sample, x3 (m/s^2).
    x: [f64; 3],
    /// u' before the sample less that which xm3 is to see (m/s), and the rise of u' at the sample.
    rate: f64,
    rise: f64,
    /// F (N).
    force: f64,
}

const FORCE: usize = 4;
/// E by rows, k/m, B/m, 1/m, and for each tap what it adds to d and to d'.
const COEFFICIENTS: usize = 7 + 2 * (2 + FORCE);

impl States {
    pub fn new(target: &Target) -> Self {
        let input = &target.input;
        let (n, step) = (input.len(), input.step);
        let linear = target.objective == Objective::Gradient;
        let u = &input.road;
        // On a linear road the first step leads to the first sample, from a road at 0.
        let before = |i: usize| if i == 0 { 0.0 } else { u[i - 1] };
        let slope: Vec<f64> = if linear {
            (0..n).map(|i| (u[i] - before(i)) / step).collect()
        } else {
            input.road_slope.clone()
        };
        let seen = if linear {
            gradient(u, step)
        } else {
            slope.clone()
        };
        let force = input.force.as_ref().map(|f| f.0.as_slice());
        let rows = (0..n).map(|i| Row {
            x: [
                target.position[i] - u[i],
                target.velocity[i] - slope[i],
                target.acceleration[i],
            ],
            rate: slope[i] - seen[i],
            rise: if linear && i + 1 < n {
                slope[i + 1] - slope[i]
            } else {
                0.0
            },
            force: force.map_or(0.0, |f| f[i]),
        });
        let mut initial = [target.initial[0] - u[0], target.initial[1] - slope[0]];
        if linear {
            initial[0] = target.initial[0];
        }
        let mut road = vec![[0.0; 2]; n];
        let mut pushed = vec![[0.0; FORCE]; n];
        if linear {
            if let Some(f) = force {
                pushed[0][1] = f[0];
                for i in 1..n {
                    pushed[i][..2].copy_from_slice(&f[i - 1..=i]);
                }
            }
        } else {
            let bend = curvature(u, &input.road_slope, step);
            for i in 1..n {
                road[i] = [-bend[i - 1], -bend[i]];
            }
            if let Some((f, slope)) = &input.force {
                let c = b_spline(f, slope, step);
                for i in 1..n {
                    pushed[i].copy_from_slice(&c[i - 1..i + 3]);
                }
            }
        }
        Self {
            step,
            linear,
            forced: force.is_some(),
            rows: rows.collect(),
            road,
            force: pushed,
            initial,
            runs: target.runs.clone(),
            weights: target.weights,
        }
    }

    #[inline(always)]
    pub fn costs<L: Lanes>(&self, thetas: &[[f64; 3]]) -> [f64; MOST_LANES] {
        match (self.linear, self.forced) {
            (true, false) => self.pass::<L, true, false>(thetas),
            (false, false) => self.pass::<L, false, false>(thetas),
            (true, true) => self.pass::<L, true, true>(thetas),
            (false, true) => self.pass::<L, false, true>(thetas),
        }
    }

    fn coefficients(&self, theta: [f64; 3]) -> [f64; COEFFICIENTS] {
        let t = Transition::new(theta[0], theta[1], self.step);
        let mut all = [0.0; COEFFICIENTS];
        all[..4].copy_from_slice(t.e.as_flattened());
        all[4..7].copy_from_slice(&theta);
        let linear = linear_gains(&t);
        all[7..11].copy_from_slice(linear.as_flattened());
        if self.forced {
            let taps = &mut all[11..];
            if self.linear {
                taps[..4].copy_from_slice(linear.as_flattened());
            } else {
                taps.copy_from_slice(spline_gains(&t).as_flattened());
            }
            taps.iter_mut().for_each(|g| *g *= theta[2]);
        }
        all
    }

    #[inline(always)]
    fn pass<L: Lanes, const LINEAR: bool, const FORCED: bool>(
        &self,
        thetas: &[[f64; 3]],
    ) -> [f64; MOST_LANES] {
        let lanes = L::WIDTH * SIDE_BY_SIDE;
        let block = Block::new(lanes, thetas, |theta| self.coefficients(theta));
        let k = block.vectors::<L>();
        let zero = L::splat(0.0);
        let mut s = [State {
            d: L::splat(self.initial[0]),
            rate: L::splat(self.initial[1]),
            squares: [zero; 3],
        }; SIDE_BY_SIDE];
        let mut done = 0;
        for run in &self.runs {
            self.advance::<L, LINEAR, FORCED, false>(done..run.start, &k, &mut s);
            self.advance::<L, LINEAR, FORCED, true>(run.clone(), &k, &mut s);
            done = run.end;
        }
        let [a, b, c] = self.weights;
        let mut costs = [zero; SIDE_BY_SIDE];
        for (cost, s) in costs.iter_mut().zip(s) {
            *cost = L::splat(a).mul(s.squares[0]);
            *cost = L::splat(b).mul_add(s.squares[1], *cost);
            *cost = L::splat(c).mul_add(s.squares[2], *cost);
        }
        unpack(costs)
    }

    #[inline(always)]
    fn advance<L: Lanes, const LINEAR: bool, const FORCED: bool, const COUNT: bool>(
        &self,
        mut samples: Range<usize>,
        k: &[[L; COEFFICIENTS]; SIDE_BY_SIDE],
        state: &mut [State<L>; SIDE_BY_SIDE],
    ) {
        let mut s = *state;
        if !LINEAR && samples.start == 0 && !samples.is_empty() {
            // On a spline road the initial state is that of the first sample.
            if COUNT {
                for v in 0..SIDE_BY_SIDE {
                    s[v].count::<LINEAR, FORCED>(&k[v], &self.rows[0]);
                }
            }
            samples.start = 1;
        }
        let rows = self.rows[samples.clone()].iter();
        let inputs = self.road[samples.clone()].iter().zip(&self.force[samples]);
        for (row, (road, force)) in rows.zip(inputs) {
            for v in 0..SIDE_BY_SIDE {
                let k = &k[v];
                let s = &mut s[v];
                let mut d = k[1].mul(s.rate);
                let mut rate = k[3].mul(s.rate);
                if !LINEAR {
                    for j in 0..2 {
                        d = k[7 + 2 * j].mul_add(L::splat(road[j]), d);
                        rate = k[8 + 2 * j].mul_add(L::splat(road[j]), rate);
                    }
                }
                if FORCED {
                    for j in 0..FORCE {
                        d = k[11 + 2 * j].mul_add(L::splat(force[j]), d);
                        rate = k[12 + 2 * j].mul_add(L::splat(force[j]), rate);
                    }
                }
                (s.d, s.rate) = (k[0].mul_add(s.d, d), k[2].mul_add(s.d, rate));
                if COUNT {
                    s.count::<LINEAR, FORCED>(k, row);
                }
                if LINEAR {
                    s.rate = s.rate.sub(L::splat(row.rise));
                }
            }
        }
        *state = s;
    }
}

/// Where a vector of particles is: d, d' and the sums of squares.
#[derive(Clone, Copy)]
struct State<L> {
    d: L,
    rate: L,
    squares: [L; 3],
}

impl<L: Lanes> State<L> {
    #[inline(always)]
    fn count<const LINEAR: bool, const FORCED: bool>(&mut self, k: &[L; COEFFICIENTS], row: &Row) {
        let position = L::splat(row.x[0]).sub(self.d);
        let velocity = L::splat(row.x[1]).sub(self.rate);
        let rate = if LINEAR {
            self.rate.add(L::splat(row.rate))
        } else {
            self.rate
        };
        let mut acceleration = k[4].mul_add(self.d, L::splat(row.x[2]));
        acceleration = k[5].mul_add(rate, acceleration);
        if FORCED {
            acceleration = k[6].neg_mul_add(L::splat(row.force), acceleration);
        }
        self.squares[0] = position.mul_add(position, self.squares[0]);
        self.squares[1] = velocity.mul_add(velocity, self.squares[1]);
        self.squares[2] = acceleration.mul_add(acceleration, self.squares[2]);
    }
}
