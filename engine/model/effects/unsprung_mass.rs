use crate::law::*;

/// A wheel of share mu of the mass stands on the tyre and carries the rest, which is z, on its own
/// spring and damper: a fork or suspension stage. The integrator takes the tyre's deflection from
/// the wheel's states.
pub struct UnsprungMass;

const FRACTION: Parameter = Parameter {
    name: "mass_fraction",
    unit: "-",
    size: |_| 0.05,
    limits: |_| [0.005, 0.9],
};
const FREQUENCY: Parameter = Parameter {
    name: "natural_frequency",
    unit: "Hz",
    size: |s| 1.0 / s.period(),
    limits: |s| [0.1 / s.period(), 1.5 / s.step],
};
const DAMPING: Parameter = Parameter {
    name: "damping_ratio",
    unit: "-",
    size: |_| 0.1,
    limits: |_| [0.0, 3.0],
};

/// Least share of the mass that a wheel with its tyre has: a light one of 1.2 kg under a wheel that carries 48 kg.
const LIGHTEST: f64 = 0.025;

/// Share that is expected before the ride, and its deviation. A wheel with tyre and hub has 1.2 to 2.5 kg, fork legs or a swing arm 0 to 2 kg
/// more (manufacturers' data), on axles that carry 20 to 65 kg: 0.02 to 0.2.
const SHARE: f64 = 0.1;
const SHARE_STD: f64 = 0.1;

impl UnsprungMass {
    /// Force of the suspension on the upper mass, over the whole axle mass.
    #[inline(always)]
    fn lift(p: &LaneValues, m: &Motion, s: &States) -> Lanes {
        let w = p[1] * std::f64::consts::TAU;
        (Lanes::all(1.0) - p[0]) * w * (w * (s[0] - m.z) + p[2] * (s[1] - m.v) * 2.0)
    }
}

impl Effect for UnsprungMass {
    const SPEC: Spec = Spec {
        id: "unsprung_mass",
        acts: Acts::OneAxle,
        needs: &[Need::Mass],
        parameters: &[FRACTION, FREQUENCY, DAMPING],
        amplitudes: &[],
        size_parameter: 1,
        stronger: Stronger::Smaller,
        starts: |s| {
            let f0 = 1.0 / s.period();
            let mut starts = Vec::new();
            for fraction in [0.08, 0.25] {
                for f in [1.5, 2.5, 4.0] {
                    for zeta in [0.1, 0.4] {
                        starts.push(padded([fraction, f * f0, zeta]));
                    }
                }
            }
            starts
        },
        report: |p, s| {
            vec![
                reported(&FRACTION, p[0], [LIGHTEST, 0.8]),
                reported(&FREQUENCY, p[1], [0.2 / s.period(), 1.0 / s.step]),
                reported(&DAMPING, p[2], [0.0, 1.5]),
            ]
        },
        stiffens: |p, s| s.k_size() / p[0].max(0.01),
        alone: |[tyre, tyre_damping], p| {
            let w = p[1] * std::f64::consts::TAU;
            let [spring, damping] = [(1.0 - p[0]) * w * w, (1.0 - p[0]) * 2.0 * p[2] * w];
            // Two springs in series; each damper sees its own share of the deflection.
            let share = spring / (tyre + spring);
            [
                tyre * share,
                tyre_damping * share * share + damping * (1.0 - share) * (1.0 - share),
            ]
        },
        // Of two springs in series below the mass that is measured either may be the tyre: from u to z
        // k1 k2 / ((m1 s^2 + k1 + k2) (m2 s^2 + k2) - k2^2) is the same with k1' = k2 M/m2, k2' = k1 m2/M; dampers likewise.
        twin: Some(|[tyre, tyre_damping], p| {
            let w = p[1] * std::f64::consts::TAU;
            let turn = tyre.max(0.0).sqrt();
            let ratio = tyre_damping / (2.0 * turn).max(f64::MIN_POSITIVE);
            ([w * w, 2.0 * p[2] * w], padded([p[0], turn / std::f64::consts::TAU, ratio]))
        }),
        states: 2,
        second_mass: true,
        carries: true,
        expected: &[(0, SHARE, SHARE_STD)],
        law: "a share (mass_fraction) of the mass stands on the tyre and carries the rest, z, on a spring and damper (natural_frequency, damping_ratio)",
        formula: Formula {
            acceleration: "(acceleration + (1 - mass_fraction) * 2 * pi * natural_frequency * (2 * pi * natural_frequency * (height - z) + 2 * damping_ratio * (velocity - z_dot))) / (1 - mass_fraction)",
            states: &[
                ("height", "velocity"),
                ("velocity", "(tyre / m - (1 - mass_fraction) * 2 * pi * natural_frequency * (2 * pi * natural_frequency * (height - z) + 2 * damping_ratio * (velocity - z_dot))) / mass_fraction"),
            ],
            ..Formula::NONE
        },
        words: "the wheel is a separate mass on the tyre, below a fork or suspension stage",
        confused_with: &["viscoelastic_tyre", "sensor_delay", "tyre_enveloping"],
        noun: "an unsprung mass of {mass_fraction} of the axle's mass at {natural_frequency} with a damping ratio of {damping_ratio}",
        source: "Schoeneck & Nagurka, BMD 2023 (quarter car of a bicycle)",
        ..Spec::ORDINARY
    };

    /// With the wheel between tyre and mass, the suspension's force takes the tyre's place.
    #[inline(always)]
    fn inertia(p: &LaneValues, m: &Motion, s: &States, force: Lanes) -> Lanes {
        (force + Self::lift(p, m, s)) / (Lanes::all(1.0) - p[0])
    }

    /// Rates of the wheel's height and velocity without the tyre's force, which the integrator adds.
    #[inline(always)]
    fn rates(p: &LaneValues, m: &Motion, s: &States) -> States {
        [s[1], -(Self::lift(p, m, s) / p[0])]
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::effects::testing::*;

    use nalgebra::Complex;

    const TAU: f64 = std::f64::consts::TAU;
    /// Of 30 kg 6 kg are the wheel; the suspension has the rest at 3 Hz.
    const VALUES: Values = padded([0.2, 3.0, 0.25]);

    /// Without the tyre, whose force the integrator adds to the wheel's.
    #[test]
    fn what_the_suspension_lifts_it_presses_on_the_wheel() {
        let w = 3.0 * TAU;
        for (z, v, wheel) in [(1e-3, 0.0, [0.0, 0.0]), (-2e-3, 0.1, [1e-3, -0.05]), (0.0, -0.2, [-3e-3, 0.1])] {
            let lift = 24.0 * (w * w * (wheel[0] - z) + 2.0 * 0.25 * w * (wheel[1] - v));
            let at = At { z, v, states: wheel, ..AT };
            let [moved, pressed] = rates::<UnsprungMass>(VALUES, &at);
            near(moved, wheel[1]);
            near(6.0 * pressed, -lift);
            near(24.0 * acceleration::<UnsprungMass>(VALUES, &at, 90.0), 90.0 + lift);
        }
    }

    /// Below a mass that stands still, the wheel swings on the suspension alone, (1 - mu)/mu as fast in its square.
    #[test]
    fn the_wheel_swings_on_its_suspension() {
        let values = padded([0.2, 3.0]);
        for t in [0.03, 0.1, 0.4] {
            let found = later::<UnsprungMass>(values, &At { states: [2e-3, 0.0], ..AT }, t)[0];
            assert!((found - 2e-3 * f64::cos(2.0 * 3.0 * TAU * t)).abs() < 1e-9, "{found} at {t} s");
        }
    }

    /// What a spring and damper have between two heights, over the whole mass (1/s^2).
    fn branch(stiffness: f64, damping: f64, w: f64) -> Complex<f64> {
        Complex::new(stiffness, w * damping)
    }

    /// From the road to the mass that is measured.
    fn answer([tyre, tyre_damping]: [f64; 2], p: &Values, w: f64) -> Complex<f64> {
        let own = p[1] * TAU;
        let tyre = branch(tyre, tyre_damping, w);
        let spring = branch((1.0 - p[0]) * own * own, (1.0 - p[0]) * 2.0 * p[2] * own, w);
        let [wheel, upper] = [p[0], 1.0 - p[0]].map(|mass| -mass * w * w);
        tyre * spring / ((tyre + spring + wheel) * (spring + upper) - spring * spring)
    }

    #[test]
    fn twins_answer_to_the_road_in_the_same_way() {
        let base = [2000.0, 500.0 / 30.0];
        let twin = UnsprungMass::SPEC.twin.unwrap();
        let (other_base, other) = twin(base, &VALUES);
        assert!((other[1] / VALUES[1] - 1.0).abs() > 0.1);
        for hertz in [0.3, 2.0, 5.0, 12.0, 40.0] {
            let [one, two] = [answer(base, &VALUES, TAU * hertz), answer(other_base, &other, TAU * hertz)];
            assert!((one - two).norm() < 1e-12 * one.norm(), "{one} and {two} at {hertz} Hz");
        }
        let (back_base, back) = twin(other_base, &other);
        for (back, value) in back_base.into_iter().chain(back).zip(base.into_iter().chain(VALUES)) {
            near(back, value);
        }
    }

    /// Two in series: 1 / (1/a + 1/b), here at a frequency so low that masses do not matter.
    #[test]
    fn an_axle_alone_moves_slowly_as_with_its_wheel() {
        let base = [2000.0, 500.0 / 30.0];
        let [kappa, beta] = (UnsprungMass::SPEC.alone)(base, &VALUES);
        let (own, w) = (3.0 * TAU, 1e-4);
        let series = 1.0 / (1.0 / branch(base[0], base[1], w) + 1.0 / branch(0.8 * own * own, 0.8 * 0.5 * own, w));
        assert!((kappa / series.re - 1.0).abs() < 1e-9);
        assert!((beta / (series.im / w) - 1.0).abs() < 1e-9);
    }

    /// The tyre moves the wheel's 6 kg as a stiffness of five times its own moves 30 kg.
    #[test]
    fn the_integrator_is_told_how_stiff_the_tyre_is_to_the_wheel() {
        near((UnsprungMass::SPEC.stiffens)(&VALUES, &Scale::TYPICAL), 60e3 / 0.2);
        near((UnsprungMass::SPEC.stiffens)(&padded([0.005, 3.0, 0.1]), &Scale::TYPICAL), 60e3 / 0.01);
    }

    #[test]
    fn starts_limits_and_what_is_physical() {
        let f0 = f64::sqrt(2000.0) / TAU;
        starts_lie_within_limits::<UnsprungMass>();
        limits_are::<UnsprungMass>(&[[0.005, 0.9], [0.1 * f0, 300.0], [0.0, 3.0]]);
        physical_within::<UnsprungMass>(VALUES, [0, 0], [0.025, 0.8]);
        physical_within::<UnsprungMass>(VALUES, [1, 1], [0.2 * f0, 200.0]);
        physical_within::<UnsprungMass>(VALUES, [2, 2], [0.0, 1.5]);
        comes_back::<UnsprungMass>(VALUES);
    }

    #[test]
    fn no_mode_turns_so_fast_that_the_integrator_blows_up() {
        for start in (UnsprungMass::SPEC.starts)(&Scale::TYPICAL) {
            let told = (60e3 + (UnsprungMass::SPEC.stiffens)(&start, &Scale::TYPICAL)) / 30.0;
            let [share, spring] = [start[0], (1.0 - start[0]) * (start[1] * TAU).powi(2)];
            let [wheel, above] = [(2000.0 + spring) / share, spring / (1.0 - share)];
            let mean = 0.5 * (wheel + above);
            let fastest = mean + f64::sqrt(mean * mean - 2000.0 * spring / share / (1.0 - share));
            is_stable(fastest, told);
        }
    }
}
