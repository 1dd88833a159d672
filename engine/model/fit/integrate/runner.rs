//! One axle's equation of motion.

use std::ops::{Add, Div, Mul, Range};

use super::axle::{AxleLanes, MAX_EFFECTS};
use super::laws::Laws;
use super::road::{LaneRoad, recorded};
use crate::dataset::{Dataset, Track};
use crate::law::{Crank, Motion};
use veloid_core::numerics::lanes::Lanes;
use veloid_core::numerics::spline::cubic;
use veloid_core::plant::Coefficients;

/// An axle in eight variants.
pub(super) struct Runner<'a> {
    pub track: &'a Track,
    pub lanes: &'a AxleLanes,
    road: Option<LaneRoad>,
    /// Deflection (m) at which the plain axle rests under its constant force, with the sign turned.
    rest: Lanes,
    /// The constant force over the mass, as it is counted from there (m/s^2).
    constant: Lanes,
}

/// Inputs on the interval after one sample, as cubics and lines in s from 0 to 1.
#[derive(Clone, Copy)]
pub(super) struct Piece {
    road: Road,
    force: [f64; 4],
    speed: [f64; 2],
    speed_rate: [f64; 2],
    crank: [f64; 2],
    distance: [f64; 2],
    /// Sine and cosine of twice the crank angle at the sample.
    double: [f64; 2],
}

/// The road's height (m) and rate (m/s), the same in all lanes or each lane's own.
#[derive(Clone, Copy)]
#[expect(
    clippy::large_enum_variant,
    reason = "on the stack, one an axle; a box would be allocated on every interval"
)]
enum Road {
    Alike([f64; 4], [f64; 3]),
    Each([Lanes; 4], [Lanes; 3]),
}

/// Rate (1/s) of a cubic on an interval of `step` (s).
#[inline(always)]
fn rate<T: Copy + Mul<f64, Output = T> + Div<f64, Output = T>>(u: [T; 4], step: f64) -> [T; 3] {
    [u[1] / step, u[2] * 2.0 / step, u[3] * 3.0 / step]
}

/// Value of a polynomial.
#[inline(always)]
fn value<T: Copy + Add<Output = T> + Mul<f64, Output = T>, const N: usize>(
    u: &[T; N],
    s: f64,
) -> T {
    (u[..N - 1].iter().rev()).fold(u[N - 1], |sum, c| *c + sum * s)
}

/// What drives an axle at one time.
#[derive(Clone, Copy)]
pub(super) struct Drive {
    /// Time since the first sample, and step of the integrator (s).
    t: f64,
    h: f64,
    /// Height of the road (m) and its rate (m/s).
    road: Lanes,
    slope: Lanes,
    /// Force (N, up).
    push: f64,
    speed: f64,
    speed_rate: f64,
    crank: Crank,
    distance: f64,
}

impl Piece {
    /// Of no interval yet.
    pub const NONE: Self = Self {
        road: Road::Alike([0.0; 4], [0.0; 3]),
        force: [0.0; 4],
        speed: [0.0; 2],
        speed_rate: [0.0; 2],
        crank: [0.0; 2],
        distance: [0.0; 2],
        double: [0.0; 2],
    };

    /// At the time `t`, the part `s` of the interval, which is integrated in steps of `h` (s).
    #[inline(always)]
    pub fn at(&self, [t, s, h]: [f64; 3]) -> Drive {
        let line = |x: [f64; 2]| x[0] + x[1] * s;
        let (road, slope) = match &self.road {
            Road::Alike(u, v) => (Lanes::all(value(u, s)), Lanes::all(value(v, s))),
            Road::Each(u, v) => (value(u, s), value(v, s)),
        };
        Drive {
            t,
            h,
            road,
            slope,
            push: value(&self.force, s),
            speed: line(self.speed),
            speed_rate: line(self.speed_rate),
            crank: Crank {
                angle: line(self.crank),
                before: self.double,
                turned: 2.0 * self.crank[1] * s,
            },
            distance: line(self.distance),
        }
    }
}

impl Drive {
    /// At no time yet.
    pub const NONE: Self = Self {
        t: 0.0,
        h: 0.0,
        road: Lanes::ZERO,
        slope: Lanes::ZERO,
        push: 0.0,
        speed: 0.0,
        speed_rate: 0.0,
        crank: Crank {
            angle: 0.0,
            before: [0.0; 2],
            turned: 0.0,
        },
        distance: 0.0,
    };
}

impl<'a> Runner<'a> {
    pub fn new(
        dataset: &Dataset,
        track: &'a Track,
        lanes: &'a AxleLanes,
        span: Range<usize>,
    ) -> Self {
        let rest = rest(track, lanes);
        Self {
            track,
            lanes,
            road: LaneRoad::of(dataset, track, lanes, span),
            rest,
            constant: lanes.base.constant - lanes.base.kappa * rest,
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
            None => {
                let u = recorded(self.track, i);
                Road::Alike(u, rate(u, h))
            }
            Some(road) => {
                let u = road.piece(i, h);
                Road::Each(u, rate(u, h))
            }
        };
        Piece {
            road,
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

    /// Rates of the states under what drives the axle.
    #[inline(always)]
    pub fn rates<const S: usize, L: Laws>(
        &self,
        laws: &L,
        drive: &Drive,
        x: &[Lanes; S],
        out: &mut [Lanes; S],
    ) {
        let Coefficients {
            kappa,
            beta,
            per_mass,
            ..
        } = self.lanes.base;
        let (low_z, low_v) = match laws.wheel() {
            None => (x[0], x[1]),
            Some(at) => (x[at], x[at + 1]),
        };
        let m = Motion {
            d: drive.road - low_z + self.rest,
            w: drive.slope - low_v,
            z: x[0],
            v: x[1],
            kappa,
            beta,
            per_mass,
            t: drive.t,
            speed: drive.speed,
            speed_rate: drive.speed_rate,
            crank: drive.crank,
            distance: drive.distance,
            step: drive.h,
            felt_after: self.track.input.felt_after(drive.h),
            scale: &self.track.scale,
        };
        let plain = [
            kappa * m.d + beta * m.w,
            per_mass * drive.push + self.constant,
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
pub fn rest(track: &Track, lanes: &AxleLanes) -> Lanes {
    let carries = lanes.effects.iter().any(|e| e.kind.spec().carries);
    if carries || !track.rest_point || track.input.prescribed {
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
