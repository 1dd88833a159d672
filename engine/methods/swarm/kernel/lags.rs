//! The consistent objective of a long ride without going through the ride.
//!
//! The model is linear and does not change with time, so a sum of squares of its errors over a run of samples
//! follows from lagged products of the record, taken once, and from what happens at the run's two ends. Such
//! a cost takes as many steps as the model remembers samples, however long the ride.
//!
//! A reference model with parameters in the middle of the box splits the error of any other into the
//! reference's error e, and what the two models differ by, which is driven by the reference's motion d and
//! by the input c times differences of coefficients. With A = 1 - tr q^-1 + det q^-2 the errors obey A r = g,
//! g = P_e e + P_d d + P_c c, so that near the reference nothing large cancels. Let the three signals be zero
//! outside the run: their response r^ differs from r only in the first samples and goes on beyond the
//! last. With S the lagged products of e, d, c and rho those of the impulse response of 1/A, the sum over all time is
//!
//! ```text
//! Q = sum over lags l of S_gg[l] eta[l],   eta = q0 rho[l] + q2 rho[l +- 2]/2 + q4 rho[l +- 4]/2
//! ```
//!
//! where q0, q2, q4 belong to the squares of r, r_n - r_{n-2} and its difference again. Away from zero eta obeys the
//! recursion of A, so that few lags are computed singly and all others by two sums per pair of signals.

use std::ops::Range;

use super::block::{Block, MOST_LANES, SIDE_BY_SIDE, unpack};
use super::correlations::{PAIRS, SIGNALS, correlations};
use super::differences::{CHUNK, COEFFICIENTS, Differences, FORCE, ROAD, Sums};
use super::lanes::Lanes;

/// Runs shorter than this are gone through.
const LONG_RUN: usize = 20_000;
/// Share of a long run that the model may remember: one in so many samples.
const MOST_SHARE: usize = 16;
/// Least (k/m) h^2: below it the errors are small differences of large ones.
const LEAST_STIFFNESS: f64 = 1e-3;
/// Time constants after which what is left of a motion is far below the 1e-10 to which both ways agree.
const FORGOTTEN: f64 = 27.0;
/// Lags about zero that are taken singly. Away from them eta obeys the recursion of A.
const NEAR: usize = 8;
/// Samples before the present one that a coefficient reaches.
const REACH: usize = FORCE - 1;

/// What a particle makes of the products, in a block's order: A; P_e, P_d, P_c; eta at two lags; what the sums
/// over far lags count, per pair; the sum over near lags.
const OWN: usize = 2 + SIGNALS * FORCE;
const START: usize = OWN;
const FAR: usize = START + 2;
const NEAR_SUM: usize = FAR + 2 * PAIRS;
const NUMBERS: usize = NEAR_SUM + 1;

/// The record of one axle as lagged products.
#[derive(Clone, Debug)]
pub struct Lags {
    /// Coefficients of the reference model.
    reference: [f64; COEFFICIENTS],
    long: Vec<Ends>,
    products: Vec<[f64; PAIRS]>,
    /// q0, q2, q4.
    weights: [f64; 3],
}

/// e, d, c at the two ends of a long run, [`REACH`] zeros outside.
#[derive(Clone, Debug)]
struct Ends {
    head: Vec<[f64; SIGNALS]>,
    tail: Vec<[f64; SIGNALS]>,
}

impl Lags {
    /// `reference`: parameters in the middle of those to come. `None` where there is nothing to gain.
    pub fn new(form: &Differences, reference: [f64; 3]) -> Option<Self> {
        let is_long = |run: &&Range<usize>| run.len() >= LONG_RUN;
        let runs: Vec<_> = form.runs.iter().filter(is_long).cloned().collect();
        let most = runs.iter().map(|run| run.len()).min()? / MOST_SHARE;
        if form.forced && form.road.iter().any(|bend| *bend != 0.0) {
            return None;
        }
        let e = form.errors_of(reference);
        let d: Vec<f64> = form
            .compression
            .iter()
            .zip(&e)
            .map(|(y, e)| y - e)
            .collect();
        // The input that a sample is the first to feel.
        let c = match form.forced {
            true => &form.force[FORCE - ROAD..],
            false => &form.road,
        };
        let ends = |run: &Range<usize>| {
            let at = |n: usize| [e[n], d[n], c[n]];
            let outside = [[0.0; SIGNALS]; REACH].into_iter();
            let length = most + 4 * CHUNK;
            Ends {
                head: outside
                    .clone()
                    .chain((run.start..run.start + length).map(at))
                    .collect(),
                tail: (run.end - length..run.end).map(at).chain(outside).collect(),
            }
        };
        let [r, d1, d2] = form.weights;
        Some(Self {
            reference: form.coefficients(reference),
            long: runs.iter().map(ends).collect(),
            products: correlations([&e, &d, &c[..d.len()]], &runs, most + NEAR),
            weights: [r + 2.0 * d1 + 6.0 * d2, -2.0 * d1 - 8.0 * d2, 2.0 * d2],
        })
    }

    /// Samples after which a particle's model has forgotten all but e^-27 = 2e-12 of its motion, where this way is exact and cheaper.
    pub fn memory(&self, form: &Differences, [kappa, beta, _]: [f64; 3]) -> Option<usize> {
        let half = 0.5 * beta;
        let slowest = half - (half * half - kappa).max(0.0).sqrt();
        let samples = FORGOTTEN / (slowest * form.step);
        let stiff = kappa * form.step * form.step >= LEAST_STIFFNESS;
        let most = self.products.len() - 2 * NEAR;
        // Even, as the sums of squares go in pairs of samples.
        (stiff && samples > 0.0 && samples < most as f64)
            .then(|| (samples as usize + 1).next_multiple_of(2).max(NEAR))
    }

    /// Costs of particles that remember no more than `memory` samples.
    #[inline(always)]
    pub fn costs<L: Lanes>(
        &self,
        form: &Differences,
        thetas: &[[f64; 3]],
        memory: usize,
    ) -> [f64; MOST_LANES] {
        let lanes = L::WIDTH * SIDE_BY_SIDE;
        let k = Block::new(lanes, thetas, |theta| form.coefficients(theta)).vectors::<L>();
        let own = Block::new(lanes, thetas, |theta| self.numbers(form, theta)).vectors::<L>();
        let head = (memory + 2 * REACH).next_multiple_of(CHUNK);
        let met = met(form, &k, memory, head);
        let mut costs = [L::splat(0.0); SIDE_BY_SIDE];
        for v in 0..SIDE_BY_SIDE {
            let mut ends = Sums::new();
            for long in &self.long {
                respond(&mut ends, &own[v], long, memory, head);
            }
            let all = L::splat(2.0).mul_add(self.far(&own[v], memory), own[v][NEAR_SUM]);
            costs[v] = all.sub(form.weigh(ends)).add(form.weigh(met[v]));
        }
        unpack(costs)
    }

    /// The sum over the far lags on one side.
    #[inline(always)]
    fn far<L: Lanes>(&self, own: &[L; NUMBERS], memory: usize) -> L {
        let zero = L::splat(0.0);
        let (mut sums, mut eta) = ([[zero; 2]; PAIRS], [own[START], own[START + 1]]);
        for products in &self.products[NEAR + 1..memory + NEAR] {
            for (sum, s) in sums.iter_mut().zip(products) {
                let s = L::splat(*s);
                sum[0] = s.mul_add(eta[0], sum[0]);
                sum[1] = s.mul_add(eta[1], sum[1]);
            }
            eta = [own[0].mul_add(eta[0], own[1].mul(eta[1])), eta[0]];
        }
        let mut all = zero;
        for (pair, sum) in sums.into_iter().enumerate() {
            all = own[FAR + 2 * pair].mul_add(sum[0], all);
            all = own[FAR + 2 * pair + 1].mul_add(sum[1], all);
        }
        all
    }

    fn numbers(&self, form: &Differences, theta: [f64; 3]) -> [f64; NUMBERS] {
        let k = form.coefficients(theta);
        let off = |i: usize| self.reference[i] - k[i];
        let mut p = [[0.0; FORCE]; SIGNALS];
        p[0][..3].copy_from_slice(&[1.0, -k[0], -k[1]]);
        p[1][1..3].copy_from_slice(&[off(0), off(1)]);
        let (first, taps) = if form.forced {
            (2 + ROAD, FORCE)
        } else {
            (2, ROAD)
        };
        for i in 0..taps {
            p[2][i] = off(first + taps - 1 - i);
        }
        let mut own = [0.0; NUMBERS];
        own[..2].copy_from_slice(&k[..2]);
        for (own, p) in own[2..].chunks_exact_mut(FORCE).zip(&p) {
            own.copy_from_slice(p);
        }
        let eta = eta([k[0], k[1]], self.weights);
        own[START..FAR].copy_from_slice(&[eta[NEAR - REACH + 1], eta[NEAR - REACH]]);
        let recursion = recursion([k[0], k[1]]);
        for pair in 0..PAIRS {
            let (a, b) = (&p[pair / SIGNALS], &p[pair % SIGNALS]);
            for (i, a) in a.iter().enumerate() {
                for (j, b) in b.iter().enumerate() {
                    // The product counts eta that many lags earlier; REACH more than that is never negative.
                    let (product, late) = (a * b, REACH + j - i);
                    for (q, r) in recursion[late].into_iter().enumerate() {
                        own[FAR + 2 * pair + q] += product * r;
                    }
                    for (lag, products) in self.products[..=NEAR].iter().enumerate() {
                        let sides = if lag == 0 { 1.0 } else { 2.0 };
                        let at = (lag + REACH).abs_diff(late);
                        own[NEAR_SUM] += sides * product * products[pair] * eta[at];
                    }
                }
            }
        }
        own
    }
}

/// Lagged products of the impulse response of 1/A, with the weights of the squares: eta[0], eta[1] ..
fn eta([tr, det]: [f64; 2], [q0, q2, q4]: [f64; 3]) -> [f64; NEAR + REACH + 1] {
    let mut rho = [0.0; NEAR + 2 * REACH + 1];
    rho[0] = (1.0 - det) / ((1.0 + det) * (1.0 - det - tr) * (1.0 - det + tr));
    rho[1] = tr / (1.0 - det) * rho[0];
    for i in 2..rho.len() {
        rho[i] = tr * rho[i - 1] + det * rho[i - 2];
    }
    std::array::from_fn(|i| {
        let both = |by: usize| rho[i + by] + rho[i.abs_diff(by)];
        q0 * rho[i] + 0.5 * (q2 * both(2) + q4 * both(4))
    })
}

/// eta[l - t] in terms of eta[l - REACH], eta[l - REACH - 1], for t from -REACH to REACH.
fn recursion([tr, det]: [f64; 2]) -> [[f64; 2]; 2 * REACH + 1] {
    let mut terms = [[0.0; 2]; 2 * REACH + 2];
    terms[2 * REACH + 1] = [0.0, 1.0];
    terms[2 * REACH] = [1.0, 0.0];
    for t in (0..2 * REACH).rev() {
        terms[t] = [0, 1].map(|q| tr * terms[t + 1][q] + det * terms[t + 2][q]);
    }
    std::array::from_fn(|t| terms[t])
}

/// Squares of the errors in short runs, and in the first `head` samples of long ones.
#[inline(always)]
fn met<L: Lanes>(
    form: &Differences,
    k: &[[L; COEFFICIENTS]; SIDE_BY_SIDE],
    memory: usize,
    head: usize,
) -> [Sums<L>; SIDE_BY_SIDE] {
    let zero = L::splat(0.0);
    let (mut done, mut motion) = (0, [[zero; 2]; SIDE_BY_SIDE]);
    let mut sums = [Sums::new(); SIDE_BY_SIDE];
    for run in &form.runs {
        let felt_from = run.start.saturating_sub(memory);
        if felt_from > done.max(2) {
            (done, motion) = (felt_from, [[zero; 2]; SIDE_BY_SIDE]);
        }
        let length = if run.len() < LONG_RUN {
            run.len()
        } else {
            head
        };
        let seen = run.start..run.start + length;
        form.through(done, &seen, k, &mut motion, &mut sums);
        done = seen.end;
    }
    sums
}

/// Squares of r^ that the sum over all time holds and the run does not: in its first `head` samples,
/// where r^ is not r, and after its last.
#[inline(always)]
fn respond<L: Lanes>(
    ends: &mut Sums<L>,
    own: &[L; NUMBERS],
    long: &Ends,
    memory: usize,
    head: usize,
) {
    let mut first = Response::new();
    first.to(&long.head[..REACH + head], own);
    let mut last = Response::new();
    let from = long.tail.len() - 2 * REACH - memory;
    let tail = &long.tail[from..];
    last.to(&tail[..REACH + memory], own);
    last.sums.squares = [L::splat(0.0); 3];
    last.to(&tail[memory..], own);
    last.decay(memory + 2 * REACH, own);
    for (end, (first, last)) in
        (ends.squares.iter_mut()).zip(first.sums.squares.into_iter().zip(last.sums.squares))
    {
        *end = end.add(first).add(last);
    }
}

/// r^ along a stretch.
struct Response<L> {
    /// r^ one and two samples before.
    before: [L; 2],
    sums: Sums<L>,
}

impl<L: Lanes> Response<L> {
    #[inline(always)]
    fn new() -> Self {
        Self {
            before: [L::splat(0.0); 2],
            sums: Sums::new(),
        }
    }

    /// The answer to `signals`, of which the first [`REACH`] are past.
    #[inline(always)]
    fn to(&mut self, signals: &[[f64; SIGNALS]], own: &[L; NUMBERS]) {
        for (n, window) in signals.windows(REACH + 1).enumerate() {
            let mut g = L::splat(0.0);
            for (i, now) in window.iter().rev().enumerate() {
                for (s, x) in now.iter().enumerate() {
                    g = own[2 + s * FORCE + i].mul_add(L::splat(*x), g);
                }
            }
            self.step(n, g, own);
        }
    }

    /// Nothing drives it for so many samples.
    #[inline(always)]
    fn decay(&mut self, samples: usize, own: &[L; NUMBERS]) {
        for n in 0..samples {
            self.step(n, L::splat(0.0), own);
        }
    }

    #[inline(always)]
    fn step(&mut self, n: usize, g: L, own: &[L; NUMBERS]) {
        let [r1, r2] = self.before;
        let r = own[0].mul_add(r1, own[1].mul_add(r2, g));
        self.before = [r, r1];
        self.sums.count(n % 2, r);
    }
}
