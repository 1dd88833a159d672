use crate::law::*;

/// A relaxing spring beside the tyre's own (Maxwell branch, standard linear solid):
/// f' = k1 w - f/tau.
pub struct ViscoelasticTyre;

const BRANCH: Parameter = Parameter {
    name: "branch_stiffness",
    unit: "N/m",
    size: |s| 0.2 * s.k_size(),
    limits: |s| [0.0, 100.0 * s.k_size()],
};

const TIME: Parameter = Parameter {
    name: "relaxation_time",
    unit: "s",
    size: |_| 0.01,
    limits: |s| [0.3 * s.step, 0.3 * s.train_s],
};

impl Effect for ViscoelasticTyre {
    const SPEC: Spec = Spec {
        id: "viscoelastic_tyre",
        acts: Acts::OneAxle,
        parameters: &[BRANCH, TIME],
        amplitudes: &[0],
        starts: |s| {
            let period = s.period();
            [0.06, 0.15, 0.4, 1.0, 3.0].map(|f| padded([(BRANCH.size)(s), f * period])).to_vec()
        },
        report: |p, s| {
            vec![
                reported(&BRANCH, p[0], [0.0, (BRANCH.limits)(s)[1]]),
                reported(&TIME, p[1], [0.5 * s.step, (TIME.limits)(s)[1]]),
            ]
        },
        stiffens: |p, _| p[0],
        states: 1,
        law: "f with f' = branch_stiffness w - f / relaxation_time (Maxwell branch)",
        formula: Formula {
            tyre: "branch_stiffness * stretch",
            states: &[("stretch", "w - stretch / relaxation_time")],
            ..Formula::NONE
        },
        words: "the tyre relaxes: part of its stiffness acts only while the deflection changes",
        confused_with: &["sprung_mass", "sensor_delay"],
        noun: "a viscoelastic stiffness of {branch_stiffness} with a relaxation time of {relaxation_time}",
        source: "Dressel & Sadauckas 2020, Appl. Sci. 10:3156 (dynamic over static stiffness)",
        replaces_spring: true,
        relaxes: true,
        ..Spec::ORDINARY
    };

    #[inline(always)]
    fn tyre(p: &LaneValues, m: &Motion, s: &States, force: Lanes) -> Lanes {
        force + p[0] * m.per_mass * s[0]
    }

    /// The state is f/k1, a length.
    #[inline(always)]
    fn rates(p: &LaneValues, m: &Motion, s: &States) -> States {
        [m.w - s[0] / p[1], Lanes::ZERO]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::testing::*;

    const VALUES: Values = padded([2e4, 0.02]);

    #[test]
    fn the_branch_is_stretched_by_the_rate_and_relaxes() {
        for (w, s) in [(0.1, 0.0), (0.1, 1e-3), (-0.3, 1e-3), (0.0, -2e-3)] {
            let at = At { d: 1e-3, w, states: [s, 0.0], ..AT };
            near(rates::<ViscoelasticTyre>(VALUES, &at)[0], w - s / 0.02);
            near(tyre::<ViscoelasticTyre>(VALUES, &at), 60.0 + 500.0 * w + 2e4 * s);
        }
    }

    /// f = k1 tau w (1 - e^(-t/tau)): in the end a damper of k1 tau = 400 N s/m.
    #[test]
    fn at_a_steady_rate_the_branch_becomes_a_damper() {
        for w in [0.1, -0.2] {
            for t in [0.005, 0.02, 0.1, 1.0] {
                let force = 2e4 * later::<ViscoelasticTyre>(VALUES, &At { w, ..AT }, t)[0];
                let truth = 400.0 * w * (1.0 - f64::exp(-t / 0.02));
                assert!((force - truth).abs() < 1e-6, "{force} instead of {truth} at {t} s");
            }
        }
    }

    #[test]
    fn at_once_it_is_as_stiff_as_the_integrator_is_told() {
        let told = (ViscoelasticTyre::SPEC.stiffens)(&VALUES, &Scale::TYPICAL);
        let seconds = 1e-7;
        let state = later::<ViscoelasticTyre>(VALUES, &At { w: 0.1, ..AT }, seconds)[0];
        let found = (tyre::<ViscoelasticTyre>(VALUES, &At { states: [state, 0.0], ..AT })) / (0.1 * seconds);
        assert!((found / told - 1.0).abs() < 1e-4, "{found} instead of {told}");
    }

    #[test]
    fn starts_limits_and_what_is_physical() {
        starts_grow_from_nothing::<ViscoelasticTyre>();
        limits_are::<ViscoelasticTyre>(&[[0.0, 6e6], [1.5e-3, 18.0]]);
        physical_within::<ViscoelasticTyre>(VALUES, [0, 0], [0.0, 6e6]);
        physical_within::<ViscoelasticTyre>(VALUES, [1, 1], [2.5e-3, 18.0]);
        comes_back::<ViscoelasticTyre>(VALUES);
    }
}
