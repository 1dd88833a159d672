use crate::diagnosis::law::*;

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
            [0.06, 0.15, 0.4, 1.0, 3.0].map(|f| [(BRANCH.size)(s), f * period, 0.0, 0.0]).to_vec()
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
        words: "the tyre relaxes: part of its stiffness acts only while the deflection changes",
        confused_with: &["sprung_mass", "sensor_delay"],
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
