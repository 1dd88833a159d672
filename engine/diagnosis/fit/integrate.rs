//! The extended model in motion: fourth-order Runge-Kutta on eight parameter sets at once, with the
//! road and forces as cubic splines through the samples.

use crate::diagnosis::dataset::{Scene, Track};
use crate::diagnosis::effects::Kind;
use crate::diagnosis::law::{
    LaneValues, MAX_STATES, Motion, Pickup, Spec, Spot, States, Tap, Values,
};
use crate::numerics::lanes::{LANES, Lanes, widest};
use crate::numerics::spline::cubic;

/// Effects on one axle at most.
pub const MAX_EFFECTS: usize = 6;
const STATES: usize = 2 + MAX_EFFECTS * MAX_STATES;

/// Eight parameter sets of one axle.
#[derive(Clone, Debug)]
pub struct AxleLanes {
    /// k/m, B/m, 1/m, constant force over m, z(0), z'(0).
    pub base: [Lanes; 6],
    pub effects: Vec<EffectLanes>,
}

#[derive(Clone, Debug)]
pub struct EffectLanes {
    pub kind: Kind,
    pub values: LaneValues,
    /// Where the effect's own states start, relative to the mass for a mass's height and velocity.
    pub initial: States,
}

impl EffectLanes {
    fn of_lane(&self, lane: usize) -> Values {
        self.values.map(|v| v.0[lane])
    }
}

/// Simulated motion of one axle at every sample.
#[derive(Clone, Debug, Default)]
pub struct Motions {
    pub z: Vec<Lanes>,
    /// Velocity and acceleration, where asked for.
    pub v: Vec<Lanes>,
    pub a: Vec<Lanes>,
}

/// The road under each lane, where effects change it.
struct LaneRoad {
    value: Vec<Lanes>,
    slope: Vec<Lanes>,
}

struct Runner<'a> {
    track: &'a Track,
    lanes: &'a AxleLanes,
    road: Option<LaneRoad>,
    /// Where each effect's states lie.
    offsets: [usize; MAX_EFFECTS],
    states: usize,
    /// The states of a wheel between tyre and mass.
    wheel: Option<usize>,
    pedalled: bool,
    own_law: bool,
    /// Deflection (m) at which the plain axle rests under its constant force, with the sign turned.
    rest: Lanes,
}

/// Inputs on the interval after one sample, as cubics in s from 0 to 1.
struct Piece {
    road: [Lanes; 4],
    force: [f64; 4],
    speed: [f64; 2],
    speed_rate: [f64; 2],
    /// Sine and cosine of twice the crank angle at the sample, and how far that turns up to the next.
    crank: [f64; 2],
    turn: f64,
    /// Crank angle (rad) and distance ridden (m), where a law may ask for them.
    crank_angle: [f64; 2],
    distance: [f64; 2],
}

/// Simulates `samples` samples of the axles; with two axles in `coupled` = (c_own, c_other) form
/// they push each other. `substeps` per sample; velocities and accelerations are kept when `full`.
pub fn run(
    scene: &Scene,
    axles: &[(&Track, &AxleLanes)],
    coupling: Option<&Lanes>,
    samples: usize,
    substeps: usize,
    full: bool,
) -> Vec<Motions> {
    let cost: usize = axles.iter().map(|(track, lanes)| cost(track, lanes)).sum();
    scene.work.add((samples * substeps * cost) as u64);
    let runners: Vec<Runner> = axles
        .iter()
        .map(|(t, l)| Runner::new(scene, t, l, samples))
        .collect();
    let mut out: Vec<Motions> = axles
        .iter()
        .map(|_| {
            let room = |wanted: bool| Vec::with_capacity(if wanted { samples } else { 0 });
            Motions {
                z: room(true),
                v: room(full),
                a: room(full),
            }
        })
        .collect();
    let job = Job {
        scene,
        runners: &runners,
        coupling,
        samples,
        substeps,
        full,
    };
    widest(
        #[inline(always)]
        || sized(&job, &mut out),
    );
    out
}

/// How far (m) deflections lie from those that laws count from: laws are even or odd about where the axle rests, and on benches
/// and free decays nobody knows what a sensor reads there. No further than the axle moves, so that an axle without a spring, which
/// rests nowhere, or one that is as good as none, is left as it is.
fn rest(track: &Track, lanes: &AxleLanes) -> Lanes {
    if !track.rest_point || track.input.prescribed {
        return Lanes::ZERO;
    }
    let [kappa, _, _, constant, _, _] = lanes.base;
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
    scene: &'a Scene,
    runners: &'a [Runner<'a>],
    coupling: Option<&'a Lanes>,
    samples: usize,
    substeps: usize,
    full: bool,
}

/// Picks the integrator with as few states as the effects need.
#[inline(always)]
fn sized(job: &Job, out: &mut [Motions]) {
    let states = job.runners.iter().map(|r| r.states).max().unwrap_or(2);
    match (job.runners.len(), states) {
        (1, ..=2) => integrate::<1, 2>(job, out),
        (1, ..=4) => integrate::<1, 4>(job, out),
        (1, _) => integrate::<1, STATES>(job, out),
        (_, ..=2) => integrate::<2, 2>(job, out),
        (_, ..=4) => integrate::<2, 4>(job, out),
        _ => integrate::<2, STATES>(job, out),
    }
}

#[inline(always)]
fn integrate<const A: usize, const S: usize>(job: &Job, out: &mut [Motions]) {
    let (scene, runners) = (job.scene, job.runners);
    let h = scene.step / job.substeps as f64;
    let mut x: [[Lanes; S]; A] = [[Lanes::ZERO; S]; A];
    for (x, r) in x.iter_mut().zip(runners) {
        r.start(x);
    }
    let end = job.samples.min(scene.samples);
    for i in 0..end {
        let last = i + 1 == end;
        let from = if last { i.saturating_sub(1) } else { i };
        let pieces: [Piece; A] = std::array::from_fn(|a| runners[a].piece(scene, from));
        for a in 0..A {
            out[a].z.push(x[a][0]);
            if job.full {
                out[a].v.push(x[a][1]);
            }
        }
        if job.full {
            let rates = rates(job, &pieces, i, if last { 1.0 } else { 0.0 }, h, &x);
            for a in 0..A {
                out[a].a.push(rates[a][1]);
            }
        }
        if last {
            break;
        }
        for sub in 0..job.substeps {
            let s0 = sub as f64 / job.substeps as f64;
            let ds = 1.0 / job.substeps as f64;
            let mut sum = x;
            let mut at = x;
            for stage in 0..4 {
                let (s, weight, next) = match stage {
                    0 => (s0, h / 6.0, 0.5 * h),
                    1 => (s0 + 0.5 * ds, h / 3.0, 0.5 * h),
                    2 => (s0 + 0.5 * ds, h / 3.0, h),
                    _ => (s0 + ds, h / 6.0, 0.0),
                };
                let mut rates = rates(job, &pieces, i, s, h, &at);
                for a in 0..A {
                    if runners[a].track.input.prescribed {
                        (rates[a][0], rates[a][1]) = (Lanes::ZERO, Lanes::ZERO);
                    }
                    for q in 0..S {
                        sum[a][q] += rates[a][q] * weight;
                        at[a][q] = x[a][q] + rates[a][q] * next;
                    }
                }
            }
            x = sum;
        }
    }
}

#[inline(always)]
fn rates<const A: usize, const S: usize>(
    job: &Job,
    pieces: &[Piece; A],
    i: usize,
    s: f64,
    h: f64,
    x: &[[Lanes; S]; A],
) -> [[Lanes; S]; A] {
    let mut out = [[Lanes::ZERO; S]; A];
    for a in 0..A {
        job.runners[a].rates(
            &pieces[a],
            (i as f64 + s) * job.scene.step,
            s,
            h,
            &x[a],
            &mut out[a],
        );
    }
    if A == 2
        && let (Some(q), Some([l_f, l_r, m_f, m_r])) = (job.coupling, job.scene.geometry)
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

impl<'a> Runner<'a> {
    fn new(scene: &Scene, track: &'a Track, lanes: &'a AxleLanes, samples: usize) -> Self {
        let mut offsets = [0; MAX_EFFECTS];
        let mut states = 2;
        let mut wheel = None;
        for (offset, e) in offsets.iter_mut().zip(&lanes.effects) {
            *offset = states;
            if e.kind == Kind::UnsprungMass {
                wheel = Some(states);
            }
            states += e.kind.spec().states;
        }
        let changed = lanes.effects.iter().any(|e| e.kind.spec().on_road);
        Self {
            track,
            lanes,
            road: changed.then(|| lane_road(scene, track, lanes, samples)),
            offsets,
            states,
            wheel,
            pedalled: lanes.effects.iter().any(|e| e.kind == Kind::PedallingForce),
            rest: match wheel {
                None => rest(track, lanes),
                Some(_) => Lanes::ZERO,
            },
            own_law: lanes.effects.iter().any(|e| matches!(e.kind, Kind::Own(_))),
        }
    }

    fn start<const S: usize>(&self, x: &mut [Lanes; S]) {
        if !self.track.input.prescribed {
            x[0] = self.lanes.base[4];
            x[1] = self.lanes.base[5];
        }
        for (e, offset) in self.lanes.effects.iter().zip(self.offsets) {
            let Spec {
                states,
                second_mass,
                ..
            } = *e.kind.spec();
            for q in 0..states {
                // Those of a second mass are given from those of the first.
                let from = if second_mass { x[q] } else { Lanes::ZERO };
                x[offset + q] = from + e.initial[q];
            }
        }
    }

    #[inline(always)]
    fn piece(&self, scene: &Scene, i: usize) -> Piece {
        let input = &self.track.input;
        let h = input.step;
        let road = match &self.road {
            None => cubic(
                input.road[i],
                input.road[i + 1],
                input.road_slope[i],
                input.road_slope[i + 1],
                h,
            )
            .map(Lanes::all),
            Some(r) => {
                let (d, a, b) = (
                    r.value[i + 1] - r.value[i],
                    r.slope[i] * h,
                    r.slope[i + 1] * h,
                );
                [r.value[i], a, d * 3.0 - a * 2.0 - b, a + b - d * 2.0]
            }
        };
        let force = match &input.force {
            None => [0.0; 4],
            Some((f, m)) => cubic(f[i], f[i + 1], m[i], m[i + 1], h),
        };
        let line = |x: &[f64]| match self.own_law {
            true => [x[i], x[i + 1] - x[i]],
            false => [0.0; 2],
        };
        Piece {
            road,
            force,
            crank_angle: line(&scene.crank),
            distance: line(&scene.distance),
            speed: [scene.speed[i], scene.speed[i + 1] - scene.speed[i]],
            speed_rate: [
                scene.speed_rate[i],
                scene.speed_rate[i + 1] - scene.speed_rate[i],
            ],
            crank: if self.pedalled {
                (2.0 * scene.crank[i]).sin_cos().into()
            } else {
                [0.0; 2]
            },
            turn: 2.0 * (scene.crank[i + 1] - scene.crank[i]),
        }
    }

    #[inline(always)]
    fn rates<const S: usize>(
        &self,
        piece: &Piece,
        t: f64,
        s: f64,
        h: f64,
        x: &[Lanes; S],
        out: &mut [Lanes; S],
    ) {
        let [kappa, beta, per_mass, constant, _, _] = self.lanes.base;
        let u = &piece.road;
        let road = u[0] + (u[1] + (u[2] + u[3] * s) * s) * s;
        let slope = (u[1] + (u[2] * 2.0 + u[3] * (3.0 * s)) * s) / self.track.input.step;
        let (low_z, low_v) = match self.wheel {
            None => (x[0], x[1]),
            Some(at) => (x[at], x[at + 1]),
        };
        let crank = if self.pedalled {
            turned(piece.crank, piece.turn * s)
        } else {
            piece.crank
        };
        let m = Motion {
            d: road - low_z + self.rest,
            w: slope - low_v,
            z: x[0],
            v: x[1],
            kappa,
            beta,
            per_mass,
            t,
            speed: piece.speed[0] + piece.speed[1] * s,
            speed_rate: piece.speed_rate[0] + piece.speed_rate[1] * s,
            crank,
            crank_angle: piece.crank_angle[0] + piece.crank_angle[1] * s,
            distance: piece.distance[0] + piece.distance[1] * s,
            step: h,
            felt_after: self.track.input.felt_after(h),
            scale: &self.track.scale,
        };
        let effects = self.lanes.effects.iter().zip(self.offsets);
        let mut tyre = kappa * m.d + beta * m.w;
        for (e, at) in effects.clone() {
            tyre = e.kind.tyre(&e.values, &m, &own(x, at), tyre);
        }
        let f = &piece.force;
        let push = f[0] + (f[1] + (f[2] + f[3] * s) * s) * s;
        let mut body = per_mass * push + constant - kappa * self.rest;
        for (e, at) in effects.clone() {
            body = e.kind.body(&e.values, &m, &own(x, at), body);
        }
        let mut acceleration = if self.wheel.is_some() {
            body
        } else {
            tyre + body
        };
        for (e, at) in effects {
            let own = own(x, at);
            acceleration = e.kind.inertia(&e.values, &m, &own, acceleration);
            let states = e.kind.spec().states;
            if states > 0 {
                let mut rates = e.kind.rates(&e.values, &m, &own);
                if e.kind == Kind::UnsprungMass {
                    rates[1] += tyre / e.values[0];
                }
                out[at] = rates[0];
                if states > 1 {
                    out[at + 1] = rates[1];
                }
            }
        }
        out[0] = x[1];
        out[1] = acceleration;
    }
}

/// Sine and cosine of an angle from those of one that is smaller by `turn` (rad). Small turns, and these are small
/// unless a crank is logged at some 10 Hz, by their series, right to 1e-8.
#[inline(always)]
fn turned([sin, cos]: [f64; 2], turn: f64) -> [f64; 2] {
    let (s, c) = if turn.abs() < 0.5 {
        let q = turn * turn;
        (
            turn * (1.0 - q / 6.0 * (1.0 - q / 20.0 * (1.0 - q / 42.0))),
            1.0 - q / 2.0 * (1.0 - q / 12.0 * (1.0 - q / 30.0 * (1.0 - q / 56.0))),
        )
    } else {
        turn.sin_cos()
    };
    [sin * c + cos * s, cos * c - sin * s]
}

/// An effect's own states; zeros where it has none.
#[inline(always)]
fn own<const S: usize>(x: &[Lanes; S], at: usize) -> States {
    [0, 1].map(|q| if at + q < S { x[at + q] } else { Lanes::ZERO })
}

fn lane_road(scene: &Scene, track: &Track, lanes: &AxleLanes, samples: usize) -> LaneRoad {
    let effects: Vec<&EffectLanes> = lanes
        .effects
        .iter()
        .filter(|e| e.kind.spec().on_road)
        .collect();
    let mut road = LaneRoad {
        value: vec![Lanes::ZERO; samples],
        slope: vec![Lanes::ZERO; samples],
    };
    for lane in 0..LANES {
        let values: Vec<Values> = effects.iter().map(|e| e.of_lane(lane)).collect();
        if let Some(twin) = (0..lane).find(|l| {
            effects
                .iter()
                .zip(&values)
                .all(|(e, v)| e.of_lane(*l) == *v)
        }) {
            for i in 0..samples {
                road.value[i].0[lane] = road.value[i].0[twin];
                road.slope[i].0[lane] = road.slope[i].0[twin];
            }
            continue;
        }
        for i in 0..samples {
            let spot = Spot {
                speed: scene.speed[i],
                distance: scene.distance[i],
            };
            let mut tap = Tap::default();
            for (e, v) in effects.iter().zip(&values) {
                e.kind.road(v, &spot, &track.scale, &mut tap);
            }
            (road.value[i].0[lane], road.slope[i].0[lane]) = track.tapped(i, &tap);
        }
    }
    road
}

/// What the displacement sensor reads of simulated motion (m), at every sample; where the motion is prescribed the force's (N),
/// that on a mass of 1 kg.
pub fn sensed(scene: &Scene, prescribed: bool, lanes: &AxleLanes, motions: Motions) -> Vec<Lanes> {
    let effects: Vec<&EffectLanes> = lanes
        .effects
        .iter()
        .filter(|e| e.kind.spec().on_sensor)
        .collect();
    if effects.is_empty() {
        return if prescribed { motions.a } else { motions.z };
    }
    let sharp = if prescribed { &motions.a } else { &motions.z };
    let mut out = sharp.clone();
    widest(
        #[inline(always)]
        || {
            for lane in 0..LANES {
                read_lane(scene, &effects, &motions, sharp, lane, &mut out);
            }
        },
    );
    out
}

#[inline(always)]
fn read_lane(
    scene: &Scene,
    effects: &[&EffectLanes],
    motions: &Motions,
    sharp: &[Lanes],
    lane: usize,
    out: &mut [Lanes],
) {
    let values: Vec<Values> = effects.iter().map(|e| e.of_lane(lane)).collect();
    // What a sensor without a lag would have read before, and what this one read.
    let mut before: Option<(f64, f64)> = None;
    for (i, read) in out.iter_mut().enumerate() {
        let mut pickup = Pickup {
            delay: 0.0,
            gain: 1.0,
            offset: 0.0,
            lag: 0.0,
        };
        for (e, v) in effects.iter().zip(&values) {
            e.kind.sensor(v, i as f64 * scene.step, &mut pickup);
        }
        let z = if pickup.delay == 0.0 {
            sharp[i].0[lane]
        } else {
            earlier(
                motions,
                lane,
                i as f64 - pickup.delay / scene.step,
                scene.step,
            )
        };
        let prompt = pickup.gain * z + pickup.offset;
        let late = before.map_or(prompt, |before| {
            followed(before, prompt, pickup.lag, scene.step)
        });
        read.0[lane] = late;
        before = Some((prompt, late));
    }
}

/// What follows a line from one reading to the next with a lag (s), exactly: tau y' = x - y.
#[inline(always)]
fn followed((from, late): (f64, f64), to: f64, lag: f64, step: f64) -> f64 {
    if lag <= 0.0 {
        return to;
    }
    let (kept, behind) = ((-step / lag).exp(), (to - from) * lag / step);
    to - behind + (late - from + behind) * kept
}

/// Quintic interpolation of z between samples from z, z' and z''; quadratic beyond the ends.
#[inline(always)]
fn earlier(m: &Motions, lane: usize, position: f64, h: f64) -> f64 {
    let last = m.z.len() - 1;
    if last == 0 {
        return m.z[0].0[lane];
    }
    let at = |j: usize| (m.z[j].0[lane], m.v[j].0[lane] * h, m.a[j].0[lane] * h * h);
    let beyond = if position < 0.0 {
        position
    } else {
        (position - last as f64).max(0.0)
    };
    if beyond != 0.0 {
        let (z, v, a) = at(if beyond < 0.0 { 0 } else { last });
        return z + beyond * (v + 0.5 * beyond * a);
    }
    let i = (position as usize).min(last - 1);
    let s = position - i as f64;
    let ((z0, v0, a0), (z1, v1, a1)) = (at(i), at(i + 1));
    let d = z1 - z0 - v0 - 0.5 * a0;
    let e = v1 - v0 - a0;
    let f = a1 - a0;
    let c3 = 10.0 * d - 4.0 * e + 0.5 * f;
    let c4 = -15.0 * d + 7.0 * e - f;
    let c5 = 6.0 * d - 3.0 * e + 0.5 * f;
    z0 + s * (v0 + s * (0.5 * a0 + s * (c3 + s * (c4 + s * c5))))
}

#[cfg(test)]
mod tests {
    use super::followed;

    /// A ramp x = t is followed by t - tau + tau e^(-t/tau), in steps of any length.
    #[test]
    fn a_lag_follows_a_ramp_as_its_equation_says() {
        let lag = 0.03;
        for step in [1e-3, 0.02, 0.2] {
            let mut before = (0.0, 0.0);
            for i in 1..=20 {
                let t = f64::from(i) * step;
                let late = followed(before, t, lag, step);
                let truth = t - lag + lag * (-t / lag).exp();
                assert!(
                    (late - truth).abs() < 1e-12,
                    "{step} s: {late} instead of {truth}"
                );
                before = (t, late);
            }
        }
        assert_eq!(followed((1.0, 0.5), 2.0, 0.0, 0.1), 2.0);
    }
}
