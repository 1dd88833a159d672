//! The whitened normal equations of the simulated displacement: columns of residual and derivatives, and their products.

use std::ops::Range;

use nalgebra::DVector;

use super::damped::Normal;
use super::unit::{Point, Slot, Unit};
use crate::dataset::Dataset;
use veloid_core::numerics::autoregressive::NoiseModel;
use veloid_core::numerics::lanes::{LANES, Lanes, widest};

/// Slots whose derivatives one simulation gives.
const CHUNK: usize = LANES - 1;

/// Where the equations are taken, and by which slots.
pub struct Equations<'a> {
    pub dataset: &'a Dataset,
    /// Samples to fit on.
    pub samples: usize,
    pub unit: &'a Unit,
    pub slots: &'a [Slot],
    pub point: &'a Point,
    /// One for each axle of the unit.
    pub noise_models: &'a [NoiseModel],
    pub substeps: usize,
}

/// What one axle's simulations give.
#[derive(Clone, Default)]
struct Columns {
    /// Measured minus simulated at the point; zero where not valid.
    residual: Vec<f64>,
    /// Whitened residual, in lane 0, and derivatives.
    chunks: Vec<Vec<Lanes>>,
}

impl Equations<'_> {
    /// Adds the normal equations of one axle (or of all) over the `touching` slots.
    pub fn add(&self, wanted: Option<usize>, touching: &[usize], normal: &mut Normal) {
        let axles: Vec<usize> = match wanted {
            Some(a) => vec![a],
            None => (0..self.unit.tracks.len()).collect(),
        };
        let columns = self.columns(wanted, &axles, touching);
        for (columns, a) in columns.iter().zip(&axles) {
            let scale = 1.0 / self.noise_models[*a].variance;
            multiply(&columns.chunks, scale, touching, normal);
        }
        normal
            .residuals
            .extend(columns.into_iter().map(|c| c.residual));
    }

    /// For every axle the whitened columns, a chunk at a time.
    fn columns(&self, wanted: Option<usize>, axles: &[usize], touching: &[usize]) -> Vec<Columns> {
        let mut columns = vec![Columns::default(); axles.len()];
        for chunk in touching.chunks(CHUNK) {
            let (points, per_step) = self.stepped(chunk);
            let z = self.unit.simulate(
                self.dataset,
                &points,
                wanted,
                0..self.samples,
                self.substeps,
            );
            for ((z, a), columns) in z.iter().zip(axles).zip(&mut columns) {
                let raw = self.differences(z, *a, per_step);
                if columns.chunks.is_empty() {
                    columns.residual = raw.iter().map(|x| x.0[0]).collect();
                }
                let white = whitened(&raw, &self.noise_models[*a].a);
                columns.chunks.push(white);
            }
        }
        columns
    }

    /// Derivatives of the log likelihood by every slot, summed over each of so many contiguous blocks of the fitted part.
    pub fn scores(&self, blocks: usize) -> Vec<DVector<f64>> {
        let axles: Vec<usize> = (0..self.unit.tracks.len()).collect();
        let every: Vec<usize> = (0..self.slots.len()).collect();
        let columns = self.columns(None, &axles, &every);
        let score = |block: Range<usize>| {
            let mut sums = DVector::zeros(every.len());
            for (columns, a) in columns.iter().zip(&axles) {
                let scale = 1.0 / self.noise_models[*a].variance;
                for (c, chunk) in columns.chunks.iter().enumerate() {
                    let products = products(&chunk[block.clone()], &chunk[block.clone()])[0];
                    for (slot, product) in every.iter().skip(c * CHUNK).zip(&products.0[1..]) {
                        sums[*slot] += scale * product;
                    }
                }
            }
            sums
        };
        let edge = |b: usize| b * self.samples / blocks;
        (0..blocks).map(|b| score(edge(b)..edge(b + 1))).collect()
    }

    /// The point, and in every further lane the point with one slot moved; one over the steps.
    fn stepped(&self, chunk: &[usize]) -> ([Point; LANES], [f64; LANES]) {
        let mut points: [Point; LANES] = std::array::from_fn(|_| self.point.clone());
        let mut per_step = [0.0; LANES];
        for (lane, s) in chunk.iter().enumerate() {
            let slot = self.slots[*s];
            let (size, limits) = self.unit.range(self.dataset, slot);
            let value = self.point.get(slot);
            let step = 1e-4 * size.abs().max(value.abs());
            let moved = if value + step > limits[1] {
                value - step
            } else {
                value + step
            };
            points[lane + 1].set(slot, moved);
            per_step[lane + 1] = 1.0 / (moved - value);
        }
        (points, per_step)
    }

    /// The residual of axle `a` in lane 0, derivatives of the simulated `z` in the others; zero where not valid.
    fn differences(&self, z: &[Lanes], a: usize, per_step: [f64; LANES]) -> Vec<Lanes> {
        let track = &self.dataset.tracks[self.unit.tracks[a]];
        (0..self.samples)
            .map(|i| {
                if !track.valid[i] {
                    return Lanes::ZERO;
                }
                let base = z[i].0[0];
                let mut out = (z[i] - base) * Lanes(per_step);
                out.0[0] = track.measured[i] - base;
                out
            })
            .collect()
    }
}

/// Adds the products of one axle's columns over its noise variance, 1 / `scale`.
fn multiply(columns: &[Vec<Lanes>], scale: f64, touching: &[usize], normal: &mut Normal) {
    for (c, first) in columns.iter().enumerate() {
        for (d, second) in columns.iter().enumerate().skip(c) {
            let products = products(first, second);
            if c == 0 && d == 0 {
                normal.cost += scale * products[0].0[0];
            }
            for p in 1..LANES {
                let Some(i) = touching.get(c * CHUNK + p - 1) else {
                    break;
                };
                if d == c {
                    normal.gradient[*i] += scale * products[0].0[p];
                }
                for q in 1..LANES {
                    let Some(j) = touching.get(d * CHUNK + q - 1) else {
                        break;
                    };
                    normal.matrix[(*i, *j)] += scale * products[p].0[q];
                    if d != c {
                        normal.matrix[(*j, *i)] += scale * products[p].0[q];
                    }
                }
            }
        }
    }
}

/// Sum over samples of the outer product of two sets of columns.
pub fn products(first: &[Lanes], second: &[Lanes]) -> [Lanes; LANES] {
    widest(
        #[inline(always)]
        || {
            let mut sums = [Lanes::ZERO; LANES];
            for (x, y) in first.iter().zip(second) {
                for (sum, x) in sums.iter_mut().zip(x.0) {
                    *sum += *y * x;
                }
            }
            sums
        },
    )
}

/// x_n + sum a_j x_{n-j} for eight columns at once.
pub fn whitened(x: &[Lanes], a: &[f64]) -> Vec<Lanes> {
    widest(
        #[inline(always)]
        || {
            (0..x.len())
                .map(|i| {
                    let mut sum = x[i];
                    for (a, x) in a.iter().zip(x[..i].iter().rev()) {
                        sum += *x * *a;
                    }
                    sum
                })
                .collect()
        },
    )
}
