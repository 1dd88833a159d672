//! What the tests of all effects share: a law on one lane, in plain numbers, and what holds of the starts, limits and reports of
//! any of them.

use crate::fit::model::COARSE;
use crate::law::*;

/// The axle of [`Scale::TYPICAL`] (30 kg, 60 kN/m, 500 N s/m) at one instant.
#[derive(Clone)]
pub struct At {
    pub d: f64,
    pub w: f64,
    pub z: f64,
    pub v: f64,
    pub t: f64,
    pub speed: f64,
    pub speed_rate: f64,
    pub crank: f64,
    pub distance: f64,
    pub step: f64,
    pub felt_after: f64,
    pub states: [f64; MAX_STATES],
}

/// At rest while the bicycle rolls at 5 m/s.
pub const AT: At = At {
    d: 0.0,
    w: 0.0,
    z: 0.0,
    v: 0.0,
    t: 0.0,
    speed: 5.0,
    speed_rate: 0.0,
    crank: 0.0,
    distance: 0.0,
    step: 5e-3,
    felt_after: 0.0,
    states: [0.0; MAX_STATES],
};

/// Force (N) that acts on the mass beside the tyre's.
pub const PUSH: f64 = 40.0;
/// What other effects have made of the road and of the sensor before.
const TAP: [f64; 4] = [0.25, 0.125, 0.5, -2.0];
const PICKUP: Pickup = Pickup {
    delay: 0.25,
    gain: 2.0,
    offset: 0.5,
    lag: 0.125,
};

/// The lane that is asked for.
const LANE: usize = 5;

/// A number in the lane that is asked for, others beside it.
fn among(value: f64) -> Lanes {
    Lanes(std::array::from_fn(|lane| {
        value * (1.0 + 0.05 * (lane as f64 - LANE as f64))
    }))
}

/// What a law makes of these values and this motion, on one lane.
pub fn on_lane<const N: usize>(
    scale: &Scale,
    values: Values,
    at: &At,
    law: impl FnOnce(&LaneValues, &Motion, &States) -> [Lanes; N],
) -> [f64; N] {
    let turned = 0.1;
    let m = Motion {
        d: among(at.d),
        w: among(at.w),
        z: among(at.z),
        v: among(at.v),
        kappa: among(2000.0),
        beta: among(500.0 / 30.0),
        per_mass: among(1.0 / 30.0),
        t: at.t,
        speed: at.speed,
        speed_rate: at.speed_rate,
        crank: Crank {
            angle: at.crank,
            before: (2.0 * at.crank - turned).sin_cos().into(),
            turned,
        },
        distance: at.distance,
        step: at.step,
        felt_after: at.felt_after,
        scale,
    };
    law(&values.map(among), &m, &at.states.map(among)).map(|x| x.0[LANE])
}

/// The tyre's force (N), its spring's and damper's among it.
pub fn tyre<E: Effect>(values: Values, at: &At) -> f64 {
    let [force] = on_lane(&Scale::TYPICAL, values, at, |p, m, s| {
        [E::tyre(p, m, s, m.kappa * m.d + m.beta * m.w)]
    });
    30.0 * force
}

/// The other forces on the mass (N), [`PUSH`] among them.
pub fn body<E: Effect>(values: Values, at: &At) -> f64 {
    let [force] = on_lane(&Scale::TYPICAL, values, at, |p, m, s| {
        [E::body(p, m, s, among(PUSH / 30.0))]
    });
    30.0 * force
}

/// The acceleration (m/s^2) under a force (N).
pub fn acceleration<E: Effect>(values: Values, at: &At, force: f64) -> f64 {
    let [a] = on_lane(&Scale::TYPICAL, values, at, |p, m, s| {
        [E::inertia(p, m, s, among(force / 30.0))]
    });
    a
}

pub fn rates<E: Effect>(values: Values, at: &At) -> [f64; MAX_STATES] {
    on_lane(&Scale::TYPICAL, values, at, E::rates)
}

/// The states so many seconds later while the motion stays as it is.
pub fn later<E: Effect>(values: Values, at: &At, seconds: f64) -> [f64; MAX_STATES] {
    const STEPS: usize = 2000;
    let h = seconds / STEPS as f64;
    let mut now = at.clone();
    for _ in 0..STEPS {
        let from = now.states;
        let rate = |by: f64, slope: [f64; MAX_STATES]| {
            let states = [0, 1].map(|q| from[q] + by * slope[q]);
            rates::<E>(
                values,
                &At {
                    states,
                    ..at.clone()
                },
            )
        };
        let a = rate(0.0, [0.0; MAX_STATES]);
        let b = rate(0.5 * h, a);
        let c = rate(0.5 * h, b);
        let d = rate(h, c);
        now.states = [0, 1].map(|q| from[q] + h / 6.0 * (a[q] + 2.0 * b[q] + 2.0 * c[q] + d[q]));
    }
    now.states
}

/// Shift (s), half window (s), height (m) and slope (m/s) that the effect adds to where the road is read.
pub fn road<E: Effect>(values: Values, at: &At) -> [f64; 4] {
    let [shift, half_window, value, slope] = TAP.map(Lanes::all);
    let mut tap = Tap {
        shift,
        half_window,
        value,
        slope,
    };
    let spot = Spot {
        speed: at.speed,
        distance: at.distance,
    };
    E::road(&values.map(among), &spot, &Scale::TYPICAL, &mut tap);
    let found = [tap.shift, tap.half_window, tap.value, tap.slope];
    std::array::from_fn(|i| found[i].0[LANE] - TAP[i])
}

/// Delay, gain, offset and lag of a sensor that had 0.25 s, 2, 0.5 m and 0.125 s before.
pub fn sensor<E: Effect>(values: Values, t: f64) -> [f64; 4] {
    let mut pickup = PICKUP;
    E::sensor(&values, t, &mut pickup);
    [pickup.delay, pickup.gain, pickup.offset, pickup.lag]
}

#[track_caller]
pub fn near(found: f64, truth: f64) {
    let error = (found - truth).abs();
    assert!(
        error <= 1e-11 * truth.abs() + 1e-13,
        "{found} instead of {truth}"
    );
}

/// The slope of a force at `x`.
pub fn slope(force: impl Fn(f64) -> f64, x: f64, nudge: f64) -> f64 {
    (force(x + nudge) - force(x - nudge)) / (2.0 * nudge)
}

/// Everything that an effect may change.
fn made_of<E: Effect>(values: Values, at: &At) -> Vec<f64> {
    let mut all = vec![
        tyre::<E>(values, at),
        body::<E>(values, at),
        acceleration::<E>(values, at, 90.0),
    ];
    all.extend(road::<E>(values, at));
    all.extend(sensor::<E>(values, at.t));
    all
}

/// The same without one.
fn plain(at: &At) -> Vec<f64> {
    let forces = [60e3 * at.d + 500.0 * at.w, PUSH, 90.0 / 30.0];
    let sensor = [PICKUP.delay, PICKUP.gain, PICKUP.offset, PICKUP.lag];
    [&forces[..], &[0.0; 4], &sensor].concat()
}

/// Instants all over the ride, as the axle and the bicycle may move there.
fn instants() -> impl Iterator<Item = At> {
    (0..100_usize).map(|i| {
        let of = |four: [f64; 4], by: usize| four[(i / by) % 4];
        At {
            d: of([2.9e-3, -2.9e-3, 4e-4, -1e-4], 1),
            w: of([0.2, -0.06, -0.3, 0.01], 3),
            z: of([1e-3, -2e-3, 5e-4, -1e-4], 1),
            v: of([-0.1, 0.2, 0.03, -0.004], 3),
            t: i as f64 + 0.5,
            speed: of([2.0, 6.5, 9.0, 0.1], 1),
            speed_rate: of([0.5, -2.0, 3.0, -0.1], 1),
            crank: 0.7 * i as f64,
            distance: 4.0 * i as f64,
            states: [
                of([-3e-4, 2e-4, 1e-3, -2e-3], 2),
                of([0.1, -0.2, 0.03, -0.05], 5),
            ],
            ..AT
        }
    })
}

fn is_changed<E: Effect>(values: Values, at: &At) -> bool {
    let same = |(found, truth): (&f64, &f64)| (found - truth).abs() <= 1e-13 * (1.0 + truth.abs());
    !made_of::<E>(values, at).iter().zip(&plain(at)).all(same)
}

/// Every start lies within the limits of the fit.
pub fn starts_lie_within_limits<E: Effect>() {
    let starts = (E::SPEC.starts)(&Scale::TYPICAL);
    assert!(!starts.is_empty());
    for start in starts {
        lies_within_limits::<E>(&start);
    }
}

#[track_caller]
pub fn lies_within_limits<E: Effect>(values: &Values) {
    for (parameter, value) in E::SPEC.parameters.iter().zip(values) {
        let [low, high] = (parameter.limits)(&Scale::TYPICAL);
        assert!(
            (low..=high).contains(value),
            "{} = {value}, limits {low} to {high}",
            parameter.name
        );
    }
}

/// The same, and with its amplitudes at zero a start changes nothing, though by itself it changes something.
pub fn starts_grow_from_nothing<E: Effect>() {
    starts_lie_within_limits::<E>();
    assert!(!E::SPEC.amplitudes.is_empty());
    for start in (E::SPEC.starts)(&Scale::TYPICAL) {
        assert!(
            instants().any(|at| is_changed::<E>(start, &at)),
            "{start:?} changes nothing"
        );
        let mut none = start;
        for a in E::SPEC.amplitudes {
            none[*a] = 0.0;
        }
        changes_nothing::<E>(none);
    }
}

#[track_caller]
pub fn changes_nothing<E: Effect>(values: Values) {
    for at in instants() {
        assert!(
            !is_changed::<E>(values, &at),
            "{:?} instead of {:?}",
            made_of::<E>(values, &at),
            plain(&at)
        );
    }
}

/// The limits of the fit are these, parameter by parameter, no step is longer than the way between them, and the law has values
/// at all of them.
#[track_caller]
pub fn limits_are<E: Effect>(expected: &[[f64; 2]]) {
    let parameters = E::SPEC.parameters;
    assert_eq!(parameters.len(), expected.len());
    for (parameter, [low, high]) in parameters.iter().zip(expected) {
        let found = (parameter.limits)(&Scale::TYPICAL);
        near(found[0], *low);
        near(found[1], *high);
        let size = (parameter.size)(&Scale::TYPICAL);
        assert!(0.0 < size && size < high - low, "{}", parameter.name);
    }
    for corner in 0..1 << expected.len() {
        let mut values = [0.0; MAX_PARAMETERS];
        for (q, limits) in expected.iter().enumerate() {
            values[q] = limits[corner >> q & 1];
        }
        for at in instants() {
            let mut all = made_of::<E>(values, &at);
            all.extend(rates::<E>(values, &at));
            assert!(all.iter().all(|x| x.is_finite()), "{values:?}: {all:?}");
        }
    }
}

/// What is reported under the number `r` is physical while the value `q` lies within these, all else being as given, and not
/// just beyond.
#[track_caller]
pub fn physical_within<E: Effect>(values: Values, [q, r]: [usize; 2], [low, high]: [f64; 2]) {
    let nudge = 1e-6 * (high - low);
    for (value, physical) in [
        (low - nudge, false),
        (low + nudge, true),
        (high - nudge, true),
        (high + nudge, false),
    ] {
        let mut values = values;
        values[q] = value;
        let reported = &(E::SPEC.report)(&values, &Scale::TYPICAL)[r];
        assert_eq!(reported.physical, physical, "{} at {value}", reported.name);
    }
}

/// What is reported of these values.
pub fn report<E: Effect>(values: Values) -> Vec<f64> {
    let reported = (E::SPEC.report)(&values, &Scale::TYPICAL);
    reported.iter().map(|reported| reported.value).collect()
}

/// What is reported leads back to the values.
#[track_caller]
pub fn comes_back<E: Effect>(values: Values) {
    let back = E::from_reported(&report::<E>(values), &Scale::TYPICAL);
    for (back, value) in back.into_iter().zip(values) {
        near(back, value);
    }
}

/// Asserts that a mode whose turn has this square (1/s^2) is stable in the integrator's coarsest step, which follows from the square that the
/// effect states: the classical Runge-Kutta method is stable up to 2 sqrt 2 rad a step.
pub fn is_stable(fastest: f64, stated: f64) {
    let step = Scale::TYPICAL.step.min(COARSE / stated.sqrt());
    let turn = fastest.sqrt() * step;
    assert!(turn < 8_f64.sqrt(), "{turn} rad a step");
}
