//! One axle's equation of motion.

use std::ops::Range;

use super::axle::{AxleLanes, MAX_EFFECTS};
use super::laws::Laws;
use super::road::{LaneRoad, recorded};
use crate::diagnosis::dataset::{Dataset, Track};
use crate::diagnosis::law::{Crank, Motion};
use crate::numerics::lanes::Lanes;
use crate::numerics::spline::cubic;
use crate::plant::Coefficients;

/// An axle in eight variants.
pub(super) struct Runner<'a> {
    pub track: &'a Track,
    pub lanes: &'a AxleLanes,
    road: Option<LaneRoad>,
    /// Deflection (m) at which the plain axle rests under its constant force, with the sign turned.
    rest: Lanes,
}

/// Inputs on the interval after one sample, as cubics and lines in s from 0 to 1.
pub(super) struct Piece {
    road: [Lanes; 4],
    /// Of the road's rate (m/s).
    slope: [Lanes; 3],
    force: [f64; 4],
    speed: [f64; 2],
    speed_rate: [f64; 2],
    crank: [f64; 2],
    distance: [f64; 2],
    /// Sine and cosine of twice the crank angle at the sample.
    double: [f64; 2],
}

impl<'a> Runner<'a> {
    pub fn new(
        dataset: &Dataset,
        track: &'a Track,
        lanes: &'a AxleLanes,
        span: Range<usize>,
    ) -> Self {
        let carries = lanes.effects.iter().any(|e| e.kind.spec().carries);
        Self {
            track,
            lanes,
            road: LaneRoad::of(dataset, track, lanes, span),
            rest: match carries {
                false => rest(track, lanes),
                true => Lanes::ZERO,
            },
        }
    }

    /// States of the axle and its effects.
    pub fn states(&self) -> usize {
        let effects = self.lanes.effects.iter().take(MAX_EFFECTS);
        2 + effects.map(|e| e.kind.spec().states).sum::<usize>()
    }

    pub fn start<const S: usize>(&self, x: &mut [Lanes; S]) {
        if self.track.plant.moves() {
            x[0] = self.lanes.base.height;
            x[1] = self.lanes.base.velocity;
        }
        let mut at = 2;
        for e in self.lanes.effects.iter().take(MAX_EFFECTS) {
            let spec = e.kind.spec();
            for q in 0..spec.states {
                // Those of a second mass are given from those of the first.
                let from = if spec.second_mass { x[q] } else { Lanes::ZERO };
                x[at + q] = from + e.initial[q];
            }
            at += spec.states;
        }
    }

    #[inline(always)]
    pub fn piece(&self, dataset: &Dataset, i: usize) -> Piece {
        let input = &self.track.input;
        let h = input.step;
        let line = |x: &[f64]| [x[i], x[i + 1] - x[i]];
        let road = match &self.road {
            None => recorded(self.track, i),
            Some(road) => road.piece(i, h),
        };
        Piece {
            road,
            slope: [road[1] / h, road[2] * 2.0 / h, road[3] * 3.0 / h],
            force: match &input.force {
                None => [0.0; 4],
                Some((f, m)) => cubic(f[i], f[i + 1], m[i], m[i + 1], h),
            },
            speed: line(&dataset.speed),
            speed_rate: line(&dataset.speed_rate),
            crank: line(&dataset.crank),
            distance: line(&dataset.distance),
            double: dataset.double_crank[i],
        }
    }

    /// Rates of the states at the time `t` (s), the part `s` of the interval that `piece` describes.
    #[inline(always)]
    pub fn rates<const S: usize, L: Laws>(
        &self,
        laws: &L,
        piece: &Piece,
        [t, s, h]: [f64; 3],
        x: &[Lanes; S],
        out: &mut [Lanes; S],
    ) {
        let Coefficients {
            kappa,
            beta,
            per_mass,
            constant,
            ..
        } = self.lanes.base;
        let u = &piece.road;
        let road = u[0] + (u[1] + (u[2] + u[3] * s) * s) * s;
        let v = &piece.slope;
        let slope = v[0] + (v[1] + v[2] * s) * s;
        let (low_z, low_v) = match laws.wheel() {
            None => (x[0], x[1]),
            Some(at) => (x[at], x[at + 1]),
        };
        let line = |x: [f64; 2]| x[0] + x[1] * s;
        let m = Motion {
            d: road - low_z + self.rest,
            w: slope - low_v,
            z: x[0],
            v: x[1],
            kappa,
            beta,
            per_mass,
            t,
            speed: line(piece.speed),
            speed_rate: line(piece.speed_rate),
            crank: Crank {
                angle: line(piece.crank),
                before: piece.double,
                turned: 2.0 * piece.crank[1] * s,
            },
            distance: line(piece.distance),
            step: h,
            felt_after: self.track.input.felt_after(h),
            scale: &self.track.scale,
        };
        let f = &piece.force;
        let push = f[0] + (f[1] + (f[2] + f[3] * s) * s) * s;
        let plain = [
            kappa * m.d + beta * m.w,
            per_mass * push + constant - kappa * self.rest,
        ];
        let [tyre, body] = laws.forces(&m, x, plain);
        let force = match laws.wheel() {
            None => tyre + body,
            Some(_) => body,
        };
        out[0] = x[1];
        out[1] = laws.moved(&m, x, force, tyre, out);
    }
}

/// How far (m) deflections lie from those that laws count from: laws are even or odd about where the axle rests, and on benches
/// and free decays nobody knows what a sensor reads there. No further than the axle moves, so that an axle without a spring, which
/// rests nowhere, or one that is as good as none, is left as it is.
fn rest(track: &Track, lanes: &AxleLanes) -> Lanes {
    if !track.rest_point || track.input.prescribed {
        return Lanes::ZERO;
    }
    let Coefficients {
        kappa, constant, ..
    } = lanes.base;
    let reach = track.scale.d_peak;
    let least = track.scale.as_good_as_none()[0] / track.scale.mass;
    Lanes(std::array::from_fn(|lane| {
        let rest = constant.0[lane] / kappa.0[lane];
        if kappa.0[lane] > least && rest.abs() < reach {
            rest
        } else {
            0.0
        }
    }))
}
