use crate::law::*;

/// A share mu of the axle mass rides on its own spring and damper above the rest, which is z: a rider
/// on the saddle, luggage, a second stage.
pub struct SprungMass;

pub(super) const FRACTION: Parameter = Parameter {
    name: "mass_fraction",
    unit: "-",
    size: |_| 0.1,
    limits: |_| [0.0, 0.97],
};
pub(super) const FREQUENCY: Parameter = Parameter {
    name: "natural_frequency",
    unit: "Hz",
    size: |s| 0.3 / s.period(),
    limits: |s| [0.3 / s.train_s, 0.45 / s.step],
};
pub(super) const DAMPING: Parameter = Parameter {
    name: "damping_ratio",
    unit: "-",
    size: |_| 0.1,
    limits: |_| [0.0, 3.0],
};

/// Least share of the mass that is one of its own. A lighter one is no rider or luggage: on a free decay (a bicycle's fork as a
/// pendulum, ../shared/real) a mass of 6e-5 with the axle's own frequency and a start of its own bends the envelope as friction does.
const LIGHTEST: f64 = 5e-3;

impl SprungMass {
    /// Acceleration that spring and damper give the sprung mass.
    #[inline(always)]
    pub(super) fn pull(p: &LaneValues, m: &Motion, s: &States) -> Lanes {
        let w = p[1] * std::f64::consts::TAU;
        w * (w * (m.z - s[0]) + p[2] * (m.v - s[1]) * 2.0)
    }
}

impl Effect for SprungMass {
    const SPEC: Spec = Spec {
        id: "sprung_mass",
        acts: Acts::OneAxle,
        needs: &[Need::Mass],
        parameters: &[FRACTION, FREQUENCY, DAMPING],
        amplitudes: &[0],
        starts: |s| {
            let f0 = 1.0 / s.period();
            let mut hertz = [0.15, 0.3, 0.5, 0.75, 1.0, 1.4, 2.0, 3.0].map(|f| f * f0).to_vec();
            // Where the axle moves faster than that its mode may be as fast, and on a drive, which has hardly a
            // spring and drifts, faster.
            let moves = s.a_rms / s.v_rms / std::f64::consts::TAU;
            let most = if f0 < 0.1 * moves { f64::INFINITY } else { 2.0 * moves };
            let top = most.min(0.4 / s.step);
            let mut f = 4.5 * f0;
            while f < top {
                hertz.push(f);
                f *= 1.5;
            }
            let each = |f: f64| [0.07, 0.3].map(|zeta| padded([0.1, f, zeta]));
            hertz.into_iter().flat_map(each).collect()
        },
        nearer: |p, s, zoom| {
            let ratio = 1.5_f64.powf(0.5_f64.powi(zoom as i32));
            let fastest = 0.45 / s.step;
            let each = |f: f64| [p[2], 0.4 * p[2]].map(|zeta| padded([0.1, f.min(fastest), zeta]));
            [p[1] * ratio, p[1] / ratio].into_iter().flat_map(each).collect()
        },
        report: |p, s| {
            vec![
                reported(&FRACTION, p[0], [LIGHTEST, 0.95]),
                reported(&FREQUENCY, p[1], [0.5 / s.train_s, 0.4 / s.step]),
                reported(&DAMPING, p[2], [0.0, 0.9]),
            ]
        },
        states: 2,
        second_mass: true,
        law: "a share (mass_fraction) of the mass rides on a spring and damper of its own (natural_frequency, damping_ratio) above z",
        formula: Formula {
            acceleration: "(acceleration - mass_fraction * 2 * pi * natural_frequency * (2 * pi * natural_frequency * (z - height) + 2 * damping_ratio * (z_dot - velocity))) / (1 - mass_fraction)",
            states: &[
                ("height", "velocity"),
                ("velocity", "2 * pi * natural_frequency * (2 * pi * natural_frequency * (z - height) + 2 * damping_ratio * (z_dot - velocity))"),
            ],
            ..Formula::NONE
        },
        words: "part of the mass rides on its own spring (rider on the saddle, luggage)",
        confused_with: &["viscoelastic_tyre", "sensor_delay", "pitch_coupling"],
        noun: "a sprung mass of {mass_fraction} of the axle's mass at {natural_frequency} with a damping ratio of {damping_ratio}",
        source: "Fairley & Griffin 1989, J. Biomech. 22:81-94 (seated body)",
        case_of: Some("hardening_mass"),
        ..Spec::ORDINARY
    };

    #[inline(always)]
    fn inertia(p: &LaneValues, m: &Motion, s: &States, force: Lanes) -> Lanes {
        (force - p[0] * Self::pull(p, m, s)) / (Lanes::all(1.0) - p[0])
    }

    /// Position and velocity of the sprung mass, from its place at rest.
    #[inline(always)]
    fn rates(p: &LaneValues, m: &Motion, s: &States) -> States {
        [s[1], Self::pull(p, m, s)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::testing::*;

    const TAU: f64 = std::f64::consts::TAU;

    #[test]
    fn spring_and_damper_pull_the_two_masses_towards_each_other() {
        let values = padded([0.2, 2.0, 0.15]);
        let w = 2.0 * TAU;
        for (z, v, above) in [(1e-3, 0.0, [0.0, 0.0]), (-2e-3, 0.1, [1e-3, -0.05]), (0.0, -0.2, [-3e-3, 0.1])] {
            let pull = w * w * (z - above[0]) + 2.0 * 0.15 * w * (v - above[1]);
            let at = At { z, v, states: above, ..AT };
            let [moved, pulled] = rates::<SprungMass>(values, &at);
            near(moved, above[1]);
            near(pulled, pull);
            // 24 kg are moved by the force and by what 6 kg above them pull.
            near(acceleration::<SprungMass>(values, &at, 90.0), (90.0 - 6.0 * pull) / 24.0);
        }
    }

    /// Above an axle that stands still the mass swings at its own frequency, and dies away by its own damping.
    #[test]
    fn the_mass_above_swings_at_its_natural_frequency() {
        let [f, zeta] = [2.5, 0.1];
        let at = At { z: 1e-3, states: [3e-3, 0.0], ..AT };
        let w = f * TAU;
        let turn = w * f64::sqrt(1.0 - zeta * zeta);
        for t in [0.05, 0.2, 0.7] {
            let swing = f64::exp(-zeta * w * t) * (f64::cos(turn * t) + zeta * w / turn * f64::sin(turn * t));
            let found = later::<SprungMass>(padded([0.2, f, zeta]), &at, t)[0];
            assert!((found - (1e-3 + 2e-3 * swing)).abs() < 1e-9, "{found} at {t} s");
        }
    }

    #[test]
    fn both_masses_rest_together() {
        let values = padded([0.2, 2.5, 0.1]);
        let settled = later::<SprungMass>(values, &At { z: 1e-3, ..AT }, 20.0);
        assert!((settled[0] - 1e-3).abs() < 1e-12 && settled[1].abs() < 1e-12);
        near(acceleration::<SprungMass>(values, &At { z: 1e-3, states: [1e-3, 0.0], ..AT }, 48.0), 48.0 / 24.0);
    }

    #[test]
    fn starts_limits_and_what_is_physical() {
        starts_grow_from_nothing::<SprungMass>();
        limits_are::<SprungMass>(&[[0.0, 0.97], [0.005, 90.0], [0.0, 3.0]]);
        let values = padded([0.2, 2.0, 0.1]);
        physical_within::<SprungMass>(values, [0, 0], [5e-3, 0.95]);
        physical_within::<SprungMass>(values, [1, 1], [0.5 / 60.0, 80.0]);
        physical_within::<SprungMass>(values, [2, 2], [0.0, 0.9]);
        comes_back::<SprungMass>(values);
    }

    #[test]
    fn starts_nearer_by_surround_the_best_one_within_the_limits() {
        for (zoom, root) in [(1, 2.0), (2, 4.0)] {
            let ratio = f64::powf(1.5, 1.0 / root);
            let starts = (SprungMass::SPEC.nearer)(&padded([0.3, 4.0, 0.2]), &Scale::TYPICAL, zoom);
            let mut expected = Vec::new();
            for f in [4.0 * ratio, 4.0 / ratio] {
                expected.extend([padded([0.1, f, 0.2]), padded([0.1, f, 0.08])]);
            }
            for (start, expected) in starts.iter().flatten().zip(expected.iter().flatten()) {
                near(*start, *expected);
            }
            assert_eq!(starts.len(), 4);
        }
        for start in (SprungMass::SPEC.nearer)(&padded([0.3, 85.0, 0.2]), &Scale::TYPICAL, 1) {
            lies_within_limits::<SprungMass>(&start);
        }
    }

    /// On a drive, which hardly has a spring, modes start up to what the logger shows: 0.4 of its rate.
    #[test]
    fn starts_go_as_high_as_the_axle_moves_fast() {
        let highest = |scale: &Scale| {
            let starts = (SprungMass::SPEC.starts)(scale);
            starts.iter().map(|start| start[1]).fold(0.0, f64::max)
        };
        let typical = f64::sqrt(2000.0) / TAU;
        near(highest(&Scale::TYPICAL), 3.0 * typical);
        let drive = highest(&Scale { k: 1.0, ..Scale::TYPICAL });
        assert!((80.0 / 1.5..80.0).contains(&drive), "{drive}");
    }

    /// Two masses on the tyre's spring and the other's, over the whole mass.
    #[test]
    fn no_mode_turns_so_fast_that_the_integrator_blows_up() {
        for start in (SprungMass::SPEC.starts)(&Scale::TYPICAL) {
            let told = (60e3 + (SprungMass::SPEC.stiffens)(&start, &Scale::TYPICAL)) / 30.0;
            let [share, spring] = [start[0], start[0] * (start[1] * TAU).powi(2)];
            let [below, above] = [(2000.0 + spring) / (1.0 - share), spring / share];
            let mean = 0.5 * (below + above);
            let fastest = mean + f64::sqrt(mean * mean - 2000.0 * spring / share / (1.0 - share));
            is_stable(fastest, told);
        }
    }
}
