//! What effects say of themselves in expressions is what their code computes.

use std::collections::BTreeMap;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::testing::{At, on_lane};
use super::{ALL, Kind};
use crate::law::own::evaluated;
use crate::law::{Lanes, MAX_PARAMETERS, MAX_STATES, Pickup, Scale, Spot, Tap, Values};

const MASS: f64 = 30.0;

fn motion(rng: &mut ChaCha8Rng) -> At {
    let mut within = |most: f64| rng.random_range(-most..most);
    At {
        d: within(4e-3),
        w: within(0.3),
        z: within(4e-3),
        v: within(0.3),
        t: 50.0 + within(50.0),
        speed: 4.0 + within(3.9),
        speed_rate: within(2.0),
        crank: within(100.0),
        distance: 300.0 + within(300.0),
        states: [within(2e-3), within(0.1)],
        felt_after: 1e-3,
        step: 1e-3,
    }
}

fn values(kind: Kind, rng: &mut ChaCha8Rng) -> Values {
    let spec = kind.spec();
    let mut values = [0.0; MAX_PARAMETERS];
    for (value, parameter) in values.iter_mut().zip(spec.parameters) {
        let size = (parameter.size)(&Scale::TYPICAL);
        let [low, high] = (parameter.limits)(&Scale::TYPICAL);
        *value = (size * rng.random_range(-2.0..3.0)).clamp(low, high);
    }
    if !spec.formula.choices.is_empty() {
        values[spec.parameters.len()] = f64::from(rng.random_range(-1_i8..=1));
    }
    values
}

/// Everything that formulas may name.
fn known(kind: Kind, values: &Values, at: &At) -> BTreeMap<String, f64> {
    let scale = &Scale::TYPICAL;
    let mut known = kind.numbers(values, scale);
    let states = kind.spec().formula.states.iter().zip(at.states);
    let states = states.map(|((name, _), value)| (*name, value));
    let names = [
        ("d", at.d),
        ("w", at.w),
        ("z", at.z),
        ("z_dot", at.v),
        ("t", at.t),
        ("speed", at.speed),
        ("crank", at.crank),
        ("k", 60e3),
        ("B", 500.0),
        ("m", MASS),
        ("speed_rate", at.speed_rate),
        ("distance", at.distance),
        ("dt", at.step),
        ("felt_after", at.felt_after),
    ];
    known.extend(
        names
            .into_iter()
            .chain(states)
            .map(|(n, v)| (n.to_owned(), v)),
    );
    known
}

fn added(text: &str, known: &BTreeMap<String, f64>) -> f64 {
    match text {
        "" => 0.0,
        text => evaluated(text, known),
    }
}

/// What the code makes of a motion: tyre's force and the others (N), acceleration, rates, and how the road is read.
fn by_code(kind: Kind, values: Values, at: &At, forces: [f64; 3]) -> [f64; 9] {
    let scale = &Scale::TYPICAL;
    on_lane(scale, values, at, |p, m, s| {
        let [tyre, body, force] = forces.map(|force| Lanes::all(force / MASS));
        let [tyre, body] = kind.forces(p, m, s, [tyre, body]);
        let mut rates = [Lanes::ZERO; MAX_STATES];
        let acceleration = kind.moved(p, m, s, force, &mut rates);
        if kind.spec().carries {
            rates[1] += tyre / p[0];
        }
        let mut tap = Tap {
            shift: Lanes::ZERO,
            half_window: Lanes::ZERO,
            value: Lanes::ZERO,
            slope: Lanes::ZERO,
        };
        let spot = Spot {
            speed: at.speed,
            distance: at.distance,
        };
        kind.road(p, &spot, scale, &mut tap);
        let [tyre, body] = [tyre * MASS, body * MASS];
        let [value, slope] = [tap.value, tap.slope];
        let [rate, other] = rates;
        let road = [tap.shift, tap.half_window, value, slope];
        let [shift, half_window, value, slope] = road;
        [
            tyre,
            body,
            acceleration,
            rate,
            other,
            shift,
            half_window,
            value,
            slope,
        ]
    })
}

fn by_formula(kind: Kind, values: Values, at: &At, forces: [f64; 3]) -> [f64; 9] {
    let formula = &kind.spec().formula;
    let mut known = known(kind, &values, at);
    let [tyre, body, force] = forces;
    known.insert("tyre".to_owned(), tyre);
    let tyre = tyre + added(formula.tyre, &known);
    let body = body + added(formula.body, &known);
    known.insert("tyre".to_owned(), tyre);
    known.insert("acceleration".to_owned(), force / MASS);
    let acceleration = match formula.acceleration {
        "" => force / MASS,
        text => evaluated(text, &known),
    };
    let rate = |q: usize| {
        let rate = formula.states.get(q);
        rate.map_or(0.0, |(_, rate)| evaluated(rate, &known))
    };
    let road = [
        formula.shift,
        formula.half_window,
        formula.height,
        formula.slope,
    ];
    let [shift, half_window, value, slope] = road.map(|text| added(text, &known));
    let [rate, other] = [rate(0), rate(1)];
    [
        tyre,
        body,
        acceleration,
        rate,
        other,
        shift,
        half_window,
        value,
        slope,
    ]
}

#[test]
fn every_formula_is_what_its_code_computes() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    for kind in ALL.iter().copied() {
        let formula = &kind.spec().formula;
        assert_eq!(formula.states.len(), kind.spec().states, "{}", kind.id());
        for _ in 0..200 {
            let (at, values) = (motion(&mut rng), values(kind, &mut rng));
            let forces = [-250.0, 40.0, 3.0].map(|f| f * rng.random_range(0.2..2.0));
            let code = by_code(kind, values, &at, forces);
            let written = by_formula(kind, values, &at, forces);
            for (i, (a, b)) in code.iter().zip(written).enumerate() {
                let off = (a - b).abs();
                assert!(
                    off <= 1e-7 * a.abs().max(b.abs()) + 1e-9,
                    "{} {i}: {a} is written as {b} at {values:?}",
                    kind.id()
                );
            }
        }
    }
}

#[test]
fn every_sensor_reads_as_its_formula_says() {
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    for kind in ALL.iter().copied() {
        let formula = &kind.spec().formula;
        let (at, values) = (motion(&mut rng), values(kind, &mut rng));
        let mut pickup = Pickup {
            delay: 0.0,
            gain: 1.0,
            offset: 0.0,
            lag: 0.0,
        };
        kind.sensor(&values, at.t, &mut pickup);
        let known = known(kind, &values, &at);
        let gain = match formula.gain {
            "" => 1.0,
            text => evaluated(text, &known),
        };
        let [delay, offset, lag] =
            [formula.delay, formula.offset, formula.lag].map(|text| added(text, &known));
        let written = [delay, gain, offset, lag];
        let code = [pickup.delay, pickup.gain, pickup.offset, pickup.lag];
        for (a, b) in code.into_iter().zip(written) {
            assert!(
                (a - b).abs() <= 1e-12,
                "{}: {a} is written as {b}",
                kind.id()
            );
        }
    }
}

#[test]
fn every_effect_is_written_down_but_the_coupling_of_the_axles() {
    for kind in ALL {
        let is_written = kind.law(&Scale::TYPICAL).expressions().next().is_some();
        assert_eq!(is_written, *kind != Kind::PitchCoupling, "{}", kind.id());
    }
}
