//! One axle's law for eight models at once, as an equation for the rate of its deflection.

use super::record::Segment;
use crate::policy;
use veloid_core::numerics::lanes::{LANES, Lanes};
use veloid_core::plant::Coefficients;
use veloid_model::fit::integrate::AxleLanes;
use veloid_model::law::{Crank, MAX_STATES, Motion, Scale, Spot, States, Tap};

/// Beside the slope that is expected, the least and the largest that a secant may have: dry friction is steep about zero.
const FLATTEST: f64 = 0.2;
const STEEPEST: f64 = 1e3;
/// Evaluations of a law that is a line, of one that is smooth, and of one that is steep.
const LINE: usize = 1;
const SMOOTH: usize = 2;
const STEEP: usize = 5;

/// States of the effects on one axle.
pub type Own = [States; policy::MOST_TERMS];
pub const AT_REST: Own = [[Lanes::ZERO; MAX_STATES]; policy::MOST_TERMS];

pub struct Law<'a> {
    pub lanes: &'a AxleLanes,
    pub scale: &'a Scale,
    pub segment: &'a Segment,
    /// Distance (m) that a wheel has turned ahead of the segment's.
    pub rolled: f64,
    /// Time (s) after which a force is felt in the rate; none where the motion is known.
    pub felt_after: f64,
}

/// Deflection and its rate, height and velocity of the mass.
#[derive(Clone, Copy)]
pub struct Place {
    pub d: Lanes,
    pub w: Lanes,
    pub z: Lanes,
    pub v: Lanes,
}

impl Place {
    /// With a rate of the deflection at the end of a step, of which the rest is known; the mass moves as it does.
    #[inline(always)]
    pub fn at(self, w: Lanes, step: f64) -> Self {
        Self {
            d: self.d + w * (0.5 * step),
            w,
            ..self
        }
    }

    /// The same where the mass follows the road's rate.
    #[inline(always)]
    pub fn on(self, road: Lanes, w: Lanes, step: f64) -> Self {
        let v = road - w;
        Self {
            z: self.z + v * (0.5 * step),
            v,
            ..self.at(w, step)
        }
    }
}

impl Law<'_> {
    /// Acceleration of the mass (m/s^2), and the rates of the effects' states.
    #[inline(always)]
    pub fn acceleration(&self, step: usize, at: Place, own: &Own, rates: &mut Own) -> Lanes {
        let Coefficients {
            kappa,
            beta,
            per_mass,
            ..
        } = self.lanes.base;
        let segment = self.segment;
        let m = Motion {
            d: at.d,
            w: at.w,
            z: at.z,
            v: at.v,
            kappa,
            beta,
            per_mass,
            t: segment.start_s + segment.time(step),
            speed: segment.speed[step],
            speed_rate: segment.speed_rate[step],
            crank: Crank {
                angle: segment.crank[step],
                before: segment.double_crank[step],
                turned: 0.0,
            },
            distance: segment.distance[step],
            step: 2.0 * segment.step,
            felt_after: self.felt_after,
            scale: self.scale,
        };
        let mut forces = [kappa * at.d + beta * at.w, Lanes::ZERO];
        for (effect, own) in self.lanes.effects.iter().zip(own) {
            forces = effect.kind.forces(&effect.values, &m, own, forces);
        }
        let mut force = forces[0] + forces[1];
        for ((effect, own), rates) in self.lanes.effects.iter().zip(own).zip(rates) {
            force = effect.kind.moved(&effect.values, &m, own, force, rates);
        }
        force
    }

    /// Evaluations that a step needs.
    pub fn evaluations(&self) -> usize {
        let effects = &self.lanes.effects;
        match effects.iter().any(|e| e.kind.spec().corners) {
            true => STEEP,
            false if effects.is_empty() => LINE,
            false => SMOOTH,
        }
    }

    /// What the wheel adds to the rate of the road (m/s).
    #[inline(always)]
    pub fn wheel(&self, step: usize) -> Lanes {
        let mut tap = Tap {
            shift: Lanes::ZERO,
            half_window: Lanes::ZERO,
            value: Lanes::ZERO,
            slope: Lanes::ZERO,
        };
        let spot = Spot {
            speed: self.segment.speed[step],
            distance: self.segment.distance[step] + self.rolled,
        };
        for e in &self.lanes.effects {
            e.kind.road(&e.values, &spot, self.scale, &mut tap);
        }
        tap.slope
    }

    pub fn turns(&self) -> bool {
        self.lanes.effects.iter().any(|e| e.kind.spec().on_road)
    }
}

/// States a step on, by their rates now and a step before.
#[inline(always)]
pub fn ahead(own: &Own, rates: &Own, before: &Own, count: usize, step: f64) -> Own {
    let mut next = *own;
    for e in 0..count {
        for q in 0..MAX_STATES {
            next[e][q] = own[e][q] + (rates[e][q] * 1.5 - before[e][q] * 0.5) * step;
        }
    }
    next
}

/// States a step on, by their rates at both ends.
#[inline(always)]
pub fn between(own: &Own, rates: &Own, next: &Own, count: usize, step: f64) -> Own {
    let mut end = *own;
    for e in 0..count {
        for q in 0..MAX_STATES {
            end[e][q] = own[e][q] + (rates[e][q] + next[e][q]) * (0.5 * step);
        }
    }
    end
}

/// Where a rising function is zero, by secants from `start`, near which it rises by about `slope`, between where it was below and above
/// zero.
#[inline(always)]
pub fn zero(
    mut f: impl FnMut(Lanes) -> Lanes,
    start: Lanes,
    slope: Lanes,
    evaluations: usize,
) -> Lanes {
    let (mut below, mut above) = ([f64::NEG_INFINITY; LANES], [f64::INFINITY; LANES]);
    let (mut x, mut rise) = (start, slope);
    let (mut x_before, mut y_before) = (start, Lanes::ZERO);
    for evaluation in 0..evaluations {
        let y = f(x);
        let mut next = x;
        for i in 0..LANES {
            let (at, value) = (x.0[i], y.0[i]);
            let known = slope.0[i];
            if evaluation > 0 {
                let found = (value - y_before.0[i]) / (at - x_before.0[i]);
                let usable = found.is_finite() && found > 0.0;
                rise.0[i] = if usable {
                    found.clamp(FLATTEST * known, STEEPEST * known)
                } else {
                    rise.0[i]
                };
            }
            if value < 0.0 {
                below[i] = at;
            } else {
                above[i] = at;
            }
            let stepped = at - value / rise.0[i];
            let inside = stepped >= below[i] && stepped <= above[i];
            next.0[i] = if inside {
                stepped
            } else {
                0.5 * (below[i] + above[i])
            };
        }
        (x_before, y_before, x) = (x, y, next);
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 20 w + 0.5 sign(w), as smooth as shaking lets friction seem (10 mm/s), is 0.3 within the jump, 1.7 beyond it.
    #[test]
    fn zeros_of_steep_functions_are_found() {
        for (wanted, width) in [
            (0.3, 1e-2),
            (1.7, 1e-2),
            (-0.49, 1e-2),
            (-4.0, 1e-2),
            (1.7, 1e-4),
        ] {
            let f =
                |w: Lanes| (w * 20.0) + w.soft_sign(Lanes::all(width)) * 0.5 - Lanes::all(wanted);
            let w = zero(f, Lanes::all(0.05), Lanes::all(20.0), STEEP);
            assert!(
                f(w).0[0].abs() < 0.02,
                "{wanted}: {} at {}",
                f(w).0[0],
                w.0[0]
            );
        }
    }

    #[test]
    fn of_a_line_one_evaluation_is_enough() {
        let f = |w: Lanes| w * 7.0 - Lanes::all(2.1);
        let w = zero(f, Lanes::ZERO, Lanes::all(7.0), LINE);
        assert!((w.0[3] - 0.3).abs() < 1e-12);
    }
}
