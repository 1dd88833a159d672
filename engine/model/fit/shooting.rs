//! Multiple shooting: a model fitted to windows of one axle's record, each with a starting state of its own (H. G. Bock 1981;
//! Voss, Timmer & Kurths 2004, doi:10.1142/S0218127404010345). The states are projected out: every window adds to the normal
//! equations of the common numbers what is left of it when its own are at their best (a Schur complement).

use std::ops::Range;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::damped::{Normal, stepped};
use super::normal_equations::products;
use super::unit::{Point, Slot, Unit};
use crate::dataset::{Dataset, Track};
use veloid_core::numerics::lanes::{LANES, Lanes};
use veloid_core::plant::Coefficient;

/// Slots whose derivatives one simulation gives.
const CHUNK: usize = LANES - 1;
/// Curvature that the starting states are given at least, as a part of their mean one over all windows: a mass that sticks
/// through a window shows nothing of where it started.
const FLOOR: f64 = 1e-4;
/// Damping of a window's states, as a part of the mean one, so that silent windows are damped as others are.
const SHARED: f64 = 0.1;
/// Part of the dominant period at a window's start from which its starting state is read.
const FIRST: f64 = 0.08;
/// Steps of Levenberg-Marquardt without progress after which a fit ends, and what counts as none.
const IDLE: usize = 2;
const LITTLE: f64 = 1e-4;
/// Steps in which a held-out window's state is found.
const SETTLES: usize = 8;

/// Windows of one axle.
pub struct Shooting<'a> {
    pub dataset: &'a Dataset,
    /// The index of the axle's track.
    pub track: usize,
    pub spans: &'a [Range<usize>],
    /// The dominant period (samples).
    pub period: f64,
    /// What errors are measured by: the record's variance (m^2 or N^2).
    pub variance: f64,
}

/// A model fitted to windows.
#[derive(Clone, Debug)]
pub struct Shot {
    /// What all windows have in common; its starting states mean nothing.
    pub point: Point,
    /// Mean squared error beside the record's variance.
    pub left: f64,
}

/// What the fit knows: the common numbers, and each window's own.
#[derive(Clone)]
struct Known {
    point: Point,
    own: Vec<Vec<f64>>,
}

/// Which numbers are common, which are each window's own, and how the model is stepped.
struct Setting<'u> {
    unit: &'u Unit,
    common: Vec<Slot>,
    own: Vec<Slot>,
    substeps: usize,
}

impl<'a> Shooting<'a> {
    fn data(&self) -> &'a Track {
        &self.dataset.tracks[self.track]
    }

    /// Whether a window's mean is left to it: a sensor's zero, or what a spring carries.
    fn floats(&self) -> bool {
        let track = self.data();
        track.plant.has_spring() && track.plant.moves()
    }

    /// Fits from `start` to the given windows.
    pub fn fit(&self, unit: &Unit, start: &Point, windows: &[usize], steps: usize) -> Option<Shot> {
        let spans: Vec<Range<usize>> = windows.iter().map(|w| self.spans[*w].clone()).collect();
        let start = unit.within(self.dataset, start.clone());
        let setting = self.setting(unit, &start, true);
        let known = Known {
            point: start,
            own: spans
                .iter()
                .map(|span| self.state(&setting, span))
                .collect(),
        };
        let (known, cost) = self.minimised(&setting, &spans, known, steps)?;
        let samples: usize = spans.iter().map(Range::len).sum();
        Some(Shot {
            point: known.point,
            left: cost / samples as f64,
        })
    }

    /// What a model leaves of windows that no fit has seen (mean squared error beside the record's variance; infinite where it runs
    /// away): the first half of each gives its starting state, and the second is judged.
    pub fn held_out(&self, unit: &Unit, point: &Point, windows: &[usize]) -> Vec<f64> {
        let setting = self.setting(unit, point, false);
        let judged = |window: &usize| self.judged(&setting, point, &self.spans[*window]);
        windows.par_iter().map(judged).collect()
    }

    fn judged(&self, setting: &Setting, point: &Point, span: &Range<usize>) -> f64 {
        let half = span.start..span.start + span.len() / 2;
        let known = Known {
            point: point.clone(),
            own: vec![self.state(setting, &half)],
        };
        let spans = [half.clone()];
        let Some((known, _)) = self.minimised(setting, &spans, known.clone(), SETTLES) else {
            return f64::INFINITY;
        };
        let points = std::array::from_fn(|_| known.of_window(setting, 0));
        let track = self.data();
        let readings =
            setting
                .unit
                .simulate(self.dataset, &points, None, span.clone(), setting.substeps);
        let errors: Vec<Option<f64>> = (span.clone().zip(&readings[0]))
            .map(|(i, z)| track.valid[i].then(|| track.measured[i] - z.0[0]))
            .collect();
        let (seen, judged) = errors.split_at(half.len());
        // Nothing holds a mass without a spring in its place: its motion is judged.
        let zero = match (self.floats(), track.input.prescribed) {
            (true, _) => mean(seen),
            (false, false) => mean(judged),
            (false, true) => 0.0,
        };
        let squares: Vec<f64> = (judged.iter().flatten())
            .map(|e| (e - zero).powi(2))
            .collect();
        let left = squares.iter().sum::<f64>() / squares.len().max(1) as f64 / self.variance;
        if left.is_finite() {
            left
        } else {
            f64::INFINITY
        }
    }

    fn setting<'u>(&self, unit: &'u Unit, point: &Point, with_common: bool) -> Setting<'u> {
        let is_own = |slot: &Slot| slot.is_start();
        let all = unit.slots(self.dataset);
        let (mut own, mut common): (Vec<Slot>, Vec<Slot>) = all.into_iter().partition(is_own);
        for (i, term) in unit.terms.iter().enumerate() {
            let states = (0..term.kind.spec().states).map(|q| Slot::Initial(i, q));
            let new = states
                .filter(|slot| !own.contains(slot))
                .collect::<Vec<_>>();
            own.extend(new);
        }
        if !with_common {
            common.clear();
        }
        Setting {
            substeps: unit.fine_substeps(self.dataset, point),
            unit,
            common,
            own,
        }
    }

    /// Where a window starts as its first samples show: height and velocity of a parabola through them, and effects at rest.
    fn state(&self, setting: &Setting, span: &Range<usize>) -> Vec<f64> {
        let [height, velocity] =
            parabola(self.data(), span, FIRST * self.period, self.dataset.step);
        let of = |slot: &Slot| match slot {
            Slot::Base(_, Coefficient::Height) => height,
            Slot::Base(_, Coefficient::Velocity) => velocity,
            _ => 0.0,
        };
        setting.own.iter().map(of).collect()
    }

    fn minimised(
        &self,
        setting: &Setting,
        spans: &[Range<usize>],
        mut known: Known,
        steps: usize,
    ) -> Option<(Known, f64)> {
        let mut damping = 1e-3;
        let (mut cost, mut parts) = self.normals(setting, spans, &known)?;
        let mut idle = 0;
        for _ in 0..steps {
            let dampings: [f64; LANES] =
                std::array::from_fn(|i| damping * 10_f64.powi(i as i32 - 2));
            let tried = dampings.map(|d| self.step(setting, &parts, &known, d));
            let costs = self.costs(setting, spans, &tried);
            let best = (0..LANES).min_by(|a, b| costs[*a].total_cmp(&costs[*b]))?;
            if costs[best] < cost {
                idle = if cost - costs[best] < LITTLE * cost {
                    idle + 1
                } else {
                    0
                };
                known = tried[best].clone();
                damping = (0.3 * dampings[best]).clamp(1e-9, 1e6);
                if idle >= IDLE {
                    cost = costs[best];
                    break;
                }
                (cost, parts) = self.normals(setting, spans, &known)?;
            } else {
                damping *= 1e4;
                if damping > 1e8 {
                    break;
                }
            }
        }
        Some((known, cost))
    }

    /// The cost and each window's normal equations, over the common slots and then its own.
    fn normals(
        &self,
        setting: &Setting,
        spans: &[Range<usize>],
        known: &Known,
    ) -> Option<(f64, Vec<Normal>)> {
        let windows: Vec<usize> = (0..spans.len()).collect();
        let normal = |w: &usize| self.normal(setting, &spans[*w], &known.of_window(setting, *w));
        let parts: Vec<Normal> = windows.par_iter().map(normal).collect();
        let cost: f64 = parts.iter().map(|p| p.cost).sum();
        let finite = |p: &Normal| p.matrix.iter().all(|x| x.is_finite());
        (cost.is_finite() && parts.iter().all(finite)).then_some((cost, parts))
    }

    fn normal(&self, setting: &Setting, span: &Range<usize>, point: &Point) -> Normal {
        let slots: Vec<Slot> = setting.common.iter().chain(&setting.own).copied().collect();
        let variance = self.variance;
        let mut normal = Normal::zero(slots.len());
        let columns: Vec<Vec<Lanes>> = (slots.chunks(CHUNK))
            .map(|chunk| self.columns(setting, span, point, chunk))
            .collect();
        for (c, first) in columns.iter().enumerate() {
            for (d, second) in columns.iter().enumerate().skip(c) {
                let products = products(first, second);
                if c == 0 && d == 0 {
                    normal.cost = products[0].0[0] / variance;
                }
                for p in 1..LANES {
                    let i = c * CHUNK + p - 1;
                    if i >= slots.len() {
                        break;
                    }
                    if d == c {
                        normal.gradient[i] = products[0].0[p] / variance;
                    }
                    for q in 1..LANES {
                        let j = d * CHUNK + q - 1;
                        if j >= slots.len() {
                            break;
                        }
                        normal.matrix[(i, j)] = products[p].0[q] / variance;
                        normal.matrix[(j, i)] = normal.matrix[(i, j)];
                    }
                }
            }
        }
        normal
    }

    /// The residual and the derivatives of what is predicted by some slots, without their means where these float.
    fn columns(
        &self,
        setting: &Setting,
        span: &Range<usize>,
        point: &Point,
        chunk: &[Slot],
    ) -> Vec<Lanes> {
        let mut points: [Point; LANES] = std::array::from_fn(|_| point.clone());
        let mut per_step = [0.0; LANES];
        for (lane, slot) in chunk.iter().enumerate() {
            let (size, limits) = setting.unit.range(self.dataset, *slot);
            let value = point.get(*slot);
            let step = 1e-4 * size.abs().max(value.abs());
            let moved = if value + step > limits[1] {
                value - step
            } else {
                value + step
            };
            points[lane + 1].set(*slot, moved);
            per_step[lane + 1] = 1.0 / (moved - value);
        }
        let readings =
            (setting.unit).simulate(self.dataset, &points, None, span.clone(), setting.substeps);
        let column = |z: &Lanes, measured: f64| {
            let mut out = (*z - z.0[0]) * Lanes(per_step);
            out.0[0] = measured - z.0[0];
            out
        };
        let track = self.data();
        let mut columns: Vec<Lanes> = (span.clone().zip(&readings[0]))
            .map(|(i, z)| match track.valid[i] {
                true => column(z, track.measured[i]),
                false => Lanes::ZERO,
            })
            .collect();
        self.centre(span, &mut columns);
        columns
    }

    /// Takes the means of valid samples off, where they float.
    fn centre(&self, span: &Range<usize>, columns: &mut [Lanes]) {
        if !self.floats() {
            return;
        }
        let valid = &self.data().valid[span.clone()];
        let count = valid.iter().filter(|v| **v).count().max(1);
        let mut mean = Lanes::ZERO;
        columns.iter().for_each(|x| mean += *x);
        let mean = mean / count as f64;
        for (x, _) in columns.iter_mut().zip(valid).filter(|(_, valid)| **valid) {
            *x = *x - mean;
        }
    }

    /// Costs of eight sets of numbers.
    fn costs(
        &self,
        setting: &Setting,
        spans: &[Range<usize>],
        tried: &[Known; LANES],
    ) -> [f64; LANES] {
        let track = self.data();
        let windows: Vec<usize> = (0..spans.len()).collect();
        let of_window = |w: &usize| {
            let span = &spans[*w];
            let points = std::array::from_fn(|lane| tried[lane].of_window(setting, *w));
            let readings = (setting.unit).simulate(
                self.dataset,
                &points,
                None,
                span.clone(),
                setting.substeps,
            );
            let mut errors: Vec<Lanes> = (span.clone().zip(&readings[0]))
                .map(|(i, z)| match track.valid[i] {
                    true => Lanes::all(track.measured[i]) - *z,
                    false => Lanes::ZERO,
                })
                .collect();
            self.centre(span, &mut errors);
            let mut sum = Lanes::ZERO;
            errors.iter().for_each(|e| sum += *e * *e);
            sum
        };
        let parts: Vec<Lanes> = windows.par_iter().map(of_window).collect();
        let mut sum = Lanes::ZERO;
        parts.iter().for_each(|part| sum += *part);
        let variance = self.variance;
        sum.0.map(|x| {
            if x.is_finite() {
                x / variance
            } else {
                f64::INFINITY
            }
        })
    }

    /// Where a damped step leads to: the common numbers with the windows' own projected out, and then these.
    fn step(&self, setting: &Setting, parts: &[Normal], known: &Known, damping: f64) -> Known {
        let (n, m) = (setting.common.len(), setting.own.len());
        let inverses = own_inverses(parts, n, m, damping);
        let mut common = Normal::zero(n);
        for (part, inverse) in parts.iter().zip(&inverses) {
            let cross = part.matrix.view((0, n), (n, m));
            let projected = cross * inverse;
            common.gradient += part.gradient.rows(0, n) - &projected * part.gradient.rows(n, m);
            common.matrix += part.matrix.view((0, 0), (n, n)) - &projected * cross.transpose();
        }
        let values: Vec<f64> = setting.common.iter().map(|s| known.point.get(*s)).collect();
        let ranges: Vec<_> = (setting.common.iter())
            .map(|s| setting.unit.range(self.dataset, *s))
            .collect();
        let next = stepped(&values, &ranges, &common, damping);
        let moved = DVector::from_fn(n, |i, _| next[i] - values[i]);
        let own = (parts.iter().zip(&inverses).zip(&known.own))
            .map(|((part, inverse), own)| {
                let cross = part.matrix.view((0, n), (n, m));
                let step = inverse * (part.gradient.rows(n, m) - cross.transpose() * &moved);
                own.iter().zip(step.iter()).map(|(x, s)| x + s).collect()
            })
            .collect();
        Known {
            point: known.point.with(&setting.common, &next),
            own,
        }
    }
}

impl Known {
    fn of_window(&self, setting: &Setting, window: usize) -> Point {
        self.point.with(&setting.own, &self.own[window])
    }
}

/// Damped inverses of what each window says of its own state.
fn own_inverses(parts: &[Normal], n: usize, m: usize, damping: f64) -> Vec<DMatrix<f64>> {
    let mean = DVector::from_fn(m, |i, _| {
        let sum: f64 = parts.iter().map(|p| p.matrix[(n + i, n + i)]).sum();
        (sum / parts.len().max(1) as f64).max(f64::MIN_POSITIVE)
    });
    let scale = mean.map(|x| x.sqrt().recip());
    let inverse = |part: &Normal| {
        let scaled = DMatrix::from_fn(m, m, |i, j| {
            let own = scale[i] * part.matrix[(n + i, n + j)] * scale[j];
            match i == j {
                true => own + damping * (own + SHARED) + FLOOR,
                false => own,
            }
        });
        let inverse = scaled.cholesky().map(|c| c.inverse());
        let inverse = inverse.unwrap_or_else(|| DMatrix::zeros(m, m));
        DMatrix::from_fn(m, m, |i, j| scale[i] * inverse[(i, j)] * scale[j])
    };
    parts.iter().map(inverse).collect()
}

fn mean(errors: &[Option<f64>]) -> f64 {
    let (sum, count) = (errors.iter().flatten()).fold((0.0, 0), |(s, n), e| (s + e, n + 1));
    sum / f64::from(count.max(1))
}

/// Height and velocity at the start of the parabola through so many samples at a window's start.
fn parabola(track: &Track, span: &Range<usize>, samples: f64, step: f64) -> [f64; 2] {
    let count = (samples as usize)
        .clamp(3, (span.len() / 2).max(3))
        .min(span.len());
    let rows: Vec<(f64, f64)> = (0..count)
        .filter(|i| track.valid[span.start + i])
        .map(|i| (i as f64 / count as f64, track.measured[span.start + i]))
        .collect();
    let matrix = DMatrix::from_fn(rows.len(), 3, |r, c| rows[r].0.powi(c as i32));
    let target = DVector::from_fn(rows.len(), |r, _| rows[r].1);
    let normal = matrix.tr_mul(&matrix);
    match normal.cholesky() {
        Some(factor) if rows.len() >= 3 => {
            let solution = factor.solve(&matrix.tr_mul(&target));
            [solution[0], solution[1] / (count as f64 * step)]
        }
        _ => [track.measured[span.start], 0.0],
    }
}
