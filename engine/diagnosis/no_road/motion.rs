//! The two ways through an axle: from its acceleration to the road, and from the road to its acceleration.

use super::law::{AT_REST, Law, Place, ahead, between, zero};
use veloid_core::numerics::lanes::{Lanes, widest};

/// Deflection (m) and its rate (m/s) along a segment.
#[derive(Default)]
pub struct Deflected {
    pub d: Vec<Lanes>,
    pub w: Vec<Lanes>,
}

/// The deflection under an axle whose motion is known: its force is the mass times the acceleration, which gives the rate of the
/// deflection, B w + k d + effects = m a.
pub fn invert(law: &Law) -> Deflected {
    widest(
        #[inline(always)]
        || inverted(law),
    )
}

#[inline(always)]
fn inverted(law: &Law) -> Deflected {
    let segment = law.segment;
    let steps = segment.steps();
    let mut out = Deflected {
        d: Vec::with_capacity(steps),
        w: Vec::with_capacity(steps),
    };
    let h = segment.step;
    let base = &law.lanes.base;
    let slope = base.beta + base.kappa * (0.5 * h);
    let (count, evaluations) = (law.lanes.effects.len(), law.evaluations());
    let (mut d, mut w, mut before) = (Lanes::ZERO, Lanes::ZERO, Lanes::ZERO);
    let (mut own, mut rates, mut rates_before) = (AT_REST, AT_REST, AT_REST);
    for i in 0..steps {
        let (a, z, v) = (
            Lanes::all(segment.lead.a[i]),
            Lanes::all(segment.lead.z[i]),
            Lanes::all(segment.lead.v[i]),
        );
        let predicted = ahead(&own, &rates, &rates_before, count, h);
        let known = Place {
            d: d + w * (0.5 * h),
            w: Lanes::ZERO,
            z,
            v,
        };
        let mut scratch = AT_REST;
        let next = zero(
            #[inline(always)]
            |w| law.acceleration(i, known.at(w, h), &predicted, &mut scratch) - a,
            w * 2.0 - before,
            slope,
            evaluations,
        );
        let mut rates_next = AT_REST;
        if count > 0 {
            law.acceleration(i, known.at(next, h), &predicted, &mut rates_next);
            own = between(&own, &rates, &rates_next, count, h);
            (rates_before, rates) = (rates, rates_next);
        }
        d = known.at(next, h).d;
        (before, w) = (w, next);
        out.d.push(d);
        out.w.push(w);
    }
    out
}

/// What the road does to an axle.
#[derive(Default)]
pub struct Driven {
    pub a: Vec<Lanes>,
    pub d: Vec<Lanes>,
    pub w: Vec<Lanes>,
}

/// The acceleration of an axle on a road of this rate (m/s), by trapezoids.
pub fn drive(law: &Law, road: &[Lanes]) -> Driven {
    widest(
        #[inline(always)]
        || driven(law, road),
    )
}

#[inline(always)]
fn driven(law: &Law, road: &[Lanes]) -> Driven {
    let segment = law.segment;
    let steps = segment.steps();
    let room = || Vec::with_capacity(steps);
    let mut out = Driven {
        a: room(),
        d: room(),
        w: room(),
    };
    let h = segment.step;
    let base = &law.lanes.base;
    let slope = base.beta + base.kappa * (0.5 * h) + Lanes::all(2.0 / h);
    let (count, evaluations) = (law.lanes.effects.len(), law.evaluations());
    let zero_lanes = Lanes::ZERO;
    let (mut d, mut w, mut before) = (zero_lanes, zero_lanes, zero_lanes);
    let (mut z, mut v, mut a) = (zero_lanes, zero_lanes, zero_lanes);
    let (mut own, mut rates, mut rates_before) = (AT_REST, AT_REST, AT_REST);
    for (i, road) in road.iter().enumerate() {
        let predicted = ahead(&own, &rates, &rates_before, count, h);
        let known = Place {
            d: d + w * (0.5 * h),
            w: Lanes::ZERO,
            z: z + v * (0.5 * h),
            v,
        };
        let mut scratch = AT_REST;
        let next = zero(
            #[inline(always)]
            |w| {
                let felt = (*road - w - v) * (2.0 / h) - a;
                law.acceleration(i, known.on(*road, w, h), &predicted, &mut scratch) - felt
            },
            w * 2.0 - before,
            slope,
            evaluations,
        );
        let place = known.on(*road, next, h);
        let mut rates_next = AT_REST;
        a = law.acceleration(i, place, &predicted, &mut rates_next);
        own = between(&own, &rates, &rates_next, count, h);
        (rates_before, rates) = (rates, rates_next);
        (z, v, d) = (place.z, place.v, place.d);
        (before, w) = (w, next);
        out.a.push(a);
        out.d.push(d);
        out.w.push(w);
    }
    out
}
