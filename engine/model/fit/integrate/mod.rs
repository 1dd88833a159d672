//! The extended model in motion: fourth-order Runge-Kutta on eight parameter sets at once, with the
//! road and forces as cubic splines through the samples.

mod axle;
mod laws;
mod road;
mod runner;
mod sensed;
#[cfg(test)]
mod tests;

pub use axle::{AxleLanes, BESIDE_OWN, EffectLanes, Motions};
pub use runner::rest;
pub use sensed::sensed;

use std::ops::Range;

use axle::STATES;
use laws::{Laws, Listed, Nothing, One};
use runner::{Drive, Piece, Runner};

use crate::dataset::{Dataset, Track};
use crate::effects::{ForEffect, Kind};
use crate::law::{Acts, Effect};
use veloid_core::numerics::lanes::{Lanes, vectors};

/// Simulates a span of samples of the axles, from states at its first one; with two axles in `coupled` = (c_own, c_other) form
/// they push each other. `substeps` per sample; velocities and accelerations are kept when `full`.
pub fn run(
    dataset: &Dataset,
    axles: &[(&Track, &AxleLanes)],
    coupling: Option<&Lanes>,
    span: Range<usize>,
    substeps: usize,
    full: bool,
) -> Vec<Motions> {
    let cost: usize = axles.iter().map(|(track, lanes)| cost(track, lanes)).sum();
    let span = span.start..span.end.min(dataset.samples);
    dataset.work.add((span.len() * substeps * cost) as u64);
    let runners: Vec<Runner> = axles
        .iter()
        .map(|(t, l)| Runner::new(dataset, t, l, span.clone()))
        .collect();
    let room = |wanted: bool| Vec::with_capacity(if wanted { span.len() } else { 0 });
    let mut out: Vec<Motions> = axles
        .iter()
        .map(|_| Motions {
            z: room(true),
            v: room(full),
            a: room(full),
        })
        .collect();
    let job = Job {
        dataset,
        runners: &runners,
        coupling,
        span: span.clone(),
        substeps,
        full,
        out: &mut out,
    };
    match acting(axles) {
        Acting::Nothing => job.on_each::<2, _>(|_| Nothing),
        Acting::One(kind) => kind.visit(job),
        Acting::Several => job.listed(),
    }
    out
}

/// What the integrator is chosen by.
enum Acting {
    Nothing,
    One(Kind),
    Several,
}

fn acting(axles: &[(&Track, &AxleLanes)]) -> Acting {
    let mut effects = axles.iter().map(|(_, lanes)| lanes.effects.as_slice());
    match effects.next() {
        Some([]) if effects.all(<[_]>::is_empty) => Acting::Nothing,
        Some([one]) if effects.all(|e| matches!(e, [e] if e.kind == one.kind)) => {
            Acting::One(one.kind)
        }
        _ => Acting::Several,
    }
}

/// Operations of a law of the user's own that take as long as a step without one.
const OPERATIONS: usize = 10;

/// What a step on one axle costs, counted in steps of an axle with effects of the library.
fn cost(track: &Track, lanes: &AxleLanes) -> usize {
    let has_own = lanes.effects.iter().any(|e| matches!(e.kind, Kind::Own(_)));
    let own = track.scale.own.as_ref().filter(|_| has_own);
    1 + own.map_or(0, |law| law.operations().div_ceil(OPERATIONS))
}

/// What one integration works on.
struct Job<'a> {
    dataset: &'a Dataset,
    runners: &'a [Runner<'a>],
    coupling: Option<&'a Lanes>,
    span: Range<usize>,
    substeps: usize,
    full: bool,
    out: &'a mut [Motions],
}

impl ForEffect for Job<'_> {
    fn of<E: Effect>(self) {
        match E::SPEC.states {
            0 => self.one::<E, 2>(),
            1 => self.one::<E, 3>(),
            _ => self.one::<E, 4>(),
        }
    }

    fn of_own_law(self) {
        self.listed();
    }
}

impl<'a> Job<'a> {
    fn one<E: Effect, const S: usize>(self) {
        let one = |runner: &Runner<'a>| One::<E>::of(&runner.lanes.effects[0]);
        match (E::SPEC.acts, self.runners) {
            (Acts::Both, _) => self.on_each::<S, _>(one),
            (Acts::OneAxle | Acts::Front | Acts::Rear, [_]) => self.on_one::<S, _>(one),
            // Each axle has one of its own.
            (Acts::OneAxle | Acts::Front | Acts::Rear, _) => self.listed(),
        }
    }

    /// With as few states as the effects need.
    fn listed(self) {
        let listed = |runner: &Runner<'a>| Listed::of(&runner.lanes.effects);
        match self.runners.iter().map(Runner::states).max() {
            Some(..=2) => self.on_each::<2, _>(listed),
            Some(..=4) => self.on_each::<4, _>(listed),
            Some(..=6) => self.on_each::<6, _>(listed),
            _ => self.on_each::<STATES, _>(listed),
        }
    }

    fn on_each<const S: usize, L: Laws>(self, laws: impl Fn(&Runner<'a>) -> L) {
        match self.runners {
            [front, rear] => {
                let laws = [laws(front), laws(rear)];
                self.widest::<2, S, L>(&laws);
            }
            _ => self.on_one::<S, L>(laws),
        }
    }

    fn on_one<const S: usize, L: Laws>(self, laws: impl Fn(&Runner<'a>) -> L) {
        if let [axle] = self.runners {
            let laws = [laws(axle)];
            self.widest::<1, S, L>(&laws);
        }
    }

    /// On a processor of x86 without AVX2 one integrator serves everything, more slowly and to the same numbers.
    fn widest<const A: usize, const S: usize, L: Laws>(mut self, laws: &[L; A]) {
        let integrated = vectors(
            #[inline(always)]
            || self.integrate::<A, S, L>(laws),
        );
        if integrated.is_ok() {
            return;
        }
        let runners = self.runners;
        let listed: [Listed; A] = std::array::from_fn(|a| Listed::of(&runners[a].lanes.effects));
        self.integrate::<A, STATES, Listed>(&listed);
    }

    #[inline(always)]
    fn integrate<const A: usize, const S: usize, L: Laws>(&mut self, laws: &[L; A]) {
        let dataset = self.dataset;
        let mut x: [[Lanes; S]; A] = [[Lanes::ZERO; S]; A];
        for (x, r) in x.iter_mut().zip(self.runners) {
            r.start(x);
        }
        let Range { start, end } = self.span;
        for i in start..end {
            let last = i + 1 == end;
            let from = if last {
                i.saturating_sub(1).max(start)
            } else {
                i
            };
            // Arrays that closures fill are compiled for less than the widest vectors.
            let mut pieces = [Piece::NONE; A];
            for (piece, runner) in pieces.iter_mut().zip(self.runners) {
                *piece = runner.piece(dataset, from);
            }
            for a in 0..A {
                self.out[a].z.push(x[a][0]);
                if self.full {
                    self.out[a].v.push(x[a][1]);
                }
            }
            if self.full {
                let drives = self.drives(&pieces, i, if last { 1.0 } else { 0.0 });
                let rates = self.rates(laws, &drives, &x);
                for a in 0..A {
                    self.out[a].a.push(rates[a][1]);
                }
            }
            if last {
                break;
            }
            let mut first = self.drives(&pieces, i, 0.0);
            for sub in 0..self.substeps {
                let part = |s: f64| (sub as f64 + s) / self.substeps as f64;
                let middle = self.drives(&pieces, i, part(0.5));
                let end = self.drives(&pieces, i, part(1.0));
                x = self.stepped(laws, [&first, &middle, &end], x);
                first = end;
            }
        }
    }

    /// What drives the axles at the part `s` of the interval after sample `i`.
    #[inline(always)]
    fn drives<const A: usize>(&self, pieces: &[Piece; A], i: usize, s: f64) -> [Drive; A] {
        let step = self.dataset.step;
        let [t, h] = [(i as f64 + s) * step, step / self.substeps as f64];
        let mut drives = [Drive::NONE; A];
        for (drive, piece) in drives.iter_mut().zip(pieces) {
            *drive = piece.at([t, s, h]);
        }
        drives
    }

    /// The states a step later, by what drives the axles at its beginning, in its middle and at its end.
    #[inline(always)]
    fn stepped<const A: usize, const S: usize, L: Laws>(
        &self,
        laws: &[L; A],
        [first, middle, end]: [&[Drive; A]; 3],
        x: [[Lanes; S]; A],
    ) -> [[Lanes; S]; A] {
        let h = self.dataset.step / self.substeps as f64;
        let (mut sum, mut at) = (x, x);
        for stage in 0..4 {
            let (drives, weight, next) = match stage {
                0 => (first, h / 6.0, 0.5 * h),
                1 => (middle, h / 3.0, 0.5 * h),
                2 => (middle, h / 3.0, h),
                _ => (end, h / 6.0, 0.0),
            };
            let mut rates = self.rates(laws, drives, &at);
            for a in 0..A {
                if self.runners[a].track.input.prescribed {
                    (rates[a][0], rates[a][1]) = (Lanes::ZERO, Lanes::ZERO);
                }
                for q in 0..S {
                    sum[a][q] += rates[a][q] * weight;
                    at[a][q] = x[a][q] + rates[a][q] * next;
                }
            }
        }
        sum
    }

    #[inline(always)]
    fn rates<const A: usize, const S: usize, L: Laws>(
        &self,
        laws: &[L; A],
        drives: &[Drive; A],
        x: &[[Lanes; S]; A],
    ) -> [[Lanes; S]; A] {
        let mut out = [[Lanes::ZERO; S]; A];
        for a in 0..A {
            self.runners[a].rates(&laws[a], &drives[a], &x[a], &mut out[a]);
        }
        if A == 2
            && let (Some(q), Some([l_f, l_r, m_f, m_r])) = (self.coupling, self.dataset.geometry)
        {
            // z_F'' = F_F (1/m + l_F^2/I) + F_R (1/m - l_F l_R/I) with 1/I = (1 + q)/(m l_F l_R).
            let total = m_f + m_r;
            let (f, r) = (out[0][1] * m_f, out[A - 1][1] * m_r);
            let own = |ratio: f64| (*q + 1.0) * (ratio / total) + 1.0 / total;
            let cross = *q * (-1.0 / total);
            out[0][1] = f * own(l_f / l_r) + r * cross;
            out[A - 1][1] = r * own(l_r / l_f) + f * cross;
        }
        out
    }
}
