//! The user's own law among the effects. It stands in the sizes of the ride; what has to be known of it before is its shape.

use std::borrow::Cow;
use std::sync::OnceLock;

use crate::law::own::{OwnLaw, OwnMotion, OwnParameter, Where};
use crate::law::*;
use veloid_core::numerics::lanes::LANES;

/// What distinguishes one law's plan from another's.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Shape {
    /// 1 to [`MAX_PARAMETERS`].
    parameters: u8,
    /// 0 to [`MAX_OWN_STATES`].
    states: u8,
    /// Which parameter the force is linear in, and 0 without it; past the last for none.
    amplitude: u8,
    has_corners: bool,
    acts: Where,
}

impl Shape {
    pub fn of(law: &OwnLaw) -> Self {
        Self {
            parameters: law.parameters.len().clamp(1, MAX_PARAMETERS) as u8,
            states: law.states().min(MAX_OWN_STATES) as u8,
            amplitude: law.amplitude.unwrap_or(MAX_PARAMETERS) as u8,
            has_corners: law.has_corners(),
            acts: law.acts,
        }
    }

    fn number(self) -> usize {
        let number = self.parameters as usize - 1;
        let number = number * (MAX_OWN_STATES + 1) + self.states as usize;
        let number = number * (MAX_PARAMETERS + 1) + self.amplitude as usize;
        (2 * number + self.has_corners as usize) * PLACES + self.acts as usize
    }

    /// Its plan, made when it is first asked for: there are thousands of shapes, and a ride has one at most.
    pub fn spec(self) -> &'static Spec {
        SPECS[self.number()].get_or_init(|| Box::new(spec(self)))
    }
}

/// Ways of [`Where`].
const PLACES: usize = 4;
const SHAPES: usize = MAX_PARAMETERS * (MAX_OWN_STATES + 1) * (MAX_PARAMETERS + 1) * 2 * PLACES;

static SPECS: [OnceLock<Box<Spec>>; SHAPES] = [const { OnceLock::new() }; SHAPES];

const PARAMETERS: &[Parameter; MAX_PARAMETERS] = &[
    own::<0>(),
    own::<1>(),
    own::<2>(),
    own::<3>(),
    own::<4>(),
    own::<5>(),
    own::<6>(),
    own::<7>(),
    own::<8>(),
    own::<9>(),
    own::<10>(),
    own::<11>(),
];
/// Their numbers.
const NUMBERS: &[usize; MAX_PARAMETERS] = &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11];

const fn own<const Q: usize>() -> Parameter {
    Parameter {
        name: "own",
        unit: "-",
        size: |s| parameter(s, Q).map_or(1.0, OwnParameter::size),
        limits: |s| parameter(s, Q).map_or([0.0, 1.0], |p| p.range),
    }
}

fn parameter(scale: &Scale, q: usize) -> Option<&OwnParameter> {
    scale.own.as_ref()?.parameters.get(q)
}

fn spec(shape: Shape) -> Spec {
    let amplitude = shape.amplitude as usize;
    Spec {
        id: "own_law",
        acts: match shape.acts {
            Where::Front => Acts::Front,
            Where::Rear => Acts::Rear,
            Where::Each => Acts::OneAxle,
            Where::Both => Acts::Both,
        },
        parameters: &PARAMETERS[..usize::from(shape.parameters)],
        amplitudes: NUMBERS.get(amplitude..=amplitude).unwrap_or_default(),
        size_parameter: if amplitude < MAX_PARAMETERS {
            amplitude
        } else {
            0
        },
        starts: |s| s.own.as_ref().map_or_else(Vec::new, |law| law.starts()),
        report: |p, s| {
            let law = s.own.iter().flat_map(|law| &law.parameters);
            law.zip(p)
                .map(|(parameter, value)| reported(parameter, *value))
                .collect()
        },
        stiffens: |p, s| steepest(p, s)[0],
        damps: |p, s| steepest(p, s)[1],
        states: shape.states as usize,
        corners: shape.has_corners,
        words: "a custom law",
        ..Spec::ORDINARY
    }
}

fn reported(parameter: &OwnParameter, value: f64) -> Reported {
    let [low, high] = parameter.range;
    let unit = match parameter.unit.as_str() {
        "" => "-",
        unit => unit,
    };
    Reported {
        name: Cow::Owned(parameter.name.clone()),
        unit: Cow::Owned(unit.to_owned()),
        value,
        physical: (low..=high).contains(&value),
    }
}

/// Part of the range of motion over which slopes are taken.
const NUDGE: f64 = 1e-3;
/// Times the RMS of deflection and rate that the motion goes.
const REACH: f64 = 2.5;

/// The stiffness (N/m) and damping (N s/m) that a law adds at most within the motion: slopes of its force, and of its states'
/// rates against the states, which decay as a damping of the mass does.
fn steepest(p: &Values, scale: &Scale) -> [f64; 2] {
    let Some(law) = &scale.own else {
        return [0.0; 2];
    };
    let p = p.map(Lanes::all);
    let sizes = [scale.d_rms, scale.w_rms, scale.z_rms, scale.v_rms].map(|rms| REACH * rms);
    let places = |size: f64, by: usize| {
        Lanes(std::array::from_fn(|lane| {
            size * ((by * lane) % LANES) as f64 * 2.0 / (LANES - 1) as f64 - size
        }))
    };
    let at = |d: f64, w: f64, x: f64| {
        let motion = [
            places(sizes[0], 1) + d * sizes[0],
            places(sizes[1], 3) + w * sizes[1],
            places(sizes[2], 5) - d * sizes[2],
            places(sizes[3], 7) - w * sizes[3],
            Lanes::all(scale.mean_speed),
            Lanes::all(0.5 * scale.train_s),
            Lanes::ZERO,
            Lanes::all(0.5 * scale.train_distance / scale.wheel_radius),
        ];
        let states = [Lanes::all(x); MAX_OWN_STATES];
        let mut rates = [Lanes::ZERO; MAX_OWN_STATES];
        law.rates(&p, &motion, &states, &mut rates);
        (law.force(&p, &motion, &states), rates)
    };
    let most = |a: Lanes, b: Lanes, by: f64| {
        let slopes = a.0.iter().zip(b.0).map(|(a, b)| (b - a).abs() / by);
        slopes.filter(|slope| slope.is_finite()).fold(0.0, f64::max)
    };
    let (force, rates) = at(0.0, 0.0, 0.0);
    let (by_height, _) = at(NUDGE, 0.0, 0.0);
    let (by_rate, _) = at(0.0, NUDGE, 0.0);
    let stiffness = most(force, by_height, NUDGE * sizes[0].min(sizes[2]));
    let damping = most(force, by_rate, NUDGE * sizes[1].min(sizes[3]));
    let (_, by_state) = at(0.0, 0.0, NUDGE * sizes[0]);
    let decay = (0..law.states()).map(|q| most(rates[q], by_state[q], NUDGE * sizes[0]));
    [
        stiffness,
        damping.max(scale.mass * decay.fold(0.0, f64::max)),
    ]
}

/// The motion as expressions know it.
fn motion(m: &Motion) -> OwnMotion {
    let wheel = m.distance / m.scale.wheel_radius;
    let [speed, t, crank, wheel] = [m.speed, m.t, m.crank.angle, wheel].map(Lanes::all);
    [m.d, m.w, m.z, m.v, speed, t, crank, wheel]
}

#[inline(always)]
pub fn tyre(p: &LaneValues, m: &Motion, s: &[Lanes], force: Lanes) -> Lanes {
    match &m.scale.own {
        Some(law) if !law.is_on_body => force + law.force(p, &motion(m), s) * m.per_mass,
        _ => force,
    }
}

#[inline(always)]
pub fn body(p: &LaneValues, m: &Motion, s: &[Lanes], force: Lanes) -> Lanes {
    match &m.scale.own {
        Some(law) if law.is_on_body => force + law.force(p, &motion(m), s) * m.per_mass,
        _ => force,
    }
}

#[inline(always)]
pub fn rates(p: &LaneValues, m: &Motion, s: &[Lanes], rates: &mut [Lanes]) {
    if let Some(law) = &m.scale.own {
        law.rates(p, &motion(m), s, rates);
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::sync::Arc;

    use super::*;
    use crate::effects::Kind;
    use crate::effects::testing::{AT, At, PUSH, near, on_lane};

    /// A progressive spring and a Maxwell branch, whose parameters are c, g and tau.
    const TYRE: &str = r#"
        id = "leaky"
        force = "c * d * abs(d) + g * q"
        parameters.c = { unit = "N/m^2", start = [1e6, 2e6], range = [0.0, 1e8] }
        parameters.g = { unit = "N/m", start = 1e4, range = [-1e5, 1e5] }
        parameters.tau = { unit = "s", start = 0.02, range = [1e-3, 1.0] }
        states.q = "w - q / tau"
    "#;
    const VALUES: Values = padded([3e6, 2e4, 0.05]);

    fn read(text: &str) -> (&'static Spec, Scale) {
        let law = OwnLaw::read(text).unwrap();
        let spec = Shape::of(&law).spec();
        let own = Some(Arc::new(law));
        let scale = Scale {
            own,
            ..Scale::TYPICAL
        };
        (spec, scale)
    }

    /// Forces (N) of tyre and mass, and the rate of the first state.
    fn made(scale: &Scale, values: Values, at: &At) -> [f64; 3] {
        let found = on_lane(scale, values, at, |p, m, s| {
            let plain = m.kappa * m.d + m.beta * m.w;
            let push = m.per_mass * PUSH;
            let mut moved = [Lanes::ZERO; MAX_OWN_STATES];
            rates(p, m, s, &mut moved);
            [tyre(p, m, s, plain), body(p, m, s, push), moved[0]]
        });
        [30.0 * found[0], 30.0 * found[1], found[2]]
    }

    #[test]
    fn a_law_of_the_tyre_comes_to_its_force_and_moves_its_state() {
        let (_, scale) = read(TYRE);
        for (d, w, q) in [(1e-3, 0.1, 0.0), (-2e-3, 0.1, 1e-3), (2e-3, -0.3, -5e-4)] {
            let states = [q, 0.0];
            let at = At { d, w, states, ..AT };
            let [tyre, body, rate] = made(&scale, VALUES, &at);
            near(tyre, 60e3 * d + 500.0 * w + 3e6 * d * f64::abs(d) + 2e4 * q);
            near(body, PUSH);
            near(rate, w - q / 0.05);
        }
    }

    #[test]
    fn a_law_that_speaks_of_the_mass_alone_comes_to_the_other_forces() {
        let (_, scale) = read(
            r#"id = "drag"
            force = "-a * z_dot * abs(z_dot) + a * wheel / (1 + t) + a * speed"
            parameters.a = { start = 1, range = [0, 50] }"#,
        );
        for (v, t) in [(0.2, 0.0), (-0.3, 4.0)] {
            let distance = 3.4;
            let at = At {
                d: 1e-3,
                v,
                t,
                distance,
                ..AT
            };
            let [tyre, body, _] = made(&scale, padded([20.0]), &at);
            near(tyre, 60.0);
            // 3.4 m are ten turns (rad) of a wheel of 0.34 m.
            let law = 20.0 * (-v * f64::abs(v) + 10.0 / (1.0 + t) + 5.0);
            near(body, PUSH + law);
        }
    }

    #[test]
    fn starts_limits_and_what_is_physical_are_those_of_the_file() {
        let (spec, scale) = read(TYRE);
        assert_eq!(
            (spec.starts)(&scale),
            [padded([1e6, 1e4, 0.02]), padded([2e6, 1e4, 0.02])]
        );
        let ranges = [[0.0, 1e8], [-1e5, 1e5], [1e-3, 1.0]];
        for (q, [low, high]) in ranges.into_iter().enumerate() {
            assert_eq!((spec.parameters[q].limits)(&scale), [low, high]);
            for (value, physical) in [
                (low, true),
                (high, true),
                (low - 1e-6 * (high - low), false),
                (high + 1e-6 * (high - low), false),
            ] {
                let mut values = VALUES;
                values[q] = value;
                let reported = &(spec.report)(&values, &scale);
                assert_eq!(reported.len(), 3);
                assert_eq!(reported[q].value, value);
                assert_eq!(reported[q].physical, physical, "{value}");
            }
        }
        let sizes = [0, 1, 2].map(|q| (spec.parameters[q].size)(&scale));
        assert_eq!(sizes, [2e6, 1e4, 0.02]);
    }

    #[test]
    fn what_is_reported_leads_back_to_the_values() {
        let law = OwnLaw::read(TYRE).unwrap();
        let kind = Kind::Own(Shape::of(&law));
        let back = kind.values_of(&VALUES[..3], &Scale::TYPICAL);
        assert_eq!(back, VALUES);
    }

    #[test]
    fn without_its_amplitude_a_law_does_nothing() {
        let (spec, scale) = read(
            r#"id = "tanh"
            force = "f * tanh(w / width)"
            parameters.f = { start = 20, range = [0, 100] }
            parameters.width = { start = 0.01, range = [1e-3, 1] }"#,
        );
        assert_eq!(spec.amplitudes, [0]);
        for w in [-0.2, 0.005] {
            let force = |f: f64| made(&scale, padded([f, 0.01]), &At { w, ..AT })[0];
            near(force(0.0), 500.0 * w);
            near(force(20.0), 500.0 * w + 20.0 * f64::tanh(w / 0.01));
        }
    }

    /// Deflections up to 2.5 mm and rates up to 0.25 m/s, 2.5 times their RMS.
    #[test]
    fn the_integrator_is_told_the_steepest_slopes_within_the_motion() {
        let (spec, scale) = read(
            r#"id = "cubic"
            force = "a * d^3 + b * w * abs(w)"
            parameters.a = { start = 1e9, range = [0, 1e12] }
            parameters.b = { start = 10, range = [0, 1e4] }"#,
        );
        let values = padded([2e9, 300.0]);
        let stiffness = (spec.stiffens)(&values, &scale);
        let truth = 3.0 * 2e9 * 2.5e-3 * 2.5e-3;
        assert!((stiffness / truth - 1.0).abs() < 0.01, "{stiffness}");
        let damping = (spec.damps)(&values, &scale);
        let truth = 2.0 * 300.0 * 0.25;
        assert!((damping / truth - 1.0).abs() < 0.01, "{damping}");
    }

    /// A state that decays at 20/s does so as a mass of 30 kg would by 600 N s/m.
    #[test]
    fn the_decay_of_a_state_counts_as_damping() {
        let (spec, scale) = read(TYRE);
        let damping = (spec.damps)(&VALUES, &scale);
        assert!((damping / 600.0 - 1.0).abs() < 1e-9, "{damping}");
    }

    #[test]
    fn every_shape_has_its_own_plan() {
        let acts = [Where::Front, Where::Rear, Where::Each, Where::Both];
        let mut numbers = Vec::new();
        for (parameters, states) in (1..=12).flat_map(|p| (0..=6).map(move |s| (p, s))) {
            for (amplitude, acts) in (0..=12).flat_map(|a| acts.map(|acts| (a, acts))) {
                for has_corners in [false, true] {
                    let shape = Shape {
                        parameters,
                        states,
                        amplitude,
                        has_corners,
                        acts,
                    };
                    numbers.push(shape.number());
                    let spec = shape.spec();
                    assert_eq!(spec.parameters.len(), usize::from(parameters));
                    assert_eq!((spec.states, spec.corners), (states.into(), has_corners));
                    let linear: Vec<usize> = (amplitude < 12)
                        .then(|| amplitude.into())
                        .into_iter()
                        .collect();
                    assert_eq!(spec.amplitudes, linear);
                }
            }
        }
        numbers.sort_unstable();
        assert_eq!(numbers, (0..SHAPES).collect::<Vec<_>>());
    }
}
