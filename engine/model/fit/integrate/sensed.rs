//! What the displacement sensor reads of simulated motion.

use super::axle::{AxleLanes, EffectLanes, Motions};
use crate::dataset::Dataset;
use crate::law::{Pickup, Values};
use veloid_core::numerics::lanes::{LANES, Lanes, widest};

/// What the displacement sensor reads of simulated motion (m), at every sample from the first on; where the motion is prescribed the force's (N),
/// that on a mass of 1 kg.
pub fn sensed(
    dataset: &Dataset,
    first: usize,
    prescribed: bool,
    lanes: &AxleLanes,
    motions: Motions,
) -> Vec<Lanes> {
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
    let simulated = Simulated {
        motions: &motions,
        sharp,
        first,
        step: dataset.step,
    };
    widest(
        #[inline(always)]
        || {
            for lane in 0..LANES {
                read_lane(&simulated, &effects, lane, &mut out);
            }
        },
    );
    out
}

/// What a sensor reads from.
struct Simulated<'a> {
    motions: &'a Motions,
    /// What a sensor without fault reads of it.
    sharp: &'a [Lanes],
    /// The sample that it starts at.
    first: usize,
    step: f64,
}

#[inline(always)]
fn read_lane(simulated: &Simulated, effects: &[&EffectLanes], lane: usize, out: &mut [Lanes]) {
    let Simulated {
        motions,
        sharp,
        first,
        step,
    } = *simulated;
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
            e.kind.sensor(v, (first + i) as f64 * step, &mut pickup);
        }
        let z = if pickup.delay == 0.0 {
            sharp[i].0[lane]
        } else {
            earlier(motions, lane, i as f64 - pickup.delay / step, step)
        };
        let prompt = pickup.gain * z + pickup.offset;
        let late = before.map_or(prompt, |before| followed(before, prompt, pickup.lag, step));
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
